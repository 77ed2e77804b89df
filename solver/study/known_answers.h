// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Problems whose answer is known, run in this process with one thread.

#include "solver/study/study_table.h"

namespace mv {

/// Blood at rest in a circular tube, set in motion by a sudden pressure difference: flow and axial velocity against the series of Szymanski (J. Math. Pures Appl. 11,
/// 1932). Ladders over the cells across the tube and over the step. `is_small`: two rungs, for tests.
StudyTable tube_start_table(bool is_small = false);

/// A tight sheet clamped across a rectangular tube and loaded by blood on one side. Nothing leaks, and at rest it bulges as far and carries the
/// stress that it does under the same pressure without blood, which quadratic elements give. Ladders over fluid and solid spacing, order, step, kernel and relaxation.
StudyTable sheet_table(bool is_small = false);

/// Flow (m3/s) and axial velocity (m/s) at time t of the tube's start; G pressure gradient (Pa/m), R radius (m), density, viscosity SI.
struct TubeStart {
  double flow = 0, axial_velocity = 0;
};
TubeStart tube_start(double gradient, double radius, double density, double viscosity, double time);

}  // namespace mv
