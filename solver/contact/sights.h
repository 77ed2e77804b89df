// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The triangles that one slave node sees, side by side in vector lanes, and what is summed over them.

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "geometry/core/pack.h"
#include "solver/contact/leaf_frames.h"

namespace mv::contact {

using Lanes = std::array<double, lanes>;
/// A vector in each lane.
using Pack3 = std::array<Pack, 3>;
/// Forces on the three corners of the triangle in each lane, N.
using Reactions = std::array<Pack3, 3>;

MV_INLINE Pack load(const Lanes& v) { return mv::load(v.data()); }

/// Distance p from the triangle's plane (m), weight, the factor chi of it, u = (lateral distance / reach)^2, barycentric coordinates l of the foot and b of the
/// closest point (of the second and third corner), unit normal and edges. A lane without a triangle has weight and chi 0 and repeats the first one's number.
struct alignas(64) SightBlock {
  Lanes p, weight, chi, u, reach_squared, l1, l2, b1, b2;
  std::array<Lanes, 3> n, e1, e2;
  std::array<int, lanes> triangle;
};

class Sights {
 public:
  void clear() { count_ = 0; }

  /// `found`: p, weight, chi, u, reach_squared, l1, l2, b1, b2 of the leaf, in `lane`; the triangle itself is in `leaf_lane` of `frames`.
  void add(int triangle, const std::array<Lanes, 9>& found, int lane, const LeafFrames& frames, int leaf_lane) {
    const std::size_t l = count_ % lanes, from = static_cast<std::size_t>(lane), at = static_cast<std::size_t>(leaf_lane);
    if (count_ / lanes == blocks_.size()) blocks_.emplace_back();
    SightBlock& b = blocks_[count_ / lanes];
    ++count_;
    Lanes* const values[] = {&b.p, &b.weight, &b.chi, &b.u, &b.reach_squared, &b.l1, &b.l2, &b.b1, &b.b2};
    for (std::size_t v = 0; v < found.size(); ++v) (*values[v])[l] = found[v][from];
    for (std::size_t c = 0; c < 3; ++c) {
      b.n[c][l] = frames.n[c][at];
      b.e1[c][l] = frames.e1[c][at];
      b.e2[c][l] = frames.e2[c][at];
    }
    b.triangle[l] = triangle;
  }

  /// Fills the lanes behind the last triangle; to be called before blocks().
  void pad() {
    if (count_ % lanes == 0) return;
    SightBlock& b = blocks_[count_ / lanes];
    for (std::size_t l = count_ % lanes; l < lanes; ++l) {
      for (Lanes* v : {&b.p, &b.weight, &b.chi, &b.u, &b.l1, &b.l2, &b.b1, &b.b2}) (*v)[l] = 0;
      for (auto* v : {&b.n, &b.e1, &b.e2})
        for (Lanes& c : *v) c[l] = 0;
      b.reach_squared[l] = 1;
      b.triangle[l] = b.triangle[0];
    }
  }

  std::span<SightBlock> blocks() { return {blocks_.data(), (count_ + lanes - 1) / lanes}; }
  std::span<const SightBlock> blocks() const { return {blocks_.data(), (count_ + lanes - 1) / lanes}; }

 private:
  std::vector<SightBlock> blocks_;
  std::size_t count_ = 0;
};

inline Eigen::Vector3d sum_of(const Pack3& v) { return {mv::sum_of(v[0]), mv::sum_of(v[1]), mv::sum_of(v[2])}; }

/// A symmetric matrix.
template <class T>
struct Inertia {
  T xx, yy, zz, xy, xz, yz;
};

inline Eigen::Matrix3d matrix_of(const Inertia<Pack>& sum) {
  using mv::sum_of;
  const double xy = sum_of(sum.xy), xz = sum_of(sum.xz), yz = sum_of(sum.yz);
  Eigen::Matrix3d m;
  m << sum_of(sum.xx), xy, xz, xy, sum_of(sum.yy), yz, xz, yz, sum_of(sum.zz);
  return m;
}

/// Adds `share` times a triangle's mean of r x v over the corners to `spin` and of |r|^2 I - r r^T to `inertia`, r from the centroid; e1, e2, dv1, dv2: places and velocities of the
/// second and third corner relative to the first.
MV_INLINE void add_turning(const Pack3& e1, const Pack3& e2, const Pack3& dv1, const Pack3& dv2, Pack share, Pack3& spin, Inertia<Pack>& inertia) {
  // The corners' r add up to zero, so that velocities relative to the first do; sum r r^T = 2/3 (e1 e1^T + e2 e2^T) - 1/3 (e1 e2^T + e2 e1^T).
  Pack3 r1, r2, p, q;
  for (std::size_t c = 0; c < 3; ++c) {
    const Pack centre = (e1[c] + e2[c]) / 3.0;
    r1[c] = e1[c] - centre;
    r2[c] = e2[c] - centre;
    p[c] = share * (2.0 * e1[c] - e2[c]) / 9.0;
    q[c] = share * (2.0 * e2[c] - e1[c]) / 9.0;
  }
  const Pack third = share / 3.0;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::size_t d = (c + 1) % 3, e = (c + 2) % 3;
    spin[c] += third * ((r1[d] * dv1[e] - r1[e] * dv1[d]) + (r2[d] * dv2[e] - r2[e] * dv2[d]));
  }
  const auto moment = [&](std::size_t a, std::size_t b) { return p[a] * e1[b] + q[a] * e2[b]; };
  const Pack xx = moment(0, 0), yy = moment(1, 1), zz = moment(2, 2);
  inertia.xx += yy + zz;
  inertia.yy += xx + zz;
  inertia.zz += xx + yy;
  inertia.xy -= moment(0, 1);
  inertia.xz -= moment(0, 2);
  inertia.yz -= moment(1, 2);
}

}  // namespace mv::contact
