// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "geometry/core/case.h"

namespace mv {

/// Cubic smoothing spline through ordered points (mm), as smooth as a root mean square distance of `noise` allows (discrepancy principle), resampled about every
/// `spacing`. The ends are kept to within noise / 3. Fewer than 4 points come back as they are.
std::vector<Vec3> smooth_open_curve(const std::vector<Vec3>& points, double noise, double spacing);

}  // namespace mv
