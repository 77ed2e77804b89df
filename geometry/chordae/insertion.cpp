// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/chordae/insertion.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <queue>
#include <string>

#include "geometry/core/errors.h"

namespace mv {
namespace {

// Nodes at most this many elements apart are joined by straight lines (half as many quadratic elements, whose nodes lie twice as
// close): the graph distance is then at most 4.5 % too long.
constexpr int rings = 4;
// A straight line shorter than the path along edges by more than this leaves the tissue (it crosses a slit); paths along the
// edges of a grid of right angles are at most sqrt(3) times as long as the line.
constexpr double detour_limit = 1.75;
// The weights are a share of one, so this is round-off of a sum over the nodes.
constexpr double weight_tolerance = 1e-12;
constexpr int max_active_set_rounds = 200;
constexpr double height_share = 0.75;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// Diagonal (HRZ) share of an element's volume that each node carries.
double node_share(int nodes_per_tet, int local) {
  if (nodes_per_tet == 4) return 0.25;
  return local < 4 ? 1.0 / 36.0 : 4.0 / 27.0;
}

std::string text(const Vec3& x) {
  return "(" + std::to_string(x.x()) + ", " + std::to_string(x.y()) + ", " + std::to_string(x.z()) + ") mm";
}

}  // namespace

LeafletGraph::LeafletGraph(const LeafletMesh& mesh) : mesh_(&mesh) {
  const std::size_t n = mesh.points.size();
  if (n == 0 || mesh.tets.empty()) throw InputError("chordae: the leaflet mesh is empty; run the mesh stage first");
  if (mesh.side.size() != n)
    throw InputError("chordae: leaflet array 'side' has " + std::to_string(mesh.side.size()) + " entries for " +
                     std::to_string(n) + " points");
  const int per_tet = mesh.nodes_per_tet();
  std::vector<std::vector<int>> adjacent(n);
  volume_.assign(n, 0.0);
  for (const auto& tet : mesh.tets) {
    for (int i = 0; i < per_tet; ++i)
      if (tet[at(i)] < 0 || at(tet[at(i)]) >= n)
        throw InputError("chordae: a leaflet element refers to point " + std::to_string(tet[at(i)]));
    const Vec3 &a = mesh.points[at(tet[0])], &b = mesh.points[at(tet[1])], &c = mesh.points[at(tet[2])],
               &d = mesh.points[at(tet[3])];
    const double volume = std::abs((b - a).cross(c - a).dot(d - a)) / 6.0;
    for (int i = 0; i < per_tet; ++i) {
      volume_[at(tet[at(i)])] += volume * node_share(per_tet, i);
      for (int j = 0; j < per_tet; ++j)
        if (i != j) adjacent[at(tet[at(i)])].push_back(tet[at(j)]);
    }
  }
  neighbour_begin_.assign(n + 1, 0);
  for (std::size_t i = 0; i < n; ++i) {
    auto& list = adjacent[i];
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    neighbours_.insert(neighbours_.end(), list.begin(), list.end());
    neighbour_begin_[i + 1] = static_cast<int>(neighbours_.size());
  }
}

std::vector<LeafletGraph::Reached> LeafletGraph::within(const Vec3& target, double radius) const {
  // The straight distance never exceeds the one along the leaflet, so nothing outside this ball can be reached.
  std::vector<int> ball;
  int seed = -1;
  double seed_distance = std::numeric_limits<double>::max();
  for (std::size_t i = 0; i < mesh_->points.size(); ++i) {
    if (neighbour_begin_[i] == neighbour_begin_[i + 1]) continue;  // a point of no element
    const double d = (mesh_->points[i] - target).norm();
    if (d < radius) ball.push_back(static_cast<int>(i));
    if (d < seed_distance) {
      seed_distance = d;
      seed = static_cast<int>(i);
    }
  }
  if (seed < 0 || seed_distance >= radius) return {};
  std::map<int, int> local_of;
  for (std::size_t k = 0; k < ball.size(); ++k)
    local_of[ball[k]] = static_cast<int>(k);
  std::vector<std::vector<int>> adjacent(ball.size());
  for (std::size_t k = 0; k < ball.size(); ++k)
    for (int e = neighbour_begin_[at(ball[k])]; e < neighbour_begin_[at(ball[k]) + 1]; ++e)
      if (const auto it = local_of.find(neighbours_[at(e)]); it != local_of.end()) adjacent[k].push_back(it->second);

  // Nodes at most `reach` elements from `centre` whose straight line to it stays in the tissue.
  const std::size_t reach = mesh_->order == 2 ? rings / 2 : rings;
  std::vector<int> stamp(ball.size(), -1);
  std::vector<double> path(ball.size(), 0.0);
  const auto length = [&](int i, int j) { return (mesh_->points[at(ball[at(i)])] - mesh_->points[at(ball[at(j)])]).norm(); };
  const auto ring_of = [&](int centre, int tag) {
    std::vector<int> found{centre};
    stamp[at(centre)] = tag;
    path[at(centre)] = 0;
    for (std::size_t begin = 0, ring = 0; ring < reach; ++ring) {
      const std::size_t end = found.size();
      for (; begin < end; ++begin)
        for (int j : adjacent[at(found[begin])]) {
          const double through = path[at(found[begin])] + length(found[begin], j);
          if (stamp[at(j)] != tag) {
            stamp[at(j)] = tag;
            path[at(j)] = through;
            found.push_back(j);
          } else {
            path[at(j)] = std::min(path[at(j)], through);
          }
        }
    }
    std::erase_if(found, [&](int j) { return path[at(j)] > detour_limit * length(centre, j); });
    return found;
  };

  std::vector<double> distance(ball.size(), std::numeric_limits<double>::max());
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  const int seed_local = local_of.at(seed);
  for (int k : ring_of(seed_local, static_cast<int>(ball.size()))) {
    distance[at(k)] = (mesh_->points[at(ball[at(k)])] - target).norm();
    queue.emplace(distance[at(k)], k);
  }
  while (!queue.empty()) {
    const auto [d, k] = queue.top();
    queue.pop();
    if (d > distance[at(k)]) continue;
    for (int j : ring_of(k, k)) {
      const double through = d + length(k, j);
      if (through < distance[at(j)]) {
        distance[at(j)] = through;
        if (through < radius) queue.emplace(through, j);
      }
    }
  }
  std::vector<Reached> reached;
  for (std::size_t k = 0; k < ball.size(); ++k)
    if (distance[k] < radius) reached.push_back({ball[k], distance[k]});
  return reached;
}

namespace {

// Corrects `weight` (start w0) so that the weighted mean of `positions` is `end`; see the header. Nodes whose weight would become
// negative leave the set, smallest first in rounds, and the rest is solved again. False when that fails.
bool correct_to_end(const std::vector<Vec3>& positions, const Vec3& end, double radius, std::vector<double>& weight) {
  const std::vector<double> start = weight;
  std::vector<char> is_active(start.size(), 1);
  for (int round = 0; round < max_active_set_rounds; ++round) {
    Eigen::Matrix4d moments = Eigen::Matrix4d::Zero();
    for (std::size_t i = 0; i < start.size(); ++i) {
      if (!is_active[i]) continue;
      Eigen::Vector4d p;
      p << 1.0, (positions[i] - end) / radius;
      moments += start[i] * p * p.transpose();
    }
    const Eigen::Vector4d c = moments.completeOrthogonalDecomposition().solve(Eigen::Vector4d::UnitX());
    bool has_negative = false;
    for (std::size_t i = 0; i < start.size(); ++i) {
      if (!is_active[i]) continue;
      Eigen::Vector4d p;
      p << 1.0, (positions[i] - end) / radius;
      weight[i] = start[i] * p.dot(c);
      if (weight[i] < 0) {
        weight[i] = 0;
        is_active[i] = 0;
        has_negative = true;
      }
    }
    if (has_negative) continue;
    double sum = 0;
    Vec3 mean = Vec3::Zero();
    for (std::size_t i = 0; i < weight.size(); ++i) {
      sum += weight[i];
      mean += weight[i] * positions[i];
    }
    return std::abs(sum - 1) < 1e-10 && (mean - end).norm() < 1e-10 * radius + 1e-12 * end.norm();
  }
  return false;
}

}  // namespace

InfluenceSphere influence_sphere(const LeafletGraph& graph, const Vec3& target, double radius, std::optional<Vec3> end) {
  if (!(radius > 0)) throw InputError("chordae: the influence radius must be positive, got " + std::to_string(radius) + " mm");
  const auto reached = graph.within(target, radius);
  const LeafletMesh& mesh = graph.mesh();
  if (reached.empty())
    throw InputError("chordae: no leaflet node within the influence radius " + std::to_string(radius) + " mm of " + text(target) +
                     "; increase chordae.influence_radius or move the insertion");
  bool has_atrial = false, has_ventricular = false;
  std::vector<double> weight;
  std::vector<Vec3> positions;
  double sum = 0;
  for (const auto& r : reached) {
    has_atrial |= mesh.side[at(r.node)] == atrial;
    has_ventricular |= mesh.side[at(r.node)] == ventricular;
    const double s = 1 - (r.distance / radius) * (r.distance / radius);
    weight.push_back(graph.nodal_volume(r.node) * s * s);
    positions.push_back(mesh.points[at(r.node)]);
    sum += weight.back();
  }
  if (!has_atrial || !has_ventricular)
    throw InputError("chordae: the influence sphere of " + std::to_string(radius) + " mm at " + text(target) +
                     " reaches only the " +
                     (has_atrial        ? "atrial"
                      : has_ventricular ? "ventricular"
                                        : "inner") +
                     " nodes of the leaflet; increase chordae.influence_radius above the thickness");
  for (double& w : weight)
    w /= sum;
  if (end && !correct_to_end(positions, *end, radius, weight))
    throw InputError("chordae: the end " + text(*end) + " does not lie among the nodes of its influence sphere of " +
                     std::to_string(radius) + " mm at " + text(target));
  InfluenceSphere sphere;
  // Shares too small to matter are dropped before the sum is made one.
  for (std::size_t i = 0; i < weight.size(); ++i)
    if (weight[i] > weight_tolerance) sphere.weights.emplace_back(reached[i].node, weight[i]);
  double total = 0;
  for (const auto& w : sphere.weights)
    total += w.second;
  for (auto& w : sphere.weights) {
    w.second /= total;
    sphere.end += w.second * mesh.points[at(w.first)];
  }
  return sphere;
}

double influence_radius(double border_length, int primary_count, double height) {
  return std::min(border_length / (2.0 * std::max(primary_count, 1)), height_share * height);
}

InsertionReport check_insertions(const LeafletMesh& mesh, const Chordae& chordae, double tolerance) {
  struct Tally {
    double sum = 0;
    Vec3 mean = Vec3::Zero();
    int nodes = 0, atrial_nodes = 0, ventricular_nodes = 0;
  };
  std::map<int, Tally> tally;
  InsertionReport report;
  report.weight_min = chordae.insertions.empty() ? 0 : std::numeric_limits<double>::max();
  bool is_index_wrong = false;
  for (const Insertion& i : chordae.insertions) {
    if (i.node < 0 || at(i.node) >= mesh.points.size() || i.point < 0 || at(i.point) >= chordae.points.size()) {
      is_index_wrong = true;
      if (report.first_bad_point < 0) report.first_bad_point = i.point;
      continue;
    }
    Tally& t = tally[i.point];
    t.sum += i.weight;
    t.mean += i.weight * mesh.points[at(i.node)];
    ++t.nodes;
    t.atrial_nodes += mesh.side[at(i.node)] == atrial;
    t.ventricular_nodes += mesh.side[at(i.node)] == ventricular;
    report.weight_min = std::min(report.weight_min, i.weight);
  }
  report.ends = static_cast<int>(tally.size());
  report.nodes_min = tally.empty() ? 0 : std::numeric_limits<int>::max();
  for (const auto& [point, t] : tally) {
    const double sum_error = std::abs(t.sum - 1), position_error = (t.mean - chordae.points[at(point)]).norm();
    const bool is_one_faced = t.atrial_nodes == 0 || t.ventricular_nodes == 0;
    report.sum_error_max = std::max(report.sum_error_max, sum_error);
    report.position_error_max = std::max(report.position_error_max, position_error);
    report.nodes_min = std::min(report.nodes_min, t.nodes);
    report.ends_on_one_face += is_one_faced;
    const bool is_bad = !(sum_error < tolerance) || !(position_error < tolerance) || is_one_faced;
    if (is_bad && report.first_bad_point < 0) report.first_bad_point = point;
  }
  // A point at which segments only end must hang on the leaflet.
  std::vector<char> is_start(chordae.points.size(), 0), is_end(chordae.points.size(), 0);
  for (const ChordaSegment& s : chordae.segments) {
    if (s.a < 0 || s.b < 0 || at(s.a) >= is_start.size() || at(s.b) >= is_start.size()) {
      is_index_wrong = true;
      continue;
    }
    is_start[at(s.a)] = 1;
    is_end[at(s.b)] = 1;
  }
  for (std::size_t p = 0; p < is_end.size(); ++p)
    if (is_end[p] && !is_start[p] && !tally.count(static_cast<int>(p))) {
      is_index_wrong = true;
      if (report.first_bad_point < 0) report.first_bad_point = static_cast<int>(p);
    }
  report.passed = !is_index_wrong && report.first_bad_point < 0 && report.weight_min >= 0;
  return report;
}

}  // namespace mv
