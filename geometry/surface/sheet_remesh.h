// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Even triangles on an open surface, its crumbs removed (CGAL, kept inside the .cpp). Internal to mid_surface_of_solid.

#include <functional>
#include <string>
#include <vector>

#include "geometry/surface/solid_depth.h"

namespace mv {

struct SheetOptions {
  double spacing = 0.5;       // mm, wanted edge
  double smallest_part = 0;   // mm2, parts below are dropped
  double shortest_hole = 0;   // mm, holes with a shorter rim are filled
  std::function<double(const Vec3&)> rim_distance;  // mm, to the rims that the sheet should have
  double rim_reach = 0;       // mm, holes whose mean distance to the rims is larger are filled ...
  double longest_hole = 0;    // mm, ... when their rim is shorter than this: a long border is the sheet's, wherever its level ends
};

/// Oriented manifold with border. Every part dropped and hole filled is told in `notes`; the largest part stays in any case.
LevelSurface tidy_sheet(const LevelSurface& surface, const SheetOptions& options, std::vector<std::string>& notes);

/// Closed border loops as point indices, the surface on the left; longest first. Parts: component number per triangle.
std::vector<std::vector<int>> border_loops(const std::vector<Vec3>& points, const std::vector<std::array<int, 3>>& triangles);
std::vector<int> connected_parts(const std::vector<std::array<int, 3>>& triangles, std::size_t points, int* count = nullptr);

}  // namespace mv
