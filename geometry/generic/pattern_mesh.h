// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Well-graded triangulation of the wrapped flat pattern.

#include "geometry/generic/generic_valve.h"

namespace mv {

/// Triangulates 0 <= v <= height(u) with near-equilateral triangles measured in space, not in the pattern. Boundary and commissure
/// columns are sampled by arc length; interior points come from incremental remeshing (split, collapse, Delaunay flips with the angles
/// in space, smoothing); every point stays exactly on the wrapped surface because it lives in (u, v). Deterministic.
/// Longest edge <= 1.25 spacing is checked: throws GateError otherwise or when an angle falls below 20 degrees.
MidSurface mesh_pattern(const FlatPattern& pattern, const ConeWrap& wrap, double spacing, SurfaceMeshReport* report = nullptr);

}  // namespace mv
