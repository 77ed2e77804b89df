// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Nearest points of a point and a triangle and of two segments, and how far two of these may move before they come too near.
// Pure functions, no memory. Closest points by regions as in Ericson, Real-Time Collision Detection (2005), 5.1.5 and 5.1.9; time
// of approach by additive continuous collision detection (Li, Kaufman & Jiang 2021, Codimensional Incremental Potential Contact,
// algorithm 1), written anew.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace mv::contact {

/// Four points: of a point and a triangle {p, a, b, c} (`is_edges` false), or of two segments {a, b, c, d} (a-b and c-d).
using FourPoints = std::array<Eigen::Vector3d, 4>;
using FourWeights = std::array<double, 4>;

/// sum_k weight[k] x[k] = nearest point of the first minus nearest point of the second: weights of the first add up to 1, of the second to -1.
struct Nearest {
  FourWeights weight;
  Eigen::Vector3d separation;  // m, from the second to the first
};

inline Nearest nearest_of(const FourPoints& x, const FourWeights& w) {
  return {w, w[0] * x[0] + w[1] * x[1] + w[2] * x[2] + w[3] * x[3]};
}

/// Point x[0], triangle x[1], x[2], x[3] (may be degenerate).
inline Nearest nearest_point_triangle(const FourPoints& x) {
  using Vec3 = Eigen::Vector3d;
  const Vec3 ab = x[2] - x[1], ac = x[3] - x[1], ap = x[0] - x[1];
  const auto at = [&](double u, double v, double w) { return nearest_of(x, {1, -u, -v, -w}); };
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return at(1, 0, 0);
  const Vec3 bp = x[0] - x[2];
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return at(0, 1, 0);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 - d3 > 0) return at(1 - d1 / (d1 - d3), d1 / (d1 - d3), 0);
  const Vec3 cp = x[0] - x[3];
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return at(0, 0, 1);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 - d6 > 0) return at(1 - d2 / (d2 - d6), 0, d2 / (d2 - d6));
  const double va = d3 * d6 - d5 * d4;
  const double along = d4 - d3, back = d5 - d6;
  if (va <= 0 && along >= 0 && back >= 0 && along + back > 0) return at(0, back / (along + back), along / (along + back));
  const double sum = va + vb + vc;
  if (!(sum > 0)) return at(1, 0, 0);
  return at(1 - vb / sum - vc / sum, vb / sum, vc / sum);
}

/// Segments x[0]-x[1] and x[2]-x[3] (may be points or parallel).
inline Nearest nearest_segments(const FourPoints& x) {
  using Vec3 = Eigen::Vector3d;
  const Vec3 d1 = x[1] - x[0], d2 = x[3] - x[2], r = x[0] - x[2];
  const double a = d1.squaredNorm(), e = d2.squaredNorm(), f = d2.dot(r), c = d1.dot(r), b = d1.dot(d2);
  const auto unit = [](double t) { return std::min(1.0, std::max(0.0, t)); };
  double s = 0, t = 0;
  if (a > 0 && e > 0) {
    const double denominator = a * e - b * b;
    s = denominator > 1e-14 * a * e ? unit((b * f - c * e) / denominator) : 0.0;
    t = (b * s + f) / e;
    if (t < 0) {
      t = 0;
      s = unit(-c / a);
    } else if (t > 1) {
      t = 1;
      s = unit((b - c) / a);
    }
  } else if (a > 0) {
    s = unit(-c / a);
  } else if (e > 0) {
    t = unit(f / e);
  }
  return nearest_of(x, {1 - s, s, t - 1, -t});
}

inline Nearest nearest_points(bool is_edges, const FourPoints& x) { return is_edges ? nearest_segments(x) : nearest_point_triangle(x); }

/// Bound on the relative motion of any two points of the pair when its corners move by `dx` (m): common motion is no approach.
inline double relative_motion(bool is_edges, const FourPoints& dx) {
  const Eigen::Vector3d mean = 0.25 * (dx[0] + dx[1] + dx[2] + dx[3]);
  std::array<double, 4> n;
  for (int k = 0; k < 4; ++k) n[k] = (dx[k] - mean).norm();
  return is_edges ? std::max(n[0], n[1]) + std::max(n[2], n[3]) : n[0] + std::max({n[1], n[2], n[3]});
}

/// Share of the motion x -> x + dx after which the pair has come within `least` (m, less than the distance at x) but for a tenth of the clearance it
/// began with; 1 when it does not within the whole motion. Never too large: up to there the pair stays further apart than `least`.
inline double share_of_approach(bool is_edges, const FourPoints& x, const FourPoints& dx, double least) {
  constexpr double clearance_left = 0.1, advance = 0.9;
  constexpr int steps_max = 200;  // reached only when nothing but round-off is left of the clearance
  const double motion = relative_motion(is_edges, dx);
  const double clearance = nearest_points(is_edges, x).separation.norm() - least;
  if (!(motion > 0) || clearance > motion) return 1;
  double share = 0, next = advance * clearance / motion;
  for (int step = 0; step < steps_max; ++step) {
    if (share + next >= 1) return 1;
    share += next;
    FourPoints y;
    for (int k = 0; k < 4; ++k) y[k] = x[k] + share * dx[k];
    const double left = nearest_points(is_edges, y).separation.norm() - least;
    if (left < clearance_left * clearance) return share;
    next = advance * left / motion;
  }
  return share;
}

}  // namespace mv::contact
