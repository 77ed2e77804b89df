// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A plane channel in a slab one cell deep: the flow enters at z = 0 with a given profile and leaves at the open upper z side at zero pressure;
// x runs across, no slip at both walls. SI units.

#include <vector>

#include "verification/slab_flow.h"

namespace mv::test {

/// Grid and sides for a channel `width` (m) across in `cells` cells, `length` (m) long, rounded up to whole cells.
SlabSetup channel_setup(double width, double length, int cells, double density, double viscosity);

/// Profile for SlabFlow::set_inflow(2, 0, .): coefficient * x (width - x), averaged over each face so that the flow is exact.
std::vector<double> parabola(const FluidGrid& grid, double coefficient);

/// Bilinear interpolation of the pressure (Pa) between cell centres; the point must lie inside them.
double pressure_at(const SlabFlow& flow, double x, double z);

/// One line: name, computed, reference, difference in per cent of the reference.
void print_comparison(const char* what, double computed, double reference);

}  // namespace mv::test
