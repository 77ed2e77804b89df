// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "solver/fluid/navier_stokes.h"

namespace {

// Poiseuille flow in an elliptic tube with half axes a, b under a pressure gradient: relative L2 error of the velocity. The flow starts
// from the exact profile and runs until the scheme's own error has reached its steady value. The wall stencil is exact for the parabola, so
// a quartic profile kept up by a body force shows the order.
double profile_error(int cells_across, double offset, bool is_quartic) {
  const double a = 1.0, b = 0.8, rho = 1, mu = 1, gradient = 1;
  mv::FluidGrid grid;
  grid.h = 2 * a / cells_across;
  grid.n = {cells_across + 6, cells_across + 6, 2};
  grid.lower = {-0.5 * grid.n[0] * grid.h + offset * grid.h, -0.5 * grid.n[1] * grid.h + 0.7 * offset * grid.h, 0};
  std::vector<Eigen::Vector2d> section;
  for (int i = 0; i < 1440; ++i) section.emplace_back(a * std::cos(2 * M_PI * i / 1440), b * std::sin(2 * M_PI * i / 1440));
  mv::NavierStokes solver(grid, mv::FluidBoundary(), mv::make_tube_wall(grid, section), rho, mu);
  auto state = solver.make_state();
  auto exact = [&](int i, int j) {
    const double x = (grid.lower.x() + (i + 0.5) * grid.h) / a, y = (grid.lower.y() + (j + 0.5) * grid.h) / b;
    const double r2 = x * x + y * y;
    return std::max(0.0, is_quartic ? 1 - r2 * r2 : gradient / (2 * mu) * a * a * b * b / (a * a + b * b) * (1 - r2));
  };
  const double drop = is_quartic ? 0.0 : gradient * grid.n[2] * grid.h;
  for (int k = 0; k <= grid.n[2]; ++k)
    for (int j = 0; j < grid.n[1]; ++j)
      for (int i = 0; i < grid.n[0]; ++i) {
        state.velocity.c[2][static_cast<std::size_t>(grid.index(i, j, k))] = exact(i, j);
        if (k < grid.n[2]) state.pressure[static_cast<std::size_t>(grid.index(i, j, k))] = drop * (1 - (k + 0.5) / grid.n[2]);
      }
  state.boundary_pressure[2][0] = drop;
  mv::FaceField force(grid);
  if (is_quartic)
    for (int k = 0; k <= grid.n[2]; ++k)
      for (int j = 0; j < grid.n[1]; ++j)
        for (int i = 0; i < grid.n[0]; ++i) {
          const double x = grid.lower.x() + (i + 0.5) * grid.h, y = grid.lower.y() + (j + 0.5) * grid.h;
          const double r2 = x * x / (a * a) + y * y / (b * b);
          const double laplacian = 8 * (x * x / std::pow(a, 4) + y * y / std::pow(b, 4)) + 4 * r2 * (1 / (a * a) + 1 / (b * b));
          force.c[2][static_cast<std::size_t>(grid.index(i, j, k))] = mu * laplacian;
        }
  const double dt = solver.stable_step(state);
  const int steps = static_cast<int>(0.3 / dt);
  for (int s = 0; s < steps; ++s) solver.advance(state, force, dt, {{{0, 0}, {0, 0}, {drop, 0}}});
  double error = 0, norm = 0;
  for (int j = 0; j < grid.n[1]; ++j)
    for (int i = 0; i < grid.n[0]; ++i) {
      const double d = state.velocity.c[2][static_cast<std::size_t>(grid.index(i, j, 1))] - exact(i, j);
      error += d * d;
      norm += exact(i, j) * exact(i, j);
    }
  return std::sqrt(error / norm);
}

TEST(Poiseuille, elliptic_tube_profile_is_exact_wherever_the_wall_cuts_the_cells) {
  for (double offset : {0.0, 0.31, 0.47}) {
    const double coarse = profile_error(8, offset, false), middle = profile_error(16, offset, false);
    std::printf("Poiseuille, elliptic tube, offset %.2f: relative velocity error %.2e (8 cells across) %.2e (16)\n", offset, coarse, middle);
    EXPECT_LT(coarse, 2e-3);
    EXPECT_LT(middle, 1e-3);
  }
}

TEST(Poiseuille, quartic_profile_converges_with_second_order) {
  for (double offset : {0.0, 0.31}) {
    const double coarse = profile_error(8, offset, true), middle = profile_error(16, offset, true), fine = profile_error(24, offset, true);
    std::printf("quartic profile, elliptic tube, offset %.2f: relative velocity error %.2e %.2e %.2e, order %.2f from 8 to 24 cells across\n", offset, coarse, middle,
                fine, std::log(coarse / fine) / std::log(3.0));
    EXPECT_GT(std::log(coarse / fine) / std::log(3.0), 1.7);
  }
}

}  // namespace
