// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Flat pattern of a ring of leaflets whose nodes are to stay: u in [0, perimeter) by arc length along the annulus, v from 0 there to the local height at the
// free edge (mm).
//
// Both coordinates are Tutte's barycentric map on the cylinder: every inner node lies at the mean of its neighbours, u is given on both borders (by arc length), v is 0
// and 1 there. With increasing u along both borders no triangle is folded (Tutte 1963; Gortler, Gotsman & Thurston 2006 for the cylinder). v is then stretched
// by the height h(u), the distance along the mesh from the free edge to the annulus, which keeps the order along every meridian.

#include <array>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

struct RingPattern {
  std::vector<Vec2> unfolded;  // per point
  double perimeter = 0;        // mm, period of u
};

/// `annulus` and `free_edge`: closed loops of points in the direction of the triangles' edges (the free edge runs against u). Throws InputError when a point is
/// joined to neither border.
RingPattern unfold_ring(const std::vector<Vec3>& points, const std::vector<std::array<int, 3>>& triangles, const std::vector<int>& annulus, const std::vector<int>& free_edge);

/// Smallest area (mm2) of an unfolded triangle; positive when the pattern has no fold.
double smallest_unfolded_area(const RingPattern& pattern, const std::vector<std::array<int, 3>>& triangles);

}  // namespace mv
