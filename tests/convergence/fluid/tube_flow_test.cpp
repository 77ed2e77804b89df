// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "solver/fluid/navier_stokes.h"

namespace {

// Poiseuille flow in an elliptic tube with half axes a, b under a pressure gradient: relative error of the flow.
double flow_error(int cells_across, double offset) {
  const double a = 1.0, b = 0.8, rho = 1, mu = 1, gradient = 1;
  mv::FluidGrid grid;
  grid.h = 2 * a / cells_across;
  grid.n = {cells_across + 6, cells_across + 6, 2};
  grid.lower = {-0.5 * grid.n[0] * grid.h + offset * grid.h, -0.5 * grid.n[1] * grid.h + 0.7 * offset * grid.h, 0};
  std::vector<Eigen::Vector2d> section;
  for (int i = 0; i < 720; ++i) section.emplace_back(a * std::cos(2 * M_PI * i / 720), b * std::sin(2 * M_PI * i / 720));
  mv::NavierStokes solver(grid, mv::FluidBoundary(), mv::make_tube_wall(grid, section), rho, mu);
  auto state = solver.make_state();
  const double drop = gradient * grid.n[2] * grid.h;
  state.boundary_pressure[2][0] = drop;
  mv::FaceField force(grid);
  const double dt = solver.stable_step(state);
  // The slowest mode decays alone after a while: three equally spaced samples give the steady flow (Aitken).
  const int steps = static_cast<int>(0.25 / dt);
  std::array<double, 3> sample{};
  for (double& flow : sample) {
    for (int s = 0; s < steps; ++s) solver.advance(state, force, dt, {{{0, 0}, {0, 0}, {drop, 0}}});
    flow = solver.flow_through_z(state, 1);
  }
  const double change = sample[2] - sample[1];
  const double flow = sample[2] - change * change / (change - (sample[1] - sample[0]));
  const double exact = M_PI / (4 * mu) * a * a * a * b * b * b / (a * a + b * b) * gradient;
  return std::abs(flow / exact - 1);
}

TEST(Poiseuille, elliptic_tube_flow_converges_at_several_cell_offsets) {
  for (double offset : {0.0, 0.31}) {
    const double e8 = flow_error(8, offset), e16 = flow_error(16, offset), e32 = flow_error(32, offset);
    std::printf("Poiseuille, elliptic tube, offset %.2f: flow error %.2e %.2e %.2e, order %.2f over two refinements\n", offset, e8, e16, e32,
                0.5 * std::log2(e8 / e32));
    EXPECT_LT(e16, 0.03);
    EXPECT_LT(e32, 0.01);
    EXPECT_GT(0.5 * std::log2(e8 / e32), 1.5);
  }
}

}  // namespace
