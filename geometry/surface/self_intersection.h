// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Exact self-intersection of a triangle surface (CGAL, exact predicates). CGAL stays inside the .cpp.

#include <array>
#include <utility>
#include <vector>

#include "geometry/core/case.h"
#include "geometry/volume/gates.h"

namespace mv {

/// Pairs (i < j, sorted) of triangles that intersect in more than what they share (a common vertex or edge), decided with exact
/// predicates on the double coordinates. Triangles with a repeated index, or degenerate ones, pair with themselves (i, i).
/// Throws InputError for an index out of range or a coordinate that is not finite.
std::vector<std::pair<int, int>> self_intersections(const std::vector<Vec3>& points,
                                                    const std::vector<std::array<int, 3>>& triangles);

/// Gate "leaflets.self_intersections": pairs on the boundary of the mesh (order 2: each face as 4 flat triangles); limit 0.
Gate gate_self_intersection(const LeafletMesh& mesh);
/// The same on given positions, e.g. of a deformed frame. Name of the gate as given.
Gate gate_self_intersection(const LeafletMesh& mesh, const std::vector<Vec3>& positions, const char* name);

}  // namespace mv
