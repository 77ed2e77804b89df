// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Distance of points to triangles (CGAL's box tree inside the .cpp). Internal to mv_unfold.

#include <array>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

/// Distance (mm) of each point to the nearest triangle. Degenerate triangles are left out.
std::vector<double> distances_to_surface(const std::vector<Vec3>& from, const std::vector<Vec3>& points,
                                         const std::vector<std::array<int, 3>>& triangles);

}  // namespace mv
