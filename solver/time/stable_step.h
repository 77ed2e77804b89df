// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The stable step from the current tangent. A step is semi-implicit Euler, u += dt B F(x), x += dt u, with the mobility B: stable for
// dt < 2 / omega, omega^2 the largest eigenvalue of B K. Found from the last mode by locally optimal conjugate gradients (Knyazev 2001,
// SIAM J. Sci. Comput. 23:517) in the energy's inner product, so that a few products follow the tangent as fibres stiffen; where the energy is not
// positive (buckling), a step of the plain power iteration stands in. Approached from below. The share of tissue, chordae and contact in v.K.v names what limits the step. The mobility includes the pressure's
// reply, so that the tissue's volumetric stiffness, which cannot move an incompressible blood, does not count.

#include "solver/coupling/coupling.h"
#include "solver/time/structure.h"

namespace mv {

class StableStep {
 public:
  /// `grid`: of the blood; null without.
  explicit StableStep(const FluidGrid* grid);

  /// Improves state.mode_shape by at least `iterations` products, until its frequency settles, and sets state.frequency (rad/s) and state.stiffest_part.
  void update(State& state, Structure& structure, const Coupling* coupling, NavierStokes* fluid, int iterations);

  /// Mixes into state.mode_shape what moves the nodes of the stiffest elements (State::relax_steps; nothing without them): tissue that is loaded elsewhere than
  /// before makes a mode that the last one, found by products alone, does not contain.
  void look_at_stiff_nodes(State& state);

 private:
  /// The same on every machine, orthogonal to nothing.
  const std::vector<double>& noise(std::size_t size);

  std::vector<double> probe_, noise_;
  FaceField scratch_;
};

}  // namespace mv
