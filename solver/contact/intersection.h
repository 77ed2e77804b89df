// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Exact self-intersection of a triangulated surface: every decision is the sign of a determinant computed without rounding.

#include <Eigen/Core>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "solver/contact/surface.h"

namespace mv {

/// Whether two closed triangles share at least one point (touching counts). Exact for non-degenerate triangles.
bool triangles_intersect(const std::array<Eigen::Vector3d, 3>& a, const std::array<Eigen::Vector3d, 3>& b);

/// Pairs (i < j, ascending) of intersecting triangles, by the convention of CGAL's PMP::self_intersections: triangles without a
/// common vertex intersect when they share a point; with one common vertex when the edge opposite to it in one meets the other;
/// with two when they are coplanar and on the same side of their edge; with three always. A degenerate triangle (collinear or
/// coincident corners, exactly) is listed as (i, i) and takes part in no other pair. `points`: per vertex; `triangles`: vertex
/// indices. Throws InputError on coordinates that are not finite. Same answer for every thread count.
std::vector<std::pair<int, int>> self_intersections(std::span<const Eigen::Vector3d> points,
                                                    std::span<const std::array<int, 3>> triangles);

/// The same for a contact surface in the configuration x (3 * solid_nodes).
std::vector<std::pair<int, int>> self_intersections(const ContactSurface& surface, std::span<const double> x);

}  // namespace mv
