// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Closed surfaces of voxels without stair steps.

#include <array>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

struct MeshSmoothing {
  double length = 3;  // lambda, in edges of the mesh
  double reach = 0.6;  // how far a point may move, in the unit of the points (voxels)
};

/// Points that minimise  sum |L x|^2 + lambda^-4 sum |x - x0|^2  with |x - x0| <= reach, L = point minus mean of its neighbours: waves shorter than
/// 2 pi lambda edges vanish, longer ones stay, and no point leaves what its voxel allows (constrained elastic surface nets, Gibson 1998,
/// with the thin-plate energy). It acts along the surface only, so the two faces of a thin sheet do not see each other.
/// Returns the number of iterations.
int smooth_mesh(std::vector<Vec3>& points, const std::vector<std::array<int, 3>>& triangles, const MeshSmoothing& options);

}  // namespace mv
