// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// How far two triangle surfaces lie apart (mm).

#include <array>
#include <span>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

/// Distance of x from a triangle, mm (not squared).
double triangle_distance(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c);

/// Distance of each point from the nearest triangle. Throws InputError for no triangles, indices out of range.
std::vector<double> distances_to_surface(std::span<const Vec3> from, const std::vector<Vec3>& points, const std::vector<std::array<int, 3>>& triangles);

/// Both directions together: each surface is sampled at the centroids of its triangles split until no edge is longer than `spacing`, weighted by area, each direction
/// counting half.
struct SurfaceDistance {
  double mean = 0, p95 = 0, max = 0;
  double mean_a_to_b = 0, mean_b_to_a = 0;
};
SurfaceDistance surface_distance(const std::vector<Vec3>& points_a, const std::vector<std::array<int, 3>>& triangles_a, const std::vector<Vec3>& points_b,
                                 const std::vector<std::array<int, 3>>& triangles_b, double spacing = 1);

}  // namespace mv
