// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Rigid bodies at rest in a slab, as the faces of the grid see them: those whose centres lie inside carry no flow, and the viscous term of a face beside them
// uses the true distance to the surface (Shortley & Weller), as NavierStokes does at the tube's wall (solver/fluid/tube_wall.h). No kernel widens the surface.

#include <array>
#include <vector>

#include "solver/fluid/navier_stokes.h"

namespace mv::test {

struct SlabBody {
  /// A face beside the body: what its viscous weights, factors of (neighbour - centre) / h^2, are beyond one along -x, x, -z, z.
  struct CutFace {
    std::ptrdiff_t face;
    std::array<double, 4> excess;
  };
  RestFaces inside;                         // for NavierStokes::set_rest_faces()
  std::array<std::vector<CutFace>, 3> cut;  // per component
};

/// A disc through the whole depth of the slab, inside the box; centre and radius in m.
SlabBody disc_body(const FluidGrid& grid, double x, double z, double radius);

/// NavierStokes::advance() beside a body whose faces `fluid` keeps at rest. Adds what the cut links change of the viscous term (explicit Euler) to `force`.
/// Returns the force (N) of the body on the blood around it: what stops the faces inside, less the change of their momentum, and the links' share.
Eigen::Vector3d advance_around(const SlabBody& body, NavierStokes& fluid, FlowState& state, FaceField& force, double dt,
                               const std::array<std::array<double, 2>, 3>& boundary_pressure);

}  // namespace mv::test
