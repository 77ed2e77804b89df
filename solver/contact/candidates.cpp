// SPDX-License-Identifier: BSD-3-Clause
#include "solver/contact/candidates.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

#include "geometry/core/errors.h"
#include "geometry/core/parallel.h"
#include "solver/contact/node_lists.h"

namespace mv {
namespace {

using Vec3 = Eigen::Vector3d;

Vec3 point(std::span<const double> x, int node) { return Eigen::Map<const Vec3>(x.data() + 3 * static_cast<std::size_t>(node)); }

/// Distances along the solid's edges from one node to the triangles around it, by Dijkstra's method with early exit.
class SolidDistance {
 public:
  SolidDistance(const ContactSurface& s, std::span<const int> surface_node)
      : s_(s),
        surface_node_(surface_node),
        distance_(static_cast<std::size_t>(s.solid_nodes), unknown),
        triangle_distance_(s.triangles.size(), unknown),
        is_target_(s.triangles.size(), 0) {}

  /// Distance from surface node `from` to the nearest corner of each target triangle; infinity beyond `limit`.
  void compute(int from, std::span<const int> targets, double limit) {
    reset();
    for (int f : targets) is_target_[f] = 1;
    targets_.assign(targets.begin(), targets.end());
    std::size_t left = targets.size();
    push(s_.nodes[from], 0.0);
    while (!heap_.empty() && left > 0) {
      const auto [d, node] = heap_.top();
      heap_.pop();
      if (d > distance_[node]) continue;
      if (d > limit) break;
      left -= settle(node, d);
      for (int e = s_.edge_start[node]; e < s_.edge_start[node + 1]; ++e) {
        const int other = s_.edge_end[e];
        push(other, d + (s_.solid_reference[other] - s_.solid_reference[node]).norm());
      }
    }
  }
  double to(int triangle) const { return triangle_distance_[triangle]; }

 private:
  static constexpr double unknown = std::numeric_limits<double>::infinity();

  void push(int node, double d) {
    if (!(d < distance_[node])) return;
    if (distance_[node] == unknown) touched_.push_back(node);
    distance_[node] = d;
    heap_.emplace(d, node);
  }
  std::size_t settle(int node, double d) {
    std::size_t reached = 0;
    const int n = surface_node_[node];
    if (n < 0) return 0;
    for (int r = s_.ring_start[n]; r < s_.ring_start[n + 1]; ++r) {
      const int f = s_.ring[r];
      if (!is_target_[f] || triangle_distance_[f] != unknown) continue;
      triangle_distance_[f] = d;
      ++reached;
    }
    return reached;
  }
  void reset() {
    for (int n : touched_) distance_[n] = unknown;
    for (int f : targets_) {
      triangle_distance_[f] = unknown;
      is_target_[f] = 0;
    }
    touched_.clear();
    heap_ = {};
  }

  const ContactSurface& s_;
  std::span<const int> surface_node_;
  std::vector<double> distance_, triangle_distance_;
  std::vector<char> is_target_;
  std::vector<int> touched_, targets_;
  std::priority_queue<std::pair<double, int>, std::vector<std::pair<double, int>>, std::greater<>> heap_;
};

}  // namespace

CandidateSearch::CandidateSearch(const ContactSurface& surface, double exclusion_radius, double exclusion_radius_through)
    : surface_(surface),
      exclusion_squared_(static_cast<float>(exclusion_radius * exclusion_radius)),
      exclusion_squared_through_(static_cast<float>(exclusion_radius_through * exclusion_radius_through)),
      exclusion_radius_(exclusion_radius),
      exclusion_radius_through_(exclusion_radius_through) {
  for (const Vec3& p : surface_.reference) rest_node_.push_back(p.cast<float>());
  for (const auto& t : surface_.triangles)
    rest_centre_.push_back(((surface_.reference[t[0]] + surface_.reference[t[1]] + surface_.reference[t[2]]) / 3).cast<float>());
  start_.assign(surface_.nodes.size() + 1, 0);
  find_exceptions();
}

void CandidateSearch::find_exceptions() {
  const int nodes = surface_.node_count(), triangles = surface_.triangle_count();
  std::vector<double> rest(3 * static_cast<std::size_t>(surface_.solid_nodes));
  for (int n = 0; n < surface_.solid_nodes; ++n)
    Eigen::Map<Vec3>(rest.data() + 3 * static_cast<std::size_t>(n)) = surface_.solid_reference[n];
  std::vector<Vec3> node_normal(surface_.nodes.size());
  current_node_normals(surface_, rest, node_normal);
  std::vector<int> surface_node(static_cast<std::size_t>(surface_.solid_nodes), -1);
  for (int n = 0; n < nodes; ++n) surface_node[surface_.nodes[n]] = n;

  BoxGrid grid;
  Vec3 lower = surface_.reference[0], upper = lower;
  for (const Vec3& p : surface_.reference) {
    lower = lower.cwiseMin(p);
    upper = upper.cwiseMax(p);
  }
  const double margin = 1e-3 * exclusion_radius_through_ + 1e-6 * (upper - lower).norm();  // covers single precision
  grid.reset(lower, upper, std::max(0.5 * exclusion_radius_through_, surface_.mean_edge));
  grid.sort(triangles, [&](int f) { return grid.cell_index(grid.cell(rest_centre_[f].cast<double>())); });

  std::vector<std::vector<int>> exceptions(surface_.nodes.size());
  parallel_ranges(nodes, [&](std::ptrdiff_t begin, std::ptrdiff_t end, int) {
    SolidDistance along_solid(surface_, surface_node);
    std::vector<int> near;
    for (std::ptrdiff_t n = begin; n < end; ++n) {
      near.clear();
      const Vec3 reach = Vec3::Constant(exclusion_radius_through_ + margin);
      grid.for_runs(grid.cell(surface_.reference[n] - reach), grid.cell(surface_.reference[n] + reach), [&](int first, int last) {
        for (int k = first; k < last; ++k) {
          const int f = grid.item(k);
          const float limit = is_same_face(static_cast<int>(n), f) ? exclusion_squared_ : exclusion_squared_through_;
          if ((rest_node_[n] - rest_centre_[f]).squaredNorm() < limit) near.push_back(f);
        }
      });
      along_solid.compute(static_cast<int>(n), near, 2 * exclusion_radius_through_);
      for (int f : near) {
        const auto& t = surface_.triangles[f];
        const Vec3 a = surface_.reference[t[0]];
        const Vec3 normal = (surface_.reference[t[1]] - a).cross(surface_.reference[t[2]] - a).normalized();
        const bool faces_at_rest = normal.dot(node_normal[n]) < facing_cosine && normal.dot(surface_.reference[n] - a) > 0;
        const double radius = is_same_face(static_cast<int>(n), f) ? exclusion_radius_ : exclusion_radius_through_;
        if (along_solid.to(f) > (faces_at_rest ? 1.0 : 2.0) * radius) exceptions[n].push_back(f);
      }
      std::sort(exceptions[n].begin(), exceptions[n].end());
    }
  });
  exception_start_.assign(surface_.nodes.size() + 1, 0);
  for (int n = 0; n < nodes; ++n) {
    exception_start_[n + 1] = exception_start_[n] + static_cast<int>(exceptions[n].size());
    exception_.insert(exception_.end(), exceptions[n].begin(), exceptions[n].end());
  }
}

bool CandidateSearch::is_exception(int node, int triangle) const {
  return std::binary_search(exception_.begin() + exception_start_[node], exception_.begin() + exception_start_[node + 1],
                            triangle);
}

bool CandidateSearch::is_excluded(int node, int triangle) const {
  const float limit = is_same_face(node, triangle) ? exclusion_squared_ : exclusion_squared_through_;
  if (!((rest_node_[node] - rest_centre_[triangle]).squaredNorm() < limit)) return false;
  return !is_exception(node, triangle);
}

/// Triangles whose normal n has a . n >= cosine, a the node's axis, cannot face the node: a cone around the normals of the node's
/// triangles says how far any of them is from a.
CandidateSearch::View CandidateSearch::view_of(int node, double turn) const {
  Vec3 sum = Vec3::Zero();
  for (int r = surface_.ring_start[node]; r < surface_.ring_start[node + 1]; ++r) sum += normal_[surface_.ring[r]];
  const View everything{Eigen::Vector3f::Zero(), 2.0F};
  if (!(sum.squaredNorm() > 1e-6)) return everything;
  const Vec3 axis = sum.normalized();
  double opening = 1;
  for (int r = surface_.ring_start[node]; r < surface_.ring_start[node + 1]; ++r) opening = std::min(opening, axis.dot(normal_[surface_.ring[r]]));
  // Each normal may turn by `turn`: a scalar product of 2 turn now is at least 0 until then.
  const double angle = std::acos(std::min(1.0, 2 * turn)) - std::acos(std::clamp(opening, -1.0, 1.0));
  if (!(angle > 0)) return everything;
  return {axis.cast<float>(), static_cast<float>(std::cos(angle) + 1e-5)};
}

void CandidateSearch::update(std::span<const double> x, double radius, double turn) {
  const int nodes = surface_.node_count(), triangles = surface_.triangle_count();
  centre_.resize(surface_.triangles.size());
  normal_.resize(surface_.triangles.size());
  radius_.resize(surface_.triangles.size());
  parallel_for(triangles, [&](std::ptrdiff_t f) {
    const auto& t = surface_.triangles[f];
    const Vec3 a = point(x, surface_.nodes[t[0]]), b = point(x, surface_.nodes[t[1]]), c = point(x, surface_.nodes[t[2]]);
    const Vec3 m = (a + b + c) / 3;
    centre_[f] = m;
    normal_[f] = (b - a).cross(c - a);
    const double area = normal_[f].norm();
    normal_[f] = area > 0 ? Vec3(normal_[f] / area) : Vec3::Zero();
    radius_[f] = std::sqrt(std::max({(a - m).squaredNorm(), (b - m).squaredNorm(), (c - m).squaredNorm()}));
  });
  Vec3 lower = centre_[0], upper = centre_[0];
  double radius_max = 0, checksum = 0;
  for (int f = 0; f < triangles; ++f) {
    lower = lower.cwiseMin(centre_[f]);
    upper = upper.cwiseMax(centre_[f]);
    radius_max = std::max(radius_max, radius_[f]);
    checksum += radius_[f] + centre_[f].sum();
  }
  if (!std::isfinite(checksum)) throw TrustError("contact: positions are not finite; the run has diverged");
  // Cells of the search distance: a node looks at 3 x 3 rows of them, long enough for vector instructions.
  const double distance = radius + radius_max;
  const float margin = static_cast<float>(1e-6 * (lower.norm() + upper.norm()) + 1e-4 * radius);  // single precision
  grid_.reset(lower, upper, distance);
  grid_.sort(triangles, [&](int f) { return grid_.cell_index(grid_.cell(centre_[f])); });
  for (auto* array : {&cx_, &cy_, &cz_, &reach_squared_, &rx_, &ry_, &rz_, &nx_, &ny_, &nz_}) array->resize(surface_.triangles.size());
  side_.resize(surface_.triangles.size());
  parallel_for(triangles, [&](std::ptrdiff_t k) {
    const int f = grid_.item(static_cast<int>(k));
    cx_[k] = static_cast<float>(centre_[f][0]);
    cy_[k] = static_cast<float>(centre_[f][1]);
    cz_[k] = static_cast<float>(centre_[f][2]);
    const float r = static_cast<float>(radius + radius_[f]) + margin;
    reach_squared_[k] = r * r;
    rx_[k] = rest_centre_[f][0];
    ry_[k] = rest_centre_[f][1];
    rz_[k] = rest_centre_[f][2];
    nx_[k] = static_cast<float>(normal_[f][0]);
    ny_[k] = static_cast<float>(normal_[f][1]);
    nz_[k] = static_cast<float>(normal_[f][2]);
    side_[k] = surface_.triangle_side[f];
  });

  const Vec3 reach = Vec3::Constant(distance + margin);
  fill_node_lists(nodes, found_, start_, triangle_, [&](int n, std::vector<int>& list) {
    const std::size_t before = list.size();
    constexpr int chunk = 64;
    std::array<int, chunk> flag;
    const Vec3 p = point(x, surface_.nodes[n]);
    const Eigen::Vector3f pf = p.cast<float>(), rest = rest_node_[n];
    const int own_side = surface_.node_side[n];
    const View view = view_of(n, turn);
    const int has_exceptions = exception_start_[n + 1] > exception_start_[n];
    grid_.for_runs(grid_.cell(p - reach), grid_.cell(p + reach), [&](int first, int last) {
      for (int base = first; base < last; base += chunk) {
        const int count = std::min(chunk, last - base);
        int any = 0;
        for (int k = 0; k < count; ++k) {
          const int j = base + k;
          const float dx = cx_[j] - pf[0], dy = cy_[j] - pf[1], dz = cz_[j] - pf[2];
          const float ex = rx_[j] - rest[0], ey = ry_[j] - rest[1], ez = rz_[j] - rest[2];
          const float aligned = nx_[j] * view.axis[0] + ny_[j] * view.axis[1] + nz_[j] * view.axis[2];
          const int near = (dx * dx + dy * dy + dz * dz <= reach_squared_[j]) & (aligned < view.cosine);
          const int own = ex * ex + ey * ey + ez * ez < (side_[j] == own_side ? exclusion_squared_ : exclusion_squared_through_);
          flag[k] = (near & (own ^ 1)) + 3 * (near & own & has_exceptions);  // 1: candidate, 3: only if excepted
          any |= flag[k];
        }
        if (!any) continue;
        for (int k = 0; k < count; ++k) {
          if (flag[k] == 1 || (flag[k] == 3 && is_exception(n, grid_.item(base + k))))
            list.push_back(grid_.item(base + k));
        }
      }
    });
    std::sort(list.begin() + static_cast<std::ptrdiff_t>(before), list.end());
  });
}

}  // namespace mv
