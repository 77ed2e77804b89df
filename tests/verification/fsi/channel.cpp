// SPDX-License-Identifier: BSD-3-Clause
#include "verification/fsi/channel.h"

#include <cmath>
#include <cstdio>

namespace mv::test {

SlabSetup channel_setup(double width, double length, int cells, double density, double viscosity) {
  SlabSetup setup;
  const double h = width / cells;
  setup.grid = slab_grid({0, width}, {0, h * std::ceil(length / h - 1e-9)}, h, 1);
  setup.boundary.side[0] = {BoundaryKind::wall, BoundaryKind::wall};
  setup.boundary.side[2] = {BoundaryKind::inflow, BoundaryKind::open};
  setup.density = density;
  setup.viscosity = viscosity;
  return setup;
}

std::vector<double> parabola(const FluidGrid& grid, double coefficient) {
  const double width = grid.n[0] * grid.h;
  std::vector<double> profile;
  for (int j = 0; j < grid.n[1]; ++j)
    for (int i = 0; i < grid.n[0]; ++i) {
      const double x = (i + 0.5) * grid.h;
      profile.push_back(coefficient * (x * (width - x) - grid.h * grid.h / 12));
    }
  return profile;
}

double pressure_at(const SlabFlow& flow, double x, double z) {
  const FluidGrid& grid = flow.fluid().grid();
  const double s = (x - grid.lower[0]) / grid.h - 0.5, t = (z - grid.lower[2]) / grid.h - 0.5;
  const int i = static_cast<int>(s), k = static_cast<int>(t);
  const double a = s - i, b = t - k;
  const auto p = [&](int di, int dk) { return flow.flow().pressure[static_cast<std::size_t>(grid.index(i + di, 0, k + dk))]; };
  return (1 - b) * ((1 - a) * p(0, 0) + a * p(1, 0)) + b * ((1 - a) * p(0, 1) + a * p(1, 1));
}

void print_comparison(const char* what, double computed, double reference) {
  std::printf("  %-28s computed %11.5g  reference %11.5g  difference %+.2f %%\n", what, computed, reference,
              100 * (computed - reference) / std::abs(reference));
  std::fflush(stdout);
}

}  // namespace mv::test
