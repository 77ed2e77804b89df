// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The flat pattern of a ring-shaped valve is periodic in u: one node of an element may lie at u = 0 and its neighbour near u =
// period.

#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

/// Period of the unfolded coordinate u (mm), or 0 when no element crosses a seam (an open patch, or one leaflet alone).
/// Elements on the seam are those that span more than half of the whole range of u. On the mid-surface's annulus the pattern
/// keeps lengths, so the period is the raw jump of the annulus edge on the seam plus that edge's length, averaged over the atrial
/// and the ventricular face (which lie equally far inside and outside). Without such an edge: the range of u plus the widest edge
/// elsewhere.
inline double unfolded_period(const LeafletMesh& mesh) {
  if (mesh.unfolded.empty()) return 0;
  double u_min = mesh.unfolded[0].x(), u_max = u_min;
  for (const Vec2& p : mesh.unfolded) {
    u_min = std::min(u_min, p.x());
    u_max = std::max(u_max, p.x());
  }
  const double range = u_max - u_min;
  double widest_inner = 0;
  double length_of_side[2] = {0, 0}, period_of_side[2] = {0, 0};
  bool has_seam = false;
  for (const auto& tet : mesh.tets) {
    for (int i = 0; i < 4; ++i) {
      for (int j = i + 1; j < 4; ++j) {
        const auto a = static_cast<std::size_t>(tet[static_cast<std::size_t>(i)]);
        const auto b = static_cast<std::size_t>(tet[static_cast<std::size_t>(j)]);
        const double jump = std::abs(mesh.unfolded[a].x() - mesh.unfolded[b].x());
        if (jump <= 0.5 * range) {
          widest_inner = std::max(widest_inner, jump);
          continue;
        }
        has_seam = true;
        if (!mesh.on_annulus[a] || !mesh.on_annulus[b] || mesh.side[a] != mesh.side[b] || mesh.side[a] == between) continue;
        const double length = (mesh.points[a] - mesh.points[b]).norm();
        const int face = mesh.side[a] == atrial ? 0 : 1;
        if (length_of_side[face] == 0 || length < length_of_side[face]) {
          length_of_side[face] = length;
          period_of_side[face] = jump + length;
        }
      }
    }
  }
  if (!has_seam) return 0;
  if (period_of_side[0] > 0 && period_of_side[1] > 0) return 0.5 * (period_of_side[0] + period_of_side[1]);
  const double one_face = std::max(period_of_side[0], period_of_side[1]);
  return one_face > 0 ? one_face : range + widest_inner;
}

/// The image of u_b that lies nearest to u_a.
inline double nearest_image(double u_b, double u_a, double period) {
  return period > 0 ? u_b - period * std::round((u_b - u_a) / period) : u_b;
}

}  // namespace mv
