// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Keeps a surface from passing through itself, whatever its forces do: the last word on the motion of a step.
//
// A surface that does not cross at the begin of a step crosses at its end only if on the way a vertex has met a triangle or an edge an edge. For every
// such pair (also neighbours along the surface, also sheets seen from behind: nothing but pairs with a common vertex is left out) the motion x0 -> x1 is
// judged by continuous collision detection against a least distance. Where it comes nearer, the pair's nearest points are stopped along their
// normal at the instant of approach by an inelastic impulse J = w_k n: the motion of vertex k changes by w_k J / m_k. Sweeps over the pairs that are
// left repeat this; what then still comes too near moves as one with the mean motion of its vertices (Provot 1997; Bridson, Fedkiw & Anderson 2002,
// with translations only), so that it always ends. Linear momentum is kept to round-off (but for fixed vertices), and angular momentum by the impulses.
// Pairs that start nearer than the least distance keep half of what they have, and are led apart by a tenth of what lacks a step.

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "solver/contact/close_pairs.h"
#include "solver/contact/relative_motion.h"

namespace mv {

struct GuardOptions {
  double least_distance = 0;  // m; auto: 1e-3 mean edges at rest
  int sweeps_max = 30;        // before what is left moves as one
};

struct GuardResult {
  int stopped = 0;  // impulses
  int sweeps = 0;
  int locked = 0;   // vertices that moved as one with others
  bool searched = false;
};

class CrossingGuard {
 public:
  /// `rest`: 3 * vertices (m). `masses`: per vertex (kg), positive; `is_fixed`: per vertex (such vertices are never moved). Copies what it needs. Throws
  /// InputError on sizes that do not match.
  CrossingGuard(std::span<const double> rest, std::span<const std::array<int, 3>> triangles, std::span<const double> masses, std::span<const char> is_fixed,
                const GuardOptions& options = {});

  /// Changes the end `x1` of the straight motion x0 -> x1 (both 3 * vertices or longer, m) where it would come too near. Vertices without a triangle are left alone.
  /// Results are the same for every thread count and do not depend on earlier calls. Throws TrustError when positions are not finite.
  GuardResult apply(std::span<const double> x0, std::span<double> x1);

  /// Vertices moved by the last apply(), ascending, and by how much (m).
  std::span<const int> moved() const { return moved_; }
  std::span<const Eigen::Vector3d> shifts() const { return shifts_; }
  const ClosePairs& pairs() const { return pairs_; }
  const GuardOptions& options() const { return options_; }

 private:
  using Vec3 = Eigen::Vector3d;
  struct Motion {
    contact::FourPoints x, dx;
  };
  Motion motion_of(const ClosePair& pair, std::span<const double> x0) const;
  double least_of(double distance) const;
  bool is_to_be_led_apart(const ClosePair& pair, const Motion& m, const contact::Nearest& start, double distance) const;
  bool comes_too_near(const ClosePair& pair, std::span<const double> x0) const;
  bool push(const ClosePair& pair, const Motion& m, const contact::Nearest& nearest, const Vec3& n, double wanted);
  void shorten(const ClosePair& pair, const Motion& m, double share);
  bool stop(const ClosePair& pair, std::span<const double> x0);
  bool renew_lists(std::span<const double> x0);
  void find_offenders(std::span<const double> x0, bool is_first, GuardResult& result);
  void move_as_one(std::span<const double> x0, GuardResult& result);

  ClosePairs pairs_;
  GuardOptions options_;
  std::vector<double> inverse_mass_;  // per vertex; 0 when fixed
  double mean_edge_ = 0;
  std::vector<double> x_search_;      // positions of the last search
  bool has_searched_ = false;
  RelativeMotion neighbours_;
  double range_ = 0;                  // m, what lies further away than this was not looked at by neighbours_
  // Of a call.
  double approach_ = 0;               // m, a bound on what two vertices within range have moved relative to each other since the search, over the whole step
  std::vector<Vec3> since_, until_;   // m, motion since the search of each vertex of pairs_.vertices(), up to the begin and to the end of the step
  std::vector<Vec3> dx_;              // per vertex
  std::vector<char> changed_;         // per vertex: since the last look
  std::vector<char> touched_;         // per vertex: by this call
  std::vector<ClosePair> offenders_;
  std::vector<char> is_offender_;     // per pair within reach
  std::vector<int> moved_;
  std::vector<Vec3> shifts_;
};

}  // namespace mv
