// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "solver/fluid/navier_stokes.h"

namespace {

// Decaying Taylor-Green vortex in a periodic box, translated by a uniform stream: largest error of u at the end.
double taylor_green_error(int n) {
  mv::FluidGrid grid;
  grid.n = {n, n, 2};
  grid.h = 1.0 / n;
  mv::FluidBoundary boundary;
  for (auto& axis : boundary.side) axis = {mv::BoundaryKind::periodic, mv::BoundaryKind::periodic};
  const double rho = 1, mu = 0.01, k = 2 * M_PI, stream = 0.5;
  mv::NavierStokes solver(grid, boundary, mv::make_tube_wall(grid, {}), rho, mu);
  auto state = solver.make_state();
  auto exact_u = [&](double x, double y, double t) { return stream + std::exp(-2 * mu * k * k * t) * std::sin(k * (x - stream * t)) * std::cos(k * (y - stream * t)); };
  auto exact_v = [&](double x, double y, double t) { return stream - std::exp(-2 * mu * k * k * t) * std::cos(k * (x - stream * t)) * std::sin(k * (y - stream * t)); };
  for (int kk = 0; kk < 2; ++kk)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const auto p = static_cast<std::size_t>(grid.index(i, j, kk));
        state.velocity.c[0][p] = exact_u(i * grid.h, (j + 0.5) * grid.h, 0);
        state.velocity.c[1][p] = exact_v((i + 0.5) * grid.h, j * grid.h, 0);
      }
  mv::FaceField force(grid);
  const double end = 0.25;
  const int steps = 8 * n;
  for (int s = 0; s < steps; ++s) solver.advance(state, force, end / steps, {});
  double worst = 0;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i)
      worst = std::max(worst, std::abs(state.velocity.c[0][static_cast<std::size_t>(grid.index(i, j, 0))] - exact_u(i * grid.h, (j + 0.5) * grid.h, end)));
  return worst;
}

TEST(TaylorGreen, converges_with_second_order) {
  const double e16 = taylor_green_error(16), e32 = taylor_green_error(32), e64 = taylor_green_error(64);
  std::printf("Taylor-Green: error %.3e %.3e %.3e, order %.2f %.2f\n", e16, e32, e64, std::log2(e16 / e32), std::log2(e32 / e64));
  EXPECT_GT(std::log2(e16 / e32), 1.8);
  EXPECT_GT(std::log2(e32 / e64), 1.8);
}

}  // namespace
