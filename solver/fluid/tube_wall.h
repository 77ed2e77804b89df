// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The rigid wall of a tube extruded along z, inside the box of the grid. Faces outside the tube carry no flow; the viscous stencil of a
// face beside the wall uses the true distance to it (Shortley & Weller), so that tube flows converge with second order although
// the wall cuts the cells anywhere.

#include <Eigen/Core>
#include <array>
#include <vector>

#include "solver/fluid/grid.h"

namespace mv {

/// Masks and wall stencils of one velocity component; two-dimensional (padded x by padded y) because the tube is extruded along z.
struct WallStencil {
  std::vector<double> open;                   // 1 inside the tube, 0 outside
  std::array<std::vector<double>, 4> weight;  // west, east, south, north: factors of (neighbour - centre)/h^2
};

/// Without a cross-section every face is open and all weights are one.
struct TubeWall {
  bool is_present = false;
  std::array<WallStencil, 3> stencil;  // u, v, w
  double area = 0;                     // m2, of the open cells of w
  double stiffest_weight = 6;          // largest sum of the viscous weights of a face, vertical ones included
};

/// `cross_section`: closed polygon (m, tube frame, either orientation); empty for no wall.
TubeWall make_tube_wall(const FluidGrid& grid, const std::vector<Eigen::Vector2d>& cross_section);

/// True when the point lies inside the closed polygon.
bool is_inside_polygon(const Eigen::Vector2d& p, const std::vector<Eigen::Vector2d>& polygon);

}  // namespace mv
