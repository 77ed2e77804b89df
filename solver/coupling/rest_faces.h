// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Rigid bodies as faces of the staggered grid that carry no flow (NavierStokes::set_rest_faces). A surface becomes a staircase of faces, as wide on the average as the
// surface itself: no kernel widens it. What kernels would hold (points that keep the blood at rest around them) acts wider by half the kernel's support on each side, two
// cells with ib4 (tests/verification/orifice_test.cpp).

#include <Eigen/Core>
#include <array>
#include <vector>

#include "solver/fluid/navier_stokes.h"

namespace mv {

/// A triangle of a surface (m, tube frame).
using RestTriangle = std::array<Eigen::Vector3d, 3>;

/// Every face whose line between the two cell centres beside it meets a triangle: cells on either side of the surface are not joined by any path through open faces that
/// does not go around the surface's border. Borders count as part of a triangle. Sorted, each face once; parts outside the box are left out.
RestFaces faces_crossed(const FluidGrid& grid, const std::vector<RestTriangle>& triangles);

}  // namespace mv
