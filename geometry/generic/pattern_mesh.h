// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Well-graded triangulation of the wrapped flat pattern.

#include <functional>
#include <vector>

#include "geometry/generic/generic_valve.h"
#include "geometry/generic/surface_remesh.h"

namespace mv {

/// Any smooth valve seen through its flat pattern: 0 <= v <= height(u), u periodic, the anterior leaflet over [0, anterior_end].
struct PatternSurface {
  double perimeter = 0;     // mm
  double anterior_end = 0;  // mm, u of the second commissure
  std::function<double(double)> height;                  // mm
  std::function<std::vector<Vec2>(double)> free_edge;    // (u, height) at ascending u in [0, perimeter), no further apart than the argument
  SurfaceMap map;
  std::function<Vec3(const Vec2&)> normal;               // unit, towards the atrial side
};

/// Triangulates 0 <= v <= height(u) with near-equilateral triangles measured in space, not in the pattern. Boundary and
/// commissure columns are sampled by arc length; interior points start on staggered rows and are evened out by incremental
/// remeshing (split, collapse, Delaunay flips with the angles in space, smoothing); every point stays exactly on the wrapped
/// surface because it lives in (u, v). Deterministic. Aim: no edge longer than `spacing` on the mid-surface and on both faces,
/// which lie thickness/2 off it. Throws ConfigError when more than a
/// million triangles would be needed, GateError when an edge is longer than 1.25 spacing or an angle falls below 20 degrees.
MidSurface mesh_pattern(const PatternSurface& surface, double spacing, SurfaceMeshReport* report = nullptr);
/// The same of the generic valve.
MidSurface mesh_pattern(const FlatPattern& pattern, const ConeWrap& wrap, double spacing, double thickness,
                        SurfaceMeshReport* report = nullptr);

}  // namespace mv
