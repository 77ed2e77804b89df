// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// The tube's cross-section as a polar curve about the annulus' centre. Internal to mv_tube.

#include <vector>

#include "geometry/core/case.h"

namespace mv {

/// r at equally spaced angles 2 pi i / n, counter-clockwise from e1 (mm).
using PolarOutline = std::vector<double>;

/// Polar form of a closed polygon around the origin, low-passed to `harmonics` Fourier modes. Throws InputError when the polygon
/// is not star-shaped about the origin. `deviation` (may be null): largest radial distance of the polygon from the result.
PolarOutline smooth_polar_outline(const std::vector<Vec2>& polygon, int harmonics, int samples, double* deviation);

/// Smallest smooth widening so that every point lies inside by `clearance` (measured along the radius); returns the largest
/// shift.
double widen_to_contain(PolarOutline& outline, const std::vector<Vec2>& points, double clearance);

double radius_at(const PolarOutline& outline, double angle);
Vec2 point_at(const PolarOutline& outline, double angle);

}  // namespace mv
