// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/unfold/strip_map.h"

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <queue>
#include <set>

#include "geometry/core/errors.h"

namespace mv {
namespace {

/// Clamp of the cotangent weights: bijectivity needs positive ones, the solver bounded ones.
constexpr double weight_min = 0.05, weight_max = 20;

std::size_t at(long i) { return static_cast<std::size_t>(i); }

std::vector<std::vector<std::pair<int, double>>> neighbours(const RawMesh& mesh) {
  std::vector<std::vector<std::pair<int, double>>> list(mesh.points.size());
  std::set<std::pair<int, int>> seen;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = std::min(t[k], t[(k + 1) % 3]), b = std::max(t[k], t[(k + 1) % 3]);
      if (!seen.insert({a, b}).second) continue;
      const double d = (mesh.points[at(a)] - mesh.points[at(b)]).norm();
      list[at(a)].emplace_back(b, d);
      list[at(b)].emplace_back(a, d);
    }
  return list;
}

/// Shortest way from `start` to any target that passes no other border point.
std::vector<int> shortest_path(const RawMesh& mesh, int start, const std::vector<char>& on_border, const std::vector<char>& is_target) {
  const auto near = neighbours(mesh);
  std::vector<double> distance(mesh.points.size(), 1e300);
  std::vector<int> before(mesh.points.size(), -1);
  using Item = std::pair<double, int>;
  std::priority_queue<Item, std::vector<Item>, std::greater<>> queue;
  distance[at(start)] = 0;
  queue.push({0, start});
  while (!queue.empty()) {
    const auto [d, v] = queue.top();
    queue.pop();
    if (d > distance[at(v)]) continue;
    if (is_target[at(v)]) {
      std::vector<int> path{v};
      while (before[at(path.back())] >= 0) path.push_back(before[at(path.back())]);
      std::reverse(path.begin(), path.end());
      return path;
    }
    if (on_border[at(v)] && v != start) continue;
    for (const auto& [w, length] : near[at(v)])
      if (d + length < distance[at(w)]) {
        distance[at(w)] = d + length;
        before[at(w)] = v;
        queue.push({distance[at(w)], w});
      }
  }
  throw InputError("leaflets: no way leads from the annulus to the free edge");
}

}  // namespace

std::vector<double> edge_distances(const RawMesh& mesh, const std::vector<int>& from) {
  const auto near = neighbours(mesh);
  std::vector<double> distance(mesh.points.size(), 1e300);
  using Item = std::pair<double, int>;
  std::priority_queue<Item, std::vector<Item>, std::greater<>> queue;
  for (int v : from) {
    distance[at(v)] = 0;
    queue.push({0, v});
  }
  while (!queue.empty()) {
    const auto [d, v] = queue.top();
    queue.pop();
    if (d > distance[at(v)]) continue;
    for (const auto& [w, length] : near[at(v)])
      if (d + length < distance[at(w)]) {
        distance[at(w)] = d + length;
        queue.push({distance[at(w)], w});
      }
  }
  return distance;
}

StripMap::StripMap(const Ring& ring, double period) : ring_(ring), period_(period) {
  for (const auto& t : ring.mesh.triangles) {
    std::array<double, 3> c{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& x = ring.mesh.points[at(t[k])];
      const Vec3 a = ring.mesh.points[at(t[(k + 1) % 3])] - x, b = ring.mesh.points[at(t[(k + 2) % 3])] - x;
      const double area = a.cross(b).norm();
      c[k] = area > 0 ? 0.5 * a.dot(b) / area : weight_max;
    }
    cotangent_.push_back(c);
  }
  // Clamped is the sum over both sides of an edge; its triangles then share it evenly.
  std::map<std::pair<int, int>, std::pair<double, int>> edges;
  const auto edge_of = [&](std::size_t t, std::size_t k) {
    const int a = ring.mesh.triangles[t][(k + 1) % 3], b = ring.mesh.triangles[t][(k + 2) % 3];
    return std::pair{std::min(a, b), std::max(a, b)};
  };
  for (std::size_t t = 0; t < cotangent_.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      auto& [sum, count] = edges[edge_of(t, k)];
      sum += cotangent_[t][k];
      ++count;
    }
  for (std::size_t t = 0; t < cotangent_.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& [sum, count] = edges.at(edge_of(t, k));
      cotangent_[t][k] = std::clamp(sum, weight_min, weight_max) / count;
    }
  mark_cut();
}

void StripMap::mark_cut() {
  const RawMesh& mesh = ring_.mesh;
  std::vector<char> on_border(mesh.points.size(), 0), is_target(mesh.points.size(), 0);
  for (int v : ring_.annulus) on_border[at(v)] = 1;
  for (int v : ring_.free_edge) on_border[at(v)] = is_target[at(v)] = 1;
  const std::vector<int> path = shortest_path(mesh, ring_.annulus.front(), on_border, is_target);
  std::map<std::pair<int, int>, int> triangle_of;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) triangle_of[{mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]}] = static_cast<int>(t);
  std::set<std::pair<int, int>> cut;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    cut.insert({path[i], path[i + 1]});
    cut.insert({path[i + 1], path[i]});
  }
  beyond_.assign(mesh.triangles.size(), {0, 0, 0});
  // The last annulus edge ends at the cut's first point: its triangle sees that point a period further, and so does every triangle on that side.
  const int seed = triangle_of.at({ring_.annulus.back(), ring_.annulus.front()});
  const std::set<int> on_path(path.begin(), path.end());
  // Triangles around the path, connected across edges that have a path point and are not cut.
  std::vector<int> queue{seed};
  std::set<int> side{seed};
  for (std::size_t q = 0; q < queue.size(); ++q) {
    const auto& tri = mesh.triangles[at(queue[q])];
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = tri[k], b = tri[(k + 1) % 3];
      if (!on_path.count(a) && !on_path.count(b)) continue;
      if (cut.count({a, b})) continue;
      const auto other = triangle_of.find({b, a});
      if (other != triangle_of.end() && side.insert(other->second).second) queue.push_back(other->second);
    }
  }
  for (int t : side)
    for (std::size_t k = 0; k < 3; ++k) beyond_[at(t)][k] = on_path.count(mesh.triangles[at(t)][k]) > 0;
}

std::vector<double> StripMap::solve(const std::vector<double>& fixed_value, const std::vector<char>& is_fixed, double period) const {
  const RawMesh& mesh = ring_.mesh;
  std::vector<int> unknown(mesh.points.size(), -1);
  int count = 0;
  for (std::size_t i = 0; i < unknown.size(); ++i)
    if (!is_fixed[i]) unknown[i] = count++;
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd rhs = Eigen::VectorXd::Zero(count);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
      const double w = cotangent_[t][k];
      const double jump = (beyond_[t][i] - beyond_[t][j]) * period;  // of corner i over corner j
      const int a = mesh.triangles[t][i], b = mesh.triangles[t][j];
      for (const auto& [p, q, sign] : {std::tuple{a, b, 1.0}, std::tuple{b, a, -1.0}}) {
        const int row = unknown[at(p)];
        if (row < 0) continue;
        entries.emplace_back(row, row, w);
        rhs[row] -= w * sign * jump;
        if (unknown[at(q)] >= 0)
          entries.emplace_back(row, unknown[at(q)], -w);
        else
          rhs[row] += w * fixed_value[at(q)];
      }
    }
  Eigen::SparseMatrix<double> matrix(count, count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(matrix);
  if (solver.info() != Eigen::Success) throw GateError("leaflets: the flat pattern could not be computed (singular system)");
  const Eigen::VectorXd x = solver.solve(rhs);
  std::vector<double> values(fixed_value);
  for (std::size_t i = 0; i < values.size(); ++i)
    if (unknown[i] >= 0) values[i] = x[unknown[i]];
  return values;
}

std::vector<double> StripMap::along(const std::vector<double>& u_annulus, const std::vector<double>& u_free_edge) const {
  std::vector<double> value(ring_.mesh.points.size(), 0);
  std::vector<char> fixed(value.size(), 0);
  for (std::size_t i = 0; i < ring_.annulus.size(); ++i) {
    value[at(ring_.annulus[i])] = u_annulus[i];
    fixed[at(ring_.annulus[i])] = 1;
  }
  for (std::size_t i = 0; i < u_free_edge.size(); ++i) {
    value[at(ring_.free_edge[i])] = u_free_edge[i];
    fixed[at(ring_.free_edge[i])] = 1;
  }
  return solve(value, fixed, period_);
}

std::vector<double> StripMap::across() const {
  std::vector<double> value(ring_.mesh.points.size(), 0);
  std::vector<char> fixed(value.size(), 0);
  for (int v : ring_.annulus) fixed[at(v)] = 1;
  for (int v : ring_.free_edge) {
    fixed[at(v)] = 1;
    value[at(v)] = 1;
  }
  return solve(value, fixed, 0);
}

long StripMap::folds(const std::vector<double>& u, const std::vector<double>& t) const {
  long count = 0;
  for (std::size_t i = 0; i < ring_.mesh.triangles.size(); ++i) {
    const auto& tri = ring_.mesh.triangles[i];
    std::array<Vec2, 3> p;
    for (std::size_t k = 0; k < 3; ++k) p[k] = {u[at(tri[k])] + beyond_[i][k] * period_, t[at(tri[k])]};
    const Vec2 a = p[1] - p[0], b = p[2] - p[0];
    // Seen from the atrium u runs to the left and t down: triangles keep their sense.
    count += !(a.x() * b.y() - a.y() * b.x() > 0);
  }
  return count;
}

}  // namespace mv
