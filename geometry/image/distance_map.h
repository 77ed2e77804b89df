// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Exact Euclidean distances on a grid.

#include <array>
#include <functional>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

/// Distance (in the unit of `spacing`) from every node of the grid, i fastest, to the nearest node for which is_seed(node) holds; infinity
/// everywhere when there is none. Three passes of lower envelopes of parabolas, Felzenszwalb and Huttenlocher 2012. The grid's axes are
/// taken as perpendicular.
std::vector<float> distance_map(const std::array<int, 3>& size, const Vec3& spacing, const std::function<bool(std::size_t)>& is_seed);

}  // namespace mv
