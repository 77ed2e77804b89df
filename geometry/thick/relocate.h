// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/thick/tet_mesher.h"

namespace mv {

/// Moves points so that the smallest dihedral angle of the tetrahedra around them grows, where one is below `wanted` (degrees): the best of trial places around the point, nearer and nearer, round
/// after round until nothing improves. Inner points are those that `is_held` does not list (it is as long as the surface has points); points of the surface move only where a tetrahedron
/// below has no other, no further than a tenth of the longest edge there, and not at all where they are held. No tetrahedron becomes worse than the worst around it was. Deterministic. Returns
/// how many are left below `wanted`.
long relocate_points(TetFill& fill, const std::vector<char>& is_held, double wanted);

/// Puts a point into the middle of the longest inner edge of every tetrahedron whose corners are joined by a step (spanning_step) longer than `longest` (mm), until there is none or none of
/// its edges is inside. `surface_points`: the first points, which lie on the surface. Returns how many points were added.
long split_long_steps(TetFill& fill, std::size_t surface_points, const std::vector<std::array<int, 3>>& surface, double longest);

}  // namespace mv
