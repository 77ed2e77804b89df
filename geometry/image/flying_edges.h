// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Isosurfaces on grids. VTK stays inside the .cpp.

#include <array>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

struct GridSurface {
  std::vector<Vec3> points;                   // in units of grid steps
  std::vector<std::array<int, 3>> triangles;  // closed where the level does not touch the border; normal towards lower values in a right-handed frame
};

/// Surface where the field on a grid (i fastest) has the value `level`. Nodes that are nearer to the level than `clearance` count as that far
/// off, so that no slivers arise at them.
GridSurface flying_edges(const std::array<int, 3>& size, const std::vector<float>& field, double level, double clearance);

}  // namespace mv
