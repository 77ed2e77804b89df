// SPDX-License-Identifier: BSD-3-Clause
#include "solver/contact/crossing_guard.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "geometry/core/errors.h"
#include "geometry/core/parallel.h"

namespace mv {
namespace {

using Vec3 = Eigen::Vector3d;
using contact::FourPoints;
using contact::Nearest;

constexpr double least_share = 1e-3;         // least distance over the mean edge: far above round-off, far below what a user sees
constexpr double share_kept = 0.5;           // of its distance, by a pair that starts nearer than the least distance
constexpr double approach_kept = 0.95;       // of the approach until then, so that a stopped pair is not stopped again
constexpr double led_apart_below = 0.9;      // of the least distance
constexpr double recovery = 0.1;             // of what it lacks, in a step ...
constexpr double recovery_accepted = 0.5;    // ... of which so much will do
// Search radius: so many steps like this one, within shares of the mean edge; it must hold for this step anyhow.
constexpr double steps_per_search = 20, radius_share_least = 0.05, radius_share_most = 0.3;
constexpr double room = 1.25;                // of a search's radius over what this step needs
constexpr double range_share = 3;            // mean edges: what lies further apart has to come by its whole motion

Vec3 at(std::span<const double> x, int node) { return Eigen::Map<const Vec3>(x.data() + 3 * static_cast<std::size_t>(node)); }

}  // namespace

CrossingGuard::CrossingGuard(std::span<const double> rest, std::span<const std::array<int, 3>> triangles, std::span<const double> masses,
                             std::span<const char> is_fixed, const GuardOptions& options)
    : pairs_(rest, triangles), options_(options) {
  const std::size_t vertices = rest.size() / 3;
  if (triangles.empty() || masses.size() < vertices || is_fixed.size() < vertices)
    throw InputError("crossing guard: " + std::to_string(masses.size()) + " masses and " + std::to_string(is_fixed.size()) + " marks for " +
                     std::to_string(vertices) + " vertices");
  inverse_mass_.assign(vertices, 0.0);
  for (int v : pairs_.vertices()) {
    const auto n = static_cast<std::size_t>(v);
    if (is_fixed[n]) continue;
    if (!(masses[n] > 0)) throw InputError("crossing guard: vertex " + std::to_string(v) + " has no mass");
    inverse_mass_[n] = 1 / masses[n];
  }
  for (const auto& t : triangles)
    for (int k = 0; k < 3; ++k) mean_edge_ += (at(rest, t[k]) - at(rest, t[(k + 1) % 3])).norm() / (3.0 * static_cast<double>(triangles.size()));
  if (!(options_.least_distance >= 0) || options_.sweeps_max < 1) throw InputError("crossing guard: meaningless options");
  if (options_.least_distance == 0) options_.least_distance = least_share * mean_edge_;
  x_search_.assign(rest.begin(), rest.end());
  dx_.assign(vertices, Vec3::Zero());
  changed_.assign(vertices, 0);
  touched_.assign(vertices, 0);
}

CrossingGuard::Motion CrossingGuard::motion_of(const ClosePair& pair, std::span<const double> x0) const {
  Motion m;
  for (int k = 0; k < 4; ++k) {
    m.x[k] = at(x0, pair.node[k]);
    m.dx[k] = dx_[static_cast<std::size_t>(pair.node[k])];
  }
  return m;
}

/// Distance that a pair must keep.
double CrossingGuard::least_of(double distance) const { return std::min(options_.least_distance, share_kept * distance); }

bool CrossingGuard::is_to_be_led_apart(const ClosePair& pair, const Motion& m, const Nearest& start, double distance) const {
  if (!(distance < led_apart_below * options_.least_distance)) return false;
  const double apart = start.separation.dot(contact::nearest_of(m.dx, start.weight).separation) / distance;
  const auto is_movable = [&](int n) { return inverse_mass_[static_cast<std::size_t>(n)] > 0; };
  return apart < recovery_accepted * recovery * (options_.least_distance - distance) && std::any_of(pair.node.begin(), pair.node.end(), is_movable);
}

bool CrossingGuard::comes_too_near(const ClosePair& pair, std::span<const double> x0) const {
  const Motion m = motion_of(pair, x0);
  const Nearest start = contact::nearest_points(pair.is_edges, m.x);
  const double distance = start.separation.norm();
  if (!(distance > 0)) return false;  // met already: there is no side to keep
  if (is_to_be_led_apart(pair, m, start, distance)) return true;
  return contact::share_of_approach(pair.is_edges, m.x, m.dx, least_of(distance)) < 1;
}

/// Impulse along n at the nearest points, up to a relative motion of `wanted` (m); false when they part fast enough or cannot move.
bool CrossingGuard::push(const ClosePair& pair, const Motion& m, const Nearest& nearest, const Vec3& n, double wanted) {
  double inverse = 0;
  for (int k = 0; k < 4; ++k) inverse += nearest.weight[k] * nearest.weight[k] * inverse_mass_[static_cast<std::size_t>(pair.node[k])];
  const double lacking = wanted - n.dot(contact::nearest_of(m.dx, nearest.weight).separation);
  if (!(inverse > 0) || !(lacking > 0)) return false;
  for (int k = 0; k < 4; ++k) {
    const auto node = static_cast<std::size_t>(pair.node[k]);
    if (inverse_mass_[node] == 0 || nearest.weight[k] == 0) continue;
    dx_[node] += (nearest.weight[k] * inverse_mass_[node] * lacking / inverse) * n;
    changed_[node] = touched_[node] = 1;
  }
  return true;
}

/// Keeps `share` of the motion of the four vertices relative to each other.
void CrossingGuard::shorten(const ClosePair& pair, const Motion& m, double share) {
  double mass = 0;
  Vec3 mean = Vec3::Zero();
  bool is_held = false;
  for (int k = 0; k < 4; ++k) {
    const double inverse = inverse_mass_[static_cast<std::size_t>(pair.node[k])];
    is_held = is_held || inverse == 0;
    if (inverse == 0) continue;
    mass += 1 / inverse;
    mean += m.dx[k] / inverse;
  }
  mean = is_held || !(mass > 0) ? Vec3(Vec3::Zero()) : Vec3(mean / mass);
  for (int k = 0; k < 4; ++k) {
    const auto node = static_cast<std::size_t>(pair.node[k]);
    if (inverse_mass_[node] == 0) continue;
    dx_[node] = mean + share * (m.dx[k] - mean);
    changed_[node] = touched_[node] = 1;
  }
}

/// Changes the motion of the pair's vertices so that it does not come too near; false when an earlier change has seen to that.
bool CrossingGuard::stop(const ClosePair& pair, std::span<const double> x0) {
  const Motion m = motion_of(pair, x0);
  const Nearest start = contact::nearest_points(pair.is_edges, m.x);
  const double distance = start.separation.norm();
  if (is_to_be_led_apart(pair, m, start, distance) && push(pair, m, start, start.separation / distance, recovery * (options_.least_distance - distance))) return true;
  const double share = contact::share_of_approach(pair.is_edges, m.x, m.dx, least_of(distance));
  if (share >= 1) return false;
  FourPoints y;
  for (int k = 0; k < 4; ++k) y[k] = m.x[k] + share * m.dx[k];
  const Nearest then = contact::nearest_points(pair.is_edges, y);
  const Vec3 n = then.separation.normalized();
  // Nearest points that slide past each other may part at the end, though they come too near on the way.
  if (!push(pair, m, then, n, approach_kept * share * n.dot(contact::nearest_of(m.dx, then.weight).separation))) shorten(pair, m, approach_kept * share);
  return true;
}

/// Lists hold while no pair outside them can have come within reach: what lay within range by its relative motion, what lay beyond by any. True when renewed.
bool CrossingGuard::renew_lists(std::span<const double> x0) {
  const auto& used = pairs_.vertices();
  since_.resize(used.size());
  until_.resize(used.size());
  std::vector<std::array<double, 2>> largest(static_cast<std::size_t>(thread_count()), {0.0, 0.0});
  const auto measure = [&] {
    parallel_ranges(static_cast<std::ptrdiff_t>(used.size()), [&](std::ptrdiff_t begin, std::ptrdiff_t end, int thread) {
      double moved = 0, longest = 0;
      bool is_finite = true;
      for (std::ptrdiff_t k = begin; k < end; ++k) {
        const auto q = static_cast<std::size_t>(k);
        const Vec3 step = dx_[static_cast<std::size_t>(used[q])];
        since_[q] = at(x0, used[q]) - at(x_search_, used[q]);
        until_[q] = since_[q] + step;
        moved = std::max({moved, since_[q].squaredNorm(), until_[q].squaredNorm()});
        longest = std::max(longest, step.squaredNorm());
        is_finite = is_finite && std::isfinite(until_[q].squaredNorm());
      }
      largest[static_cast<std::size_t>(thread)] = {is_finite ? moved : NAN, longest};
    });
    std::array<double, 2> all{0, 0};
    for (const auto& l : largest) {
      if (!std::isfinite(l[0])) throw TrustError("contact: positions are not finite; the run has diverged");
      for (int c = 0; c < 2; ++c) all[c] = std::max(all[c], std::sqrt(l[c]));
    }
    return all;  // moved since the search, moved in this step
  };
  const auto [moved, step] = measure();
  if (has_searched_ && 2 * moved + options_.least_distance < range_) {
    approach_ = std::max(neighbours_.bound(since_), neighbours_.bound(until_));
    if (approach_ + options_.least_distance < pairs_.radius()) return false;
  }
  std::copy_n(x0.begin(), x_search_.size(), x_search_.begin());
  has_searched_ = true;
  measure();
  range_ = std::max(range_share * mean_edge_, room * (2 * step + options_.least_distance));
  neighbours_.place(x0, used, range_ + 2 * pairs_.longest_edge(x0));
  approach_ = neighbours_.bound(until_);
  const double needed = room * (approach_ + options_.least_distance);
  const double wished = std::clamp(steps_per_search * approach_, radius_share_least * mean_edge_, radius_share_most * mean_edge_);
  pairs_.update(x0, std::min(range_, std::max(needed, wished)));
  return true;
}

/// Pairs that come too near, in an order of their own; after the first look only those that a change may concern.
void CrossingGuard::find_offenders(std::span<const double> x0, bool is_first, GuardResult& result) {
  if (renew_lists(x0)) result.searched = is_first = true;
  const auto near = pairs_.pairs_within(approach_ + options_.least_distance);
  is_offender_.assign(near.size(), 0);
  parallel_pieces(static_cast<std::ptrdiff_t>(near.size()), 256, [&](std::ptrdiff_t begin, std::ptrdiff_t end, int) {
    for (std::ptrdiff_t k = begin; k < end; ++k) {
      const ClosePair& pair = near[static_cast<std::size_t>(k)];
      const auto has_changed = [&](int node) { return changed_[static_cast<std::size_t>(node)] != 0; };
      if (!is_first && std::none_of(pair.node.begin(), pair.node.end(), has_changed)) continue;
      is_offender_[static_cast<std::size_t>(k)] = comes_too_near(pair, x0);
    }
  });
  offenders_.clear();
  for (std::size_t k = 0; k < near.size(); ++k)
    if (is_offender_[k]) offenders_.push_back(near[k]);
  std::sort(offenders_.begin(), offenders_.end(), [](const ClosePair& a, const ClosePair& b) { return a.key() < b.key(); });
}

/// Vertices joined by offending pairs get the mean motion of their group, until none offends. `offenders_` holds them at the begin.
void CrossingGuard::move_as_one(std::span<const double> x0, GuardResult& result) {
  std::vector<int> parent(dx_.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int n) {
    while (parent[static_cast<std::size_t>(n)] != n) n = parent[static_cast<std::size_t>(n)] = parent[static_cast<std::size_t>(parent[static_cast<std::size_t>(n)])];
    return n;
  };
  struct Group {
    double mass = 0;
    Vec3 momentum = Vec3::Zero();
    bool is_held = false;
  };
  std::vector<Group> groups(dx_.size());
  while (!offenders_.empty()) {
    std::vector<char> is_new(dx_.size(), 0);
    for (const ClosePair& pair : offenders_)
      for (int n : pair.node) {
        const int a = root(pair.node[0]), b = root(n);
        parent[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
        is_new[static_cast<std::size_t>(n)] = 1;
      }
    // Groups that grew are summed again, members in ascending order.
    std::vector<char> has_grown(dx_.size(), 0);
    for (int n : pairs_.vertices())
      if (is_new[static_cast<std::size_t>(n)]) has_grown[static_cast<std::size_t>(root(n))] = 1;
    for (int n : pairs_.vertices()) {
      const auto r = static_cast<std::size_t>(root(n));
      if (has_grown[r]) groups[r] = Group();
    }
    for (int n : pairs_.vertices()) {
      Group& g = groups[static_cast<std::size_t>(root(n))];
      if (!has_grown[static_cast<std::size_t>(root(n))]) continue;
      const double inverse = inverse_mass_[static_cast<std::size_t>(n)];
      if (inverse == 0) {
        g.is_held = true;
        continue;
      }
      g.mass += 1 / inverse;
      g.momentum += dx_[static_cast<std::size_t>(n)] / inverse;
    }
    std::fill(changed_.begin(), changed_.end(), 0);
    for (int n : pairs_.vertices()) {
      const auto r = static_cast<std::size_t>(root(n));
      if (!has_grown[r] || inverse_mass_[static_cast<std::size_t>(n)] == 0) continue;
      dx_[static_cast<std::size_t>(n)] = groups[r].is_held ? Vec3(Vec3::Zero()) : Vec3(groups[r].momentum / groups[r].mass);
      changed_[static_cast<std::size_t>(n)] = touched_[static_cast<std::size_t>(n)] = 1;
    }
    find_offenders(x0, false, result);
    // Within a group nothing moves; what offends there did so at the begin and is left as it was.
    std::erase_if(offenders_, [&](const ClosePair& pair) {
      const int r = root(pair.node[0]);
      return std::all_of(pair.node.begin(), pair.node.end(), [&](int n) { return root(n) == r; });
    });
  }
  for (int n : pairs_.vertices()) result.locked += root(n) != n;
}

GuardResult CrossingGuard::apply(std::span<const double> x0, std::span<double> x1) {
  GuardResult result;
  moved_.clear();
  shifts_.clear();
  const auto& used = pairs_.vertices();
  parallel_for(static_cast<std::ptrdiff_t>(used.size()), [&](std::ptrdiff_t k) {
    const int v = used[static_cast<std::size_t>(k)];
    dx_[static_cast<std::size_t>(v)] = at(x1, v) - at(x0, v);
  });
  find_offenders(x0, true, result);
  if (offenders_.empty()) return result;
  std::fill(touched_.begin(), touched_.end(), 0);
  while (!offenders_.empty()) {
    if (result.sweeps == options_.sweeps_max) {
      move_as_one(x0, result);
      break;
    }
    std::fill(changed_.begin(), changed_.end(), 0);
    for (const ClosePair& pair : offenders_) result.stopped += stop(pair, x0);
    ++result.sweeps;
    find_offenders(x0, false, result);
  }
  for (int v : used) {
    if (!touched_[static_cast<std::size_t>(v)]) continue;
    Eigen::Map<Vec3> end(x1.data() + 3 * static_cast<std::size_t>(v));
    const Vec3 corrected = at(x0, v) + dx_[static_cast<std::size_t>(v)];
    moved_.push_back(v);
    shifts_.push_back(corrected - end);
    end = corrected;
  }
  return result;
}

}  // namespace mv
