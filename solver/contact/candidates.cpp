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
#include "solver/contact/box_grid.h"
#include "solver/contact/node_lists.h"

namespace mv {
namespace {

using Vec3 = Eigen::Vector3d;

constexpr float cone_margin = 1e-3F;  // of angles: the arc cosine of a number that is one but for single precision is wrong by 3e-4

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
  find_exceptions();
  std::vector<Vec3> centres, normals, node_normals(surface_.nodes.size(), Vec3::Zero());
  for (const auto& t : surface_.triangles) {
    const Vec3 a = surface_.reference[t[0]], b = surface_.reference[t[1]], c = surface_.reference[t[2]];
    centres.push_back((a + b + c) / 3);
    normals.push_back((b - a).cross(c - a).stableNormalized());
    for (int n : t) node_normals[n] += normals.back();
  }
  for (Vec3& n : node_normals) n.stableNormalize();
  const double length = BoxTree::normal_edges * surface_.mean_edge;
  tree_ = BoxTree(centres, normals, length);
  node_tree_ = BoxTree(surface_.reference, node_normals, length);
  node_slot_.resize(surface_.nodes.size());
  for (int slot = 0; slot < node_tree_.slot_count(); ++slot)
    if (node_tree_.item(slot) >= 0) node_slot_[node_tree_.item(slot)] = slot;
  start_.assign(static_cast<std::size_t>(node_tree_.slot_count()) + 1, 0);
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

/// The cone that no node of the group can see into: the narrowest of theirs, less how far their axes lie from the mean one.
CandidateSearch::Group CandidateSearch::group_of(int leaf, std::span<const double> x, std::span<const View> views) const {
  Group g{{Eigen::Array3f::Constant(std::numeric_limits<float>::infinity()), Eigen::Array3f::Constant(-std::numeric_limits<float>::infinity())}, Eigen::Vector3f::Zero(), 2, 0};
  float largest = -1;
  for (int lane = 0; lane < BoxTree::width; ++lane) {
    const int n = node_tree_.item(leaf * BoxTree::width + lane);
    if (n < 0) break;
    const Eigen::Array3f p = point(x, surface_.nodes[n]).cast<float>().array();
    g.box.lower = g.box.lower.min(p);
    g.box.upper = g.box.upper.max(p);
    g.axis += views[static_cast<std::size_t>(lane)].axis;
    largest = std::max(largest, views[static_cast<std::size_t>(lane)].cosine);
  }
  if (largest > 1 || !(g.axis.squaredNorm() > 1e-6F)) return g;
  g.axis.normalize();
  float spread = 1;
  for (int lane = 0; lane < BoxTree::width; ++lane)
    if (node_tree_.item(leaf * BoxTree::width + lane) >= 0) spread = std::min(spread, g.axis.dot(views[static_cast<std::size_t>(lane)].axis));
  const float angle = std::acos(largest) - std::acos(std::clamp(spread, -1.0F, 1.0F)) - cone_margin;
  if (!(angle > 0)) return g;
  g.cosine = std::cos(angle);
  g.sine = std::sin(angle);
  return g;
}

/// Where the triangles of each leaf are, and which way they look.
void CandidateSearch::fit_leaves(double radius, float margin) {
  lanes_.resize(static_cast<std::size_t>(tree_.leaf_count()));
  cone_.resize(lanes_.size());
  tree_.fit([&](int f) {
    const Eigen::Array3f c = centre_[static_cast<std::size_t>(f)].cast<float>().array();
    const float r = static_cast<float>(radius + radius_[static_cast<std::size_t>(f)]) + 2 * margin;
    return BoxTree::Box{c - r, c + r};
  });
  parallel_for(
      tree_.leaf_count(),
      [&](std::ptrdiff_t leaf) {
        Lanes& l = lanes_[leaf];
        Vec3 sum = Vec3::Zero();
        bool has_degenerate = false;
        for (int k = 0; k < BoxTree::width; ++k) {
          const int f = tree_.item(static_cast<int>(leaf) * BoxTree::width + k);
          if (f < 0) {
            l.cx[k] = l.cy[k] = l.cz[k] = l.rx[k] = l.ry[k] = l.rz[k] = l.nx[k] = l.ny[k] = l.nz[k] = 0;
            l.reach_squared[k] = -1;
            l.side[k] = 0;
            continue;
          }
          const Eigen::Vector3f c = centre_[f].cast<float>(), n = normal_[f].cast<float>();
          l.cx[k] = c[0], l.cy[k] = c[1], l.cz[k] = c[2];
          l.nx[k] = n[0], l.ny[k] = n[1], l.nz[k] = n[2];
          l.rx[k] = rest_centre_[f][0], l.ry[k] = rest_centre_[f][1], l.rz[k] = rest_centre_[f][2];
          const float r = static_cast<float>(radius + radius_[f]) + margin;
          l.reach_squared[k] = r * r;
          l.side[k] = surface_.triangle_side[f];
          sum += normal_[f];
          has_degenerate = has_degenerate || normal_[f].isZero(0);
        }
        Cone& cone = cone_[leaf];
        cone = {Eigen::Vector3f::Zero(), -2, 0};
        if (has_degenerate || !(sum.squaredNorm() > 1e-6)) return;
        const Vec3 axis = sum.normalized();
        double opening = 1;
        for (int k = 0; k < BoxTree::width; ++k) {
          const int f = tree_.item(static_cast<int>(leaf) * BoxTree::width + k);
          if (f >= 0) opening = std::min(opening, axis.dot(normal_[f]));
        }
        const double angle = std::acos(std::clamp(opening, -1.0, 1.0)) + cone_margin;
        cone = {axis.cast<float>(), static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))};
      },
      64);
}

void CandidateSearch::update(std::span<const double> x, double radius, double turn) {
  const int triangles = surface_.triangle_count();
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
  double largest = 0, checksum = 0;
  for (int f = 0; f < triangles; ++f) {
    largest = std::max(largest, centre_[f].cwiseAbs().maxCoeff());
    checksum += radius_[f] + centre_[f].sum();
  }
  if (!std::isfinite(checksum)) throw TrustError("contact: positions are not finite; the run has diverged");
  fit_leaves(radius, static_cast<float>(2e-6 * largest + 1e-4 * radius));  // margin: single precision

  /// The eight nodes at work and their lists.
  struct Work {
    std::array<View, BoxTree::width> views;
    std::array<std::array<float, BoxTree::width>, 3> at;
    std::array<std::vector<Block>, BoxTree::width> lists;
  };
  fill_node_lists(node_tree_.slot_count(), found_, start_, block_, [&](int slot, std::vector<Block>& list) {
    static thread_local Work work;
    const auto lane = static_cast<std::size_t>(slot % BoxTree::width);
    if (lane == 0) {
      for (std::size_t k = 0; k < BoxTree::width; ++k) {
        work.lists[k].clear();
        const int n = node_tree_.item(slot + static_cast<int>(k));
        if (n >= 0) work.views[k] = view_of(n, turn);
        for (int c = 0; c < 3; ++c)
          work.at[static_cast<std::size_t>(c)][k] = n >= 0 ? static_cast<float>(x[3 * static_cast<std::size_t>(surface_.nodes[n]) + static_cast<std::size_t>(c)]) : NAN;
      }
      const Group group = group_of(slot / BoxTree::width, x, work.views);
      const Floats px = load_floats(work.at[0].data()), py = load_floats(work.at[1].data()), pz = load_floats(work.at[2].data());
      tree_.for_leaves(group.box, 0, [&](int leaf) {
        const Cone& cone = cone_[static_cast<std::size_t>(leaf)];
        // All normals of the leaf lie within the angle when the axes are closer than the difference of both angles.
        const bool is_narrower = cone.cosine > group.cosine && group.cosine <= 1;
        if (is_narrower && cone.axis.dot(group.axis) >= group.cosine * cone.cosine + group.sine * cone.sine) return;
        const BoxTree::Box box = tree_.leaf_box(leaf);
        unsigned inside = bits((px >= box.lower[0]) & (px <= box.upper[0]) & (py >= box.lower[1]) & (py <= box.upper[1]) & (pz >= box.lower[2]) & (pz <= box.upper[2]));
        for (; inside != 0; inside &= inside - 1) {
          const int k = __builtin_ctz(inside);
          const unsigned lanes = candidates_in(leaf, node_tree_.item(slot + k), {work.at[0][k], work.at[1][k], work.at[2][k]}, work.views[static_cast<std::size_t>(k)]);
          if (lanes != 0) work.lists[static_cast<std::size_t>(k)].push_back({leaf, lanes});
        }
      });
    }
    list.insert(list.end(), work.lists[lane].begin(), work.lists[lane].end());
  });
}

/// Bit l: the triangle in lane l of the leaf is a candidate of the node at p.
unsigned CandidateSearch::candidates_in(int leaf, int node, const Eigen::Vector3f& p, const View& view) const {
  const Lanes& l = lanes_[static_cast<std::size_t>(leaf)];
  const Eigen::Vector3f& rest = rest_node_[node];
  const Floats dx = load_floats(l.cx.data()) - p[0], dy = load_floats(l.cy.data()) - p[1], dz = load_floats(l.cz.data()) - p[2];
  const Floats aligned = load_floats(l.nx.data()) * view.axis[0] + load_floats(l.ny.data()) * view.axis[1] + load_floats(l.nz.data()) * view.axis[2];
  const unsigned in_reach = bits((dx * dx + dy * dy + dz * dz <= load_floats(l.reach_squared.data())) & (aligned < view.cosine));
  if (in_reach == 0) return 0;
  const Floats ex = load_floats(l.rx.data()) - rest[0], ey = load_floats(l.ry.data()) - rest[1], ez = load_floats(l.rz.data()) - rest[2];
  const Floats apart = ex * ex + ey * ey + ez * ez;
  const FloatMask same_side = load_ints(l.side.data()) == surface_.node_side[node];
  const unsigned own = bits((same_side & (apart < exclusion_squared_)) | (~same_side & (apart < exclusion_squared_through_)));
  unsigned lanes = in_reach & ~own;
  if (exception_start_[node + 1] > exception_start_[node])
    for (unsigned left = in_reach & own; left != 0; left &= left - 1)
      if (is_exception(node, tree_.item(leaf * BoxTree::width + __builtin_ctz(left)))) lanes |= left & (~left + 1);
  return lanes;
}

std::vector<int> CandidateSearch::triangles_in(std::span<const Block> blocks) const {
  std::vector<int> list;
  for (const Block& b : blocks)
    for (unsigned lanes = b.lanes; lanes != 0; lanes &= lanes - 1) list.push_back(tree_.item(b.leaf * BoxTree::width + __builtin_ctz(lanes)));
  std::sort(list.begin(), list.end());
  return list;
}

long CandidateSearch::pair_count() const {
  long count = 0;
  for (const Block& b : block_) count += __builtin_popcount(b.lanes);
  return count;
}

}  // namespace mv
