// SPDX-License-Identifier: BSD-3-Clause
// One evaluation: frames of the triangles -> each slave node computes its gap, force, friction and the reactions on its
// triangles' corners (records) -> each triangle sums its records -> each node sums its triangles. Every sum has a fixed order
// that does not depend on threads or on when candidates were renewed: triangles without weight contribute nothing, lists are in
// the order of the tree's leaves.
#include "solver/contact/self_contact.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "geometry/core/errors.h"
#include "geometry/core/parallel.h"
#include "solver/contact/candidates.h"
#include "solver/contact/closest_gaps.h"
#include "solver/contact/contact_kernel.h"
#include "solver/contact/leaf_frames.h"
#include "solver/contact/near_pairs.h"
#include "solver/contact/sights.h"

namespace mv {
namespace {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using contact::load;
using contact::Pack3;
using contact::smooth_step;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double facing_full_cosine = -0.6;  // from here on a triangle counts fully; below facing_cosine not at all
constexpr double lateral_growth = 0.5;  // gamma: how the averaging radius widens with the gap (covers ridges up to 2 atan(gamma))
constexpr double full_weight = 0.5;     // W above which the force is not faded
constexpr double depth_fade = 0.2;      // share of the penetration limit over which deep triangles fade out
// Candidates are renewed when a node has moved by half the skin or a triangle's unit normal by turn_allowed; of them, the near pairs after smaller motions.
constexpr double turn_allowed = 0.2;
constexpr double near_skin_share = 0.3;
constexpr double near_turn_allowed = 0.06;
// Both are halved, down to least_near_scale, while near pairs last for many steps, and doubled while they last for few.
constexpr double least_near_scale = 0.1;
constexpr int few_steps = 8, many_steps = 30;

/// Phi and its derivatives for the overlap o = threshold - gap (self_contact.h).
struct Penalty {
  double energy, force, tangent;
};
Penalty penalty_of(const ContactOptions& o, double threshold, double overlap) {
  const double beyond = std::max(overlap - threshold, 0.0), within = overlap - beyond;
  const double s = within / threshold, s2 = s * s, s6 = s2 * s2 * s2, s12 = o.hardening * s6 * s6;
  Penalty p{within * within * (0.5 + s12 / 14), within * (1 + s12), 1 + 13 * s12};
  p.energy += beyond * (p.force + 0.5 * p.tangent * beyond);
  p.force += p.tangent * beyond;
  return p;
}

/// What one slave adds to the totals.
struct SlaveTotals {
  double force = 0, friction = 0, area = 0, gap = infinity, depth = 0, energy = 0, slip_energy = 0, dissipation = 0;
};

/// Forces on the three corners of a triangle.
using CornerForces = std::array<double, 9>;

/// Reactions of a piece of slaves on the triangles they see, in their order.
struct Records {
  std::vector<int> triangle;
  std::vector<CornerForces> forces;
};

/// Of one thread, on cache lines of its own: the lists grow all the time.
struct alignas(128) Scratch {
  std::vector<NearPairs::Block> wanted;       // leaves with triangles that pass the test in single precision
  contact::Sights seen;
  std::vector<contact::Reactions> reactions;  // by block of `seen`
};

Vec3 at(std::span<const double> x, int node) { return Eigen::Map<const Vec3>(x.data() + 3 * static_cast<std::size_t>(node)); }

ContactOptions resolve(const ContactSurface& s, ContactOptions o) {
  const auto refuse = [](const std::string& what) { throw InputError("contact: " + what); };
  if (!(o.threshold > 0)) refuse("threshold must be positive");
  if (!(o.stiffness >= 0)) refuse("stiffness must not be negative");
  if (!(o.border_offset >= 0)) refuse("border_offset must not be negative");
  if (!(o.hardening >= 0)) refuse("hardening must not be negative");
  if (!(o.friction >= 0)) refuse("friction must not be negative");
  if (!(o.tangential_ratio > 0)) refuse("tangential_ratio must be positive");
  if (!(o.averaging_ratio > 0)) refuse("averaging_ratio must be positive");
  if (!(o.thickness >= 0) || !(o.penetration_limit >= 0) || !(o.exclusion_radius >= 0) || !(o.skin >= 0))
    refuse("lengths must not be negative");
  if (o.penetration_limit == 0) o.penetration_limit = o.thickness > 0 ? 0.5 * o.thickness : s.mean_edge;
  if (o.exclusion_radius == 0) {
    o.exclusion_radius = std::max(2.0 * s.mean_edge, o.thickness);
    if (o.exclusion_radius_through == 0) o.exclusion_radius_through = std::max(o.exclusion_radius, 1.5 * o.thickness);
  }
  if (o.exclusion_radius_through == 0) o.exclusion_radius_through = o.exclusion_radius;
  if (o.exclusion_radius_through < o.exclusion_radius) refuse("exclusion_radius_through must not be smaller than exclusion_radius");
  if (o.skin == 0) o.skin = 0.6 * s.mean_edge;
  return o;
}

}  // namespace

struct SelfContact::Impl {
  const ContactSurface& surface;
  ContactOptions options;
  CandidateSearch search;
  NearPairs near;
  double sheet_separation;               // m, triangles this much further away than the nearest belong to another sheet
  double p_max;                          // m, largest distance along the normal that can matter
  double reach;                          // m, largest distance to a triangle that can matter
  std::vector<double> node_stiffness;    // N/m
  std::vector<double> averaging_radius;  // R_f per triangle, m
  std::optional<SurfaceFrames> surface_frames;  // of the last x
  std::vector<double> radius_squared;    // R_f^2 by slot of the tree
  std::vector<double> threshold_of;      // m, per surface node
  std::vector<int> ring_corner;          // which corner of ring[r] the node is
  std::vector<std::array<std::int32_t, 3>> corner_offset;  // per triangle: where its corners' coordinates begin among the solid's

  // Refreshed by a search (candidates) and in between (near pairs).
  std::vector<double> x_search, x_near;  // 3 per surface node
  std::vector<Vec3> normal_near;         // per triangle
  int steps_since_search = 0, steps_since_near = 0;
  double near_scale = 1;
  bool has_candidates = false;
  bool has_new_history = false;
  std::vector<int> slaves;        // nodes with near pairs or elastic slip
  float single_precision = 0;     // m, margin for what is tested in it

  // Per step.
  std::vector<SlaveTotals> slave_totals;  // per slave
  std::vector<Records> records;           // per piece of slaves
  std::vector<int> pressed;               // triangles with records, in the order of these
  std::vector<int> records_of;            // per triangle, scratch: how many, then where; 0 between steps
  std::vector<int> record_start;          // per pressed triangle: its range in `ordered`
  std::vector<const CornerForces*> ordered;
  std::vector<CornerForces> facet_force;
  std::vector<char> facet_active;
  std::vector<Scratch> scratch;            // per thread
  std::vector<char> moved_too_far;         // per thread, bits: near pairs, candidates

  // Per surface node.
  std::vector<double> gap, visibility, normal_force, pressure;
  std::vector<Vec3> own_force, friction_force, normal, nodal_force, slip;
  std::vector<int> partner;
  std::vector<char> is_active;

  Impl(const ContactSurface& s, const ContactOptions& o)
      : surface(s), options(resolve(s, o)), search(s, options.exclusion_radius, options.exclusion_radius_through) {
    const std::size_t nodes = s.nodes.size(), triangles = s.triangles.size();
    set_node_stiffness({});
    averaging_radius.resize(triangles);
    for (std::size_t f = 0; f < triangles; ++f) {
      const auto& t = s.triangles[f];
      const double rest_area = 0.5 * (s.reference[t[1]] - s.reference[t[0]]).cross(s.reference[t[2]] - s.reference[t[0]]).norm();
      averaging_radius[f] = options.averaging_ratio * std::sqrt(rest_area * 4 / std::sqrt(3.0));
    }
    surface_frames.emplace(s, search.tree(), averaging_radius);
    radius_squared.assign(static_cast<std::size_t>(search.tree().slot_count()), 0.0);
    for (std::size_t slot = 0; slot < radius_squared.size(); ++slot)
      if (const int f = search.tree().item(static_cast<int>(slot)); f >= 0) radius_squared[slot] = averaging_radius[f] * averaging_radius[f];
    const double radius_max = *std::max_element(averaging_radius.begin(), averaging_radius.end());
    sheet_separation = 0.5 * s.mean_edge;
    p_max = std::max(options.threshold + options.border_offset + sheet_separation, options.penetration_limit);
    reach = std::sqrt((1 + lateral_growth * lateral_growth) * p_max * p_max + radius_max * radius_max);
    corner_offset.resize(triangles);
    for (std::size_t f = 0; f < triangles; ++f)
      for (std::size_t k = 0; k < 3; ++k) corner_offset[f][k] = 3 * s.nodes[static_cast<std::size_t>(s.triangles[f][k])];
    ring_corner.resize(s.ring.size());
    threshold_of.assign(nodes, options.threshold);
    for (std::size_t f = 0; f < triangles; ++f)
      if (s.triangle_side[f] == 0)
        for (int n : s.triangles[f]) threshold_of[n] = options.threshold + options.border_offset;
    for (std::size_t n = 0; n < nodes; ++n) {
      for (int r = s.ring_start[n]; r < s.ring_start[n + 1]; ++r) {
        const auto& t = s.triangles[s.ring[r]];
        ring_corner[r] = t[0] == static_cast<int>(n) ? 0 : (t[1] == static_cast<int>(n) ? 1 : 2);
      }
    }
    x_search.resize(3 * nodes);
    x_near.resize(3 * nodes);
    normal_near.resize(triangles);
    records_of.assign(triangles, 0);
    is_active.assign(nodes, 0);
    facet_force.resize(triangles);
    facet_active.assign(triangles, 0);
    for (auto* array : {&visibility, &normal_force, &pressure}) array->assign(nodes, 0.0);
    for (auto* array : {&own_force, &friction_force, &normal, &nodal_force, &slip}) array->assign(nodes, Vec3::Zero());
    gap.assign(nodes, infinity);
    partner.assign(nodes, -1);
  }

  void set_node_stiffness(std::span<const double> stiffness) {
    node_stiffness.resize(surface.nodes.size());
    for (std::size_t n = 0; n < node_stiffness.size(); ++n)
      node_stiffness[n] = stiffness.empty() ? options.stiffness * surface.reference_area[n] : stiffness[n];
  }

  void clear_outputs(int n) {
    gap[n] = infinity;
    visibility[n] = normal_force[n] = pressure[n] = 0;
    own_force[n] = friction_force[n] = normal[n] = nodal_force[n] = Vec3::Zero();
    partner[n] = -1;
    is_active[n] = 0;
  }

  /// Energy of the node's elastic slip, which is lost when the contact opens.
  double release(int n) {
    const double lost = 0.25 * options.tangential_ratio * node_stiffness[n] * slip[n].squaredNorm();
    slip[n].setZero();
    return lost;
  }

  /// What has to be renewed for x, to which the frames belong. True for NaN, too: the search then stops the run.
  enum Stale { fresh = 0, near_pairs = 1, candidates = 2 };
  int what_is_stale(std::span<const double> x) {
    if (!has_candidates || (options.search_every > 0 && steps_since_search >= options.search_every)) return candidates;
    const auto bits = [](double squared, double near_limit, double limit) {
      return static_cast<char>((squared <= near_limit * near_limit ? fresh : near_pairs) | (squared <= limit * limit ? fresh : candidates));
    };
    moved_too_far.assign(static_cast<std::size_t>(thread_count()), has_new_history ? near_pairs : fresh);
    const double skin = 0.5 * options.skin, near_skin = near_scale * near_skin_share * skin, near_turn = near_scale * near_turn_allowed;
    parallel_ranges(surface.node_count(), [&](std::ptrdiff_t begin, std::ptrdiff_t end, int thread) {
      char any = 0;
      for (std::ptrdiff_t n = begin; n < end; ++n) {
        const Vec3 p = at(x, surface.nodes[n]);
        any |= bits((p - at(x_near, static_cast<int>(n))).squaredNorm(), near_skin, infinity);
        any |= bits((p - at(x_search, static_cast<int>(n))).squaredNorm(), infinity, skin);
      }
      moved_too_far[thread] |= any;
    });
    const auto normals = search.normals();
    parallel_ranges(surface.triangle_count(), [&](std::ptrdiff_t begin, std::ptrdiff_t end, int thread) {
      char any = 0;
      for (std::ptrdiff_t f = begin; f < end; ++f) {
        any |= bits((surface_frames->normal(static_cast<int>(f)).n - normal_near[f]).squaredNorm(), near_turn, infinity);
        any |= bits((surface_frames->normal(static_cast<int>(f)).n - normals[f]).squaredNorm(), infinity, turn_allowed);
      }
      moved_too_far[thread] |= any;
    });
    char any = 0;
    for (char bit : moved_too_far) any |= bit;
    return any;
  }

  /// The frames belong to x.
  void update_candidates(std::span<const double> x) {
    search.update(x, reach + options.skin, turn_allowed);
    parallel_for(surface.node_count(), [&](std::ptrdiff_t n) { Eigen::Map<Vec3>(x_search.data() + 3 * n) = at(x, surface.nodes[n]); });
    steps_since_search = 0;
    has_candidates = true;
    update_near_pairs(x);
  }

  void update_near_pairs(std::span<const double> x) {
    for (int n : slaves) clear_outputs(n);
    has_new_history = false;
    if (steps_since_near < few_steps) near_scale = std::min(1.0, 2 * near_scale);
    if (steps_since_near > many_steps) near_scale = std::max(least_near_scale, 0.5 * near_scale);
    steps_since_near = 0;
    double largest = 0;
    for (int n : surface.nodes) largest = std::max(largest, at(x, n).cwiseAbs().maxCoeff());
    single_precision = static_cast<float>(4e-6 * largest);
    near.update(surface, search, surface_frames->heads(), x, limits(), single_precision, near_scale * near_skin_share * options.skin,
                near_scale * near_turn_allowed);
    parallel_for(surface.node_count(), [&](std::ptrdiff_t n) { Eigen::Map<Vec3>(x_near.data() + 3 * n) = at(x, surface.nodes[n]); });
    parallel_for(surface.triangle_count(), [&](std::ptrdiff_t f) { normal_near[f] = surface_frames->normal(static_cast<int>(f)).n; });
    slaves.clear();
    for (int n = 0; n < surface.node_count(); ++n)
      if (!near.blocks_of(n).empty() || !slip[n].isZero(0)) slaves.push_back(n);
    slave_totals.resize(slaves.size());
  }

  SightLimits limits() const { return {options.penetration_limit, p_max, lateral_growth}; }

  /// Adds to `seen` what the node, at x and with the normal n, sees of the triangles in the `wanted` lanes of a leaf.
  void measure(int leaf, unsigned wanted, const Vec3& x, const Vec3& n, contact::Sights& seen) const {
    constexpr int width = BoxTree::width;
    const LeafFrames& frames = surface_frames->frames(leaf);
    for (int h = 0; h < width; h += lanes) {
      const unsigned half = wanted >> h & ((1U << lanes) - 1);
      if (half == 0) continue;
      const auto of = [h](const LeafFrames::Eight& v) { return load(v.data() + h); };
      Pack p{}, cosine{}, d1{}, d2{};
      for (int i = 0; i < 3; ++i) {
        const auto c = static_cast<std::size_t>(i);
        const Pack d = x[i] - of(frames.a[c]), facing = of(frames.n[c]);
        p += facing * d;
        cosine += facing * n[i];
        d1 += of(frames.e1[c]) * d;
        d2 += of(frames.e2[c]) * d;
      }
      const contact::Projection<Pack> q = contact::project(of(frames.g11), of(frames.g12), of(frames.g22), of(frames.inverse_det), d1, d2);
      const Pack reach_squared = load(radius_squared.data() + leaf * width + h) + lateral_growth * lateral_growth * p * p;
      const Pack u = q.lateral_squared / reach_squared;
      Pack chi = contact::smooth_step((cosine - facing_cosine) / (facing_full_cosine - facing_cosine));
      chi = select(p < Pack{}, chi * contact::smooth_step((p + options.penetration_limit) / (depth_fade * options.penetration_limit)), chi);
      const Pack weight = chi * (1.0 - u) * (1.0 - u);
      unsigned visible = half & bits((cosine < facing_cosine) & (q.lateral_squared < reach_squared) & (p > -options.penetration_limit) & (p < p_max) & (weight > Pack{}));
      if (visible == 0) continue;
      alignas(64) std::array<contact::Lanes, 9> found;
      const Pack values[] = {p, weight, chi, u, reach_squared, q.l1, q.l2, q.b1, q.b2};
      for (std::size_t v = 0; v < found.size(); ++v) store(found[v].data(), values[v]);
      for (; visible != 0; visible &= visible - 1) {
        const int lane = __builtin_ctz(visible);
        seen.add(search.tree().item(leaf * width + h + lane), found, lane, frames, h + lane);
      }
    }
  }

  /// Triangles that face the node within reach, with their weights; returns W.
  double look(const Vec3& x, int node, Scratch& own) const {
    contact::Sights& seen = own.seen;
    seen.clear();
    const LeafSight sight(limits(), single_precision, 0);
    const Eigen::Vector3f p = x.cast<float>();
    const auto near_blocks = near.blocks_of(node);
    if (own.wanted.size() < near_blocks.size()) own.wanted.resize(near_blocks.size());
    // Every other leaf fails the test: a branch here would be guessed wrong as often.
    std::size_t count = 0;
    for (const NearPairs::Block& block : near_blocks) {
      const unsigned passed = block.lanes & sight.of(surface_frames->heads()[static_cast<std::size_t>(block.leaf)], p);
      own.wanted[count] = {block.leaf, passed};
      count += passed != 0;
    }
    if (count == 0) return 0;
    const Vec3 n = node_normal(node);
    for (std::size_t k = 0; k < count; ++k) measure(own.wanted[k].leaf, own.wanted[k].lanes, x, n, seen);
    if (seen.blocks().empty()) return 0;
    seen.pad();
    // Approaches |p| for full weight and infinity for none, so that `nearest` does not jump when a triangle comes into sight.
    Pack least = broadcast<Pack>(threshold_of[node]);
    for (const contact::SightBlock& b : seen.blocks()) least = minimum(absolute(load(b.p)) + sheet_separation * (1.0 / load(b.weight) - 1.0), least);
    const double nearest = least_of(least);
    Pack total{};
    for (contact::SightBlock& b : seen.blocks()) {
      const Pack behind = (absolute(load(b.p)) - nearest) / sheet_separation;
      const Pack fade = smooth_step(2.0 * (1.0 - behind));  // 1 up to a half
      const Pack weight = load(b.weight) * fade;
      store(b.chi.data(), load(b.chi) * fade);
      store(b.weight.data(), weight);
      total += weight;
    }
    return sum_of(total);
  }

  Vec3 node_normal(int node) const {
    Vec3 sum = Vec3::Zero();
    for (int r = surface.ring_start[node]; r < surface.ring_start[node + 1]; ++r)
      sum += surface_frames->normal(surface.ring[r]).area2 * surface_frames->normal(surface.ring[r]).n;
    const double length = sum.norm();
    return length > 0 ? Vec3(sum / length) : Vec3::Zero();
  }

  double current_area(int node) const {
    double sum = 0;
    for (int r = surface.ring_start[node]; r < surface.ring_start[node + 1]; ++r) {
      if (surface.triangle_side[surface.ring[r]] == surface.node_side[node]) sum += surface_frames->normal(surface.ring[r]).area2;
    }
    return sum / 6;
  }

  /// All of one slave node: outputs, its own force, records of the reactions.
  SlaveTotals evaluate_slave(int node, std::span<const double> x, std::span<const double> v, double dt, Scratch& own_scratch, Records& out) {
    SlaveTotals result;
    contact::Sights& seen = own_scratch.seen;
    const Vec3 position = at(x, surface.nodes[node]);
    const double total = look(position, node, own_scratch);
    double g = infinity;
    int nearest = -1;
    if (total > 0) {
      Pack weighted{};
      double largest = 0;
      for (const contact::SightBlock& b : seen.blocks()) {
        weighted += load(b.weight) * load(b.p);
        for (std::size_t l = 0; l < lanes; ++l)
          if (b.weight[l] > largest) {
            largest = b.weight[l];
            nearest = b.triangle[l];
          }
      }
      g = sum_of(weighted) / total;
    }
    const double threshold = threshold_of[node];
    if (is_active[node] && !(g < threshold)) clear_outputs(node);
    gap[node] = g;
    visibility[node] = smooth_step(total / full_weight);
    partner[node] = nearest;
    if (!(g < threshold)) {
      if (options.friction > 0 && !slip[node].isZero(0)) result.dissipation = release(node);
      return result;
    }
    const double half_stiffness = 0.5 * node_stiffness[node];
    const double overlap = threshold - g;
    const double fade = smooth_step(total / full_weight);
    const double fade_slope = contact::smooth_step_slope(total / full_weight) / full_weight;
    const Penalty penalty = penalty_of(options, threshold, overlap);
    const double force = half_stiffness * fade * penalty.force;  // this pass
    const double force_of_total = half_stiffness * fade_slope * penalty.energy;

    const auto blocks = seen.blocks();
    std::vector<contact::Reactions>& reactions = own_scratch.reactions;
    reactions.resize(std::max(reactions.size(), blocks.size()));
    Pack3 own{}, mean_normal{};
    Pack depth{};
    for (std::size_t k = 0; k < blocks.size(); ++k) {
      const contact::SightBlock& b = blocks[k];
      const Pack weight = load(b.weight), p = load(b.p), u = load(b.u), reach_squared = load(b.reach_squared);
      const Pack l1 = load(b.l1), l2 = load(b.l2), b1 = load(b.b1), b2 = load(b.b2);
      const Pack share = weight / total;
      // Factors on dp and on d(lateral distance squared), from dg and dW.
      const Pack slope = -2.0 * load(b.chi) * (1.0 - u) * (force * (p - g) / total - force_of_total);
      const Pack on_p = force * share - slope * (2 * lateral_growth * lateral_growth) * p * u / reach_squared;
      const Pack on_lateral = 2.0 * slope / reach_squared;
      const Pack on_normal = on_lateral * p - on_p;
      depth = maximum(depth, select((u == Pack{}) & (weight > Pack{}), -p, Pack{}));  // u = 0: the foot lies in the triangle
      for (std::size_t c = 0; c < 3; ++c) {
        const Pack n = load(b.n[c]), lateral = (l1 - b1) * load(b.e1[c]) + (l2 - b2) * load(b.e2[c]);
        own[c] += on_p * n + on_lateral * lateral;
        mean_normal[c] += share * n;
        const Pack along_normal = on_normal * n, towards_closest = -on_lateral * (lateral + p * n);
        reactions[k][0][c] = (1.0 - l1 - l2) * along_normal + (1.0 - b1 - b2) * towards_closest;
        reactions[k][1][c] = l1 * along_normal + b1 * towards_closest;
        reactions[k][2][c] = l2 * along_normal + b2 * towards_closest;
      }
    }
    is_active[node] = 1;
    own_force[node] = contact::sum_of(own);
    normal[node] = contact::sum_of(mean_normal).normalized();
    normal_force[node] = 2 * force;
    result.depth = most_of(depth);
    result.force = 2 * force;
    result.gap = g;
    result.area = current_area(node);
    pressure[node] = 2 * force / result.area;
    result.energy = half_stiffness * fade * penalty.energy;
    if (options.friction > 0) add_friction(node, position, v, dt, force, total, seen, reactions, result);
    for (std::size_t k = 0; k < blocks.size(); ++k)
      for (std::size_t l = 0; l < lanes; ++l)
        if (blocks[k].weight[l] > 0) {
          out.triangle.push_back(blocks[k].triangle[l]);
          CornerForces& corners = out.forces.emplace_back();
          for (std::size_t a = 0; a < 9; ++a) corners[a] = reactions[k][a / 3][a % 3][l];
        }
    return result;
  }

  /// Coulomb friction of one slave pass; see README for the return mapping and the turning observer.
  void add_friction(int node, const Vec3& x, std::span<const double> velocities, double dt, double force, double total, const contact::Sights& seen,
                    std::span<contact::Reactions> reactions, SlaveTotals& result) {
    const Vec3 n = normal[node];
    const auto blocks = seen.blocks();
    Pack3 nearest{}, speed{}, turning{};
    contact::Inertia<Pack> inertia{};
    for (const contact::SightBlock& b : blocks) {
      std::array<std::array<std::int32_t, lanes>, 3> corner;
      for (std::size_t l = 0; l < lanes; ++l)
        for (std::size_t k = 0; k < 3; ++k) corner[k][l] = corner_offset[b.triangle[l]][k];
      const Pack share = load(b.weight) / total, p = load(b.p), b1 = load(b.b1), b2 = load(b.b2);
      const Pack aside1 = load(b.l1) - b1, aside2 = load(b.l2) - b2;
      Pack3 e1, e2, dv1, dv2;
      for (std::size_t c = 0; c < 3; ++c) {
        const auto of = [&](std::size_t k) { return mv::gather(velocities.data() + c, corner[k].data()); };
        const Pack va = of(0);
        dv1[c] = of(1) - va;
        dv2[c] = of(2) - va;
        e1[c] = load(b.e1[c]);
        e2[c] = load(b.e2[c]);
        nearest[c] += share * (x[c] - p * load(b.n[c]) - aside1 * e1[c] - aside2 * e2[c]);
        speed[c] += share * (va + b1 * dv1[c] + b2 * dv2[c]);
      }
      contact::add_turning(e1, e2, dv1, dv2, share, turning, inertia);
    }
    const Vec3 point = contact::sum_of(nearest), velocity = contact::sum_of(speed), spin = contact::sum_of(turning);
    const Mat3 inverse = contact::matrix_of(inertia).inverse();
    const Vec3 omega = inverse * spin;
    const Vec3 arm = x - point;
    const Vec3 relative = at(velocities, surface.nodes[node]) - velocity - omega.cross(arm);
    const Vec3 advance = dt * (relative - n * n.dot(relative));

    // The history turns with the master, stays tangential and keeps its length.
    Vec3 old = slip[node];
    const double length = old.norm();
    if (length > 0) {
      old += dt * omega.cross(old);
      old -= n * n.dot(old);
      const double turned = old.norm();
      old = turned > 0 ? Vec3(old * (length / turned)) : Vec3::Zero();
    }
    const double stiffness = 0.5 * options.tangential_ratio * node_stiffness[node];
    const double cap = stiffness > 0 ? options.friction * force / stiffness : 0.0;
    const Vec3 trial = old + advance;
    const double trial_length = trial.norm();
    const Vec3 held = trial_length > cap ? Vec3(trial * (cap / trial_length)) : trial;
    slip[node] = held;
    result.dissipation = stiffness * (held.dot(trial - held) + 0.5 * (held - old).squaredNorm());
    result.slip_energy = 0.5 * stiffness * held.squaredNorm();

    const Vec3 friction = -stiffness * held;
    friction_force[node] = 2 * friction;
    result.friction = 2 * friction.norm();
    own_force[node] += friction;
    const Vec3 turn = inverse * arm.cross(friction) / 3;
    for (std::size_t k = 0; k < blocks.size(); ++k) {
      const contact::SightBlock& b = blocks[k];
      const Pack share = load(b.weight) / total, b1 = load(b.b1), b2 = load(b.b2);
      Pack3 centre, arm1, arm2;
      for (std::size_t c = 0; c < 3; ++c) {
        const Pack e1 = load(b.e1[c]), e2 = load(b.e2[c]);
        centre[c] = (e1 + e2) / 3.0;
        arm1[c] = e1 - centre[c];
        arm2[c] = e2 - centre[c];
      }
      const auto push = [&](Pack3& corner, Pack barycentric, const Pack3& r, double sign) {
        for (std::size_t c = 0; c < 3; ++c) {
          const std::size_t d = (c + 1) % 3, e = (c + 2) % 3;
          corner[c] -= share * (barycentric * friction[c] + sign * (turn[d] * r[e] - turn[e] * r[d]));
        }
      };
      push(reactions[k][0], 1.0 - b1 - b2, centre, -1);
      push(reactions[k][1], b1, arm1, 1);
      push(reactions[k][2], b2, arm2, 1);
    }
  }

  /// The records by triangle, in the order of the slaves.
  void sort_records() {
    for (int f : pressed) facet_active[f] = 0;
    pressed.clear();
    std::size_t count = 0;
    for (const Records& piece : records) {
      count += piece.triangle.size();
      for (int f : piece.triangle)
        if (records_of[f]++ == 0) pressed.push_back(f);
    }
    ordered.resize(count);
    record_start.assign(pressed.size() + 1, 0);
    for (std::size_t m = 0; m < pressed.size(); ++m) {
      record_start[m + 1] = record_start[m] + records_of[pressed[m]];
      records_of[pressed[m]] = record_start[m];
    }
    for (const Records& piece : records)
      for (std::size_t k = 0; k < piece.triangle.size(); ++k) ordered[records_of[piece.triangle[k]]++] = &piece.forces[k];
  }

  void gather(std::span<double> forces) {
    sort_records();
    parallel_pieces(static_cast<std::ptrdiff_t>(pressed.size()), 256, [&](std::ptrdiff_t begin, std::ptrdiff_t end, int) {
      for (std::ptrdiff_t m = begin; m < end; ++m) {
        const int f = pressed[m];
        CornerForces sum{};
        for (int k = record_start[m]; k < record_start[m + 1]; ++k)
          for (int c = 0; c < 9; ++c) sum[c] += (*ordered[k])[c];
        facet_force[f] = sum;
        facet_active[f] = 1;
        records_of[f] = 0;
      }
    });
    parallel_for(surface.node_count(), [&](std::ptrdiff_t n) {
      Vec3 sum = own_force[n];
      for (int r = surface.ring_start[n]; r < surface.ring_start[n + 1]; ++r) {
        const int f = surface.ring[r];
        if (facet_active[f]) sum += Eigen::Map<const Vec3>(facet_force[f].data() + 3 * ring_corner[r]);
      }
      nodal_force[n] = sum;
      Eigen::Map<Vec3>(forces.data() + 3 * static_cast<std::size_t>(surface.nodes[n])) += sum;
    });
  }

  /// Of the slaves; reactions go to `records`.
  void evaluate_slaves(std::span<const double> x, std::span<const double> v, double dt) {
    constexpr std::ptrdiff_t piece = 128;
    const auto count = static_cast<std::ptrdiff_t>(slaves.size()), pieces = (count + piece - 1) / piece;
    records.resize(std::max(records.size(), static_cast<std::size_t>(pieces)));  // those beyond stay empty, and keep their memory
    for (std::size_t p = static_cast<std::size_t>(pieces); p < records.size(); ++p) {
      records[p].triangle.clear();
      records[p].forces.clear();
    }
    scratch.resize(std::max(scratch.size(), static_cast<std::size_t>(thread_count())));
    parallel_pieces(
        pieces, 1,
        [&](std::ptrdiff_t begin, std::ptrdiff_t end, int thread) {
          for (std::ptrdiff_t p = begin; p < end; ++p) {
            // Moved here and back: threads would share the cache line of neighbouring lists.
            Records out = std::move(records[p]);
            out.triangle.clear();
            out.forces.clear();
            for (std::ptrdiff_t k = p * piece; k < std::min(count, (p + 1) * piece); ++k) slave_totals[k] = evaluate_slave(slaves[k], x, v, dt, scratch[thread], out);
            records[p] = std::move(out);
          }
        },
        2);
  }

  ContactResult totals() {
    ContactResult result;
    for (const SlaveTotals& t : slave_totals) {
      result.friction_dissipation += t.dissipation;
      if (!(t.force > 0)) continue;
      ++result.active_nodes;
      result.normal_force += 0.5 * t.force;
      result.friction_force += 0.5 * t.friction;
      result.contact_area += 0.5 * t.area;
      result.min_gap = std::min(result.min_gap, t.gap);
      result.penetration_max = std::max(result.penetration_max, t.depth);
      result.potential_energy += t.energy;
      result.friction_energy += t.slip_energy;
    }
    return result;
  }
};

SelfContact::SelfContact(const ContactSurface& surface, const ContactOptions& options)
    : impl_(std::make_unique<Impl>(surface, options)) {}
SelfContact::~SelfContact() = default;
SelfContact::SelfContact(SelfContact&&) noexcept = default;

void SelfContact::set_node_stiffness(std::span<const double> stiffness) {
  if (!stiffness.empty() && stiffness.size() != impl_->surface.nodes.size())
    throw InputError("contact: node stiffness has " + std::to_string(stiffness.size()) + " entries for " +
                     std::to_string(impl_->surface.nodes.size()) + " surface nodes");
  impl_->set_node_stiffness(stiffness);
}

void SelfContact::update_candidates(std::span<const double> x) {
  impl_->surface_frames->update(x);
  impl_->update_candidates(x);
}

ContactResult SelfContact::evaluate(std::span<const double> x, std::span<const double> v, double dt, std::span<double> forces) {
  Impl& c = *impl_;
  c.surface_frames->update(x);
  const int stale = c.what_is_stale(x);
  const bool searched = stale & Impl::candidates;
  if (searched) c.update_candidates(x);
  else if (stale & Impl::near_pairs) c.update_near_pairs(x);
  ++c.steps_since_search;
  ++c.steps_since_near;
  c.evaluate_slaves(x, v, dt);
  c.gather(forces);
  ContactResult result = c.totals();
  result.searched = searched;
  return result;
}

void SelfContact::closest_gaps(std::span<const double> x, double max_distance, bool atrial_only, ClosestGaps& out) const {
  mv::closest_gaps(impl_->surface, impl_->search, x, {max_distance, impl_->options.penetration_limit, atrial_only},
                   impl_->partner, out);
}

std::span<const double> SelfContact::gap() const { return impl_->gap; }
std::span<const double> SelfContact::visibility() const { return impl_->visibility; }
std::span<const double> SelfContact::normal_force() const { return impl_->normal_force; }
std::span<const double> SelfContact::pressure() const { return impl_->pressure; }
std::span<const Vec3> SelfContact::friction_force() const { return impl_->friction_force; }
std::span<const Vec3> SelfContact::normal() const { return impl_->normal; }
std::span<const int> SelfContact::partner() const { return impl_->partner; }
std::span<const Vec3> SelfContact::nodal_force() const { return impl_->nodal_force; }

void SelfContact::export_history(std::vector<double>& slip) const {
  slip.resize(3 * impl_->slip.size());
  parallel_for(static_cast<std::ptrdiff_t>(impl_->slip.size()), [&](std::ptrdiff_t n) { Eigen::Map<Vec3>(slip.data() + 3 * n) = impl_->slip[n]; });
}

std::vector<double> SelfContact::export_history() const {
  std::vector<double> slip;
  export_history(slip);
  return slip;
}

void SelfContact::import_history(std::span<const double> slip) {
  if (slip.size() != 3 * impl_->slip.size())
    throw InputError("contact: friction history has " + std::to_string(slip.size()) + " numbers, expected " +
                     std::to_string(3 * impl_->slip.size()));
  std::vector<char> is_new(static_cast<std::size_t>(thread_count()), 0);
  parallel_ranges(static_cast<std::ptrdiff_t>(impl_->slip.size()), [&](std::ptrdiff_t begin, std::ptrdiff_t end, int thread) {
    bool any = false;
    for (std::ptrdiff_t n = begin; n < end; ++n) {
      const Eigen::Map<const Vec3> now(slip.data() + 3 * n);
      if (impl_->slip[n] == now) continue;
      impl_->slip[n] = now;
      any = true;
    }
    is_new[thread] = any;
  });
  // A node with slip must be among the slaves.
  if (std::any_of(is_new.begin(), is_new.end(), [](char c) { return c != 0; })) impl_->has_new_history = true;
}

double SelfContact::tangent_stiffness(int node) const {
  const std::size_t n = static_cast<std::size_t>(node);
  if (!(impl_->normal_force[n] > 0)) return 0.0;
  return impl_->node_stiffness[n] * penalty_of(impl_->options, impl_->threshold_of[n], impl_->threshold_of[n] - impl_->gap[n]).tangent;
}

const ContactOptions& SelfContact::options() const { return impl_->options; }
double SelfContact::search_reach() const { return impl_->reach; }
long SelfContact::candidate_pairs() const { return impl_->search.pair_count(); }

}  // namespace mv
