// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Well-graded triangulation of the wrapped flat pattern.

#include "geometry/generic/generic_valve.h"

namespace mv {

/// Triangulates 0 <= v <= height(u) with near-equilateral triangles measured in space, not in the pattern. Boundary and
/// commissure columns are sampled by arc length; interior points start on staggered rows and are evened out by incremental
/// remeshing (split, collapse, Delaunay flips with the angles in space, smoothing); every point stays exactly on the wrapped
/// surface because it lives in (u, v). Deterministic. Aim: no edge longer than `spacing` on the mid-surface and on both faces,
/// which lie thickness/2 off it. Throws GateError when an edge is longer than 1.25 spacing or an angle falls below 20 degrees.
MidSurface mesh_pattern(const FlatPattern& pattern, const ConeWrap& wrap, double spacing, double thickness,
                        SurfaceMeshReport* report = nullptr);

}  // namespace mv
