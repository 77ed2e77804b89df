// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "support/tube_flow.h"

namespace {

struct Errors {
  double velocity = 0, flow = 0;  // relative: root mean square, volume flow
};

// Steady flow in an elliptic tube with half axes 1 and b: starts from the exact profile and runs until the scheme's own error has reached its steady value. The wall
// stencil is exact for the parabola of a pressure gradient, so a quartic profile kept up by a body force shows the order.
Errors profile_errors(double b, int cells_across, double offset, bool is_quartic) {
  const double rho = 1, mu = 1, gradient = 1;
  const mv::FluidGrid grid = mv::test::tube_grid(1.0, cells_across, offset, 1);
  mv::NavierStokes solver(grid, mv::FluidBoundary(), mv::make_tube_wall(grid, mv::test::ellipse_section(1.0, b)), rho, mu);
  auto state = solver.make_state();
  const double peak = is_quartic ? 1.0 : gradient * b * b / (2 * mu * (1 + b * b));
  auto exact = [&](double x, double y) {
    const double r2 = x * x + y * y / (b * b);
    return peak * (1 - (is_quartic ? r2 * r2 : r2));
  };
  const double exact_flow = M_PI * b * peak * (is_quartic ? 2.0 / 3 : 0.5);
  const double drop = is_quartic ? 0.0 : gradient * grid.n[2] * grid.h;
  mv::test::start_from(solver, state, drop, exact);
  mv::FaceField force(grid);
  if (is_quartic)
    for (int k = 0; k <= grid.n[2]; ++k)
      mv::test::for_open_faces(solver, k, [&](double x, double y, std::size_t p) {
        force.c[2][p] = mu * (8 * (x * x + y * y / std::pow(b, 4)) + 4 * (x * x + y * y / (b * b)) * (1 + 1 / (b * b)));
      });
  const double dt = solver.stable_step(state);
  const int steps = static_cast<int>(0.4 / dt);
  for (int s = 0; s < steps; ++s) solver.advance(state, force, dt, {{{0, 0}, {0, 0}, {drop, 0}}});
  double error = 0, norm = 0;
  mv::test::for_open_faces(solver, 0, [&](double x, double y, std::size_t p) {
    error += std::pow(state.velocity.c[2][p] - exact(x, y), 2);
    norm += std::pow(exact(x, y), 2);
  });
  return {std::sqrt(error / norm), std::abs(mv::test::open_flow(solver, state, 0) / exact_flow - 1)};
}

const char* shape(double b) { return b == 1.0 ? "circular" : "elliptic"; }

TEST(Poiseuille, profile_and_flow_rate_are_near_exact_wherever_the_wall_cuts_the_cells) {
  for (double b : {1.0, 0.8})
    for (double offset : {0.0, 0.31, 0.47}) {
      const Errors coarse = profile_errors(b, 8, offset, false), fine = profile_errors(b, 16, offset, false);
      std::printf("Poiseuille, %s tube, offset %.2f: relative velocity error %.1e (8 cells across) %.1e (16), flow rate %.1e %.1e\n", shape(b), offset, coarse.velocity, fine.velocity,
                  coarse.flow, fine.flow);
      EXPECT_LT(coarse.velocity, 3e-3);
      EXPECT_LT(fine.velocity, 7e-4);
      // What is left of the flow rate is the sum over cells that the wall cuts.
      EXPECT_LT(coarse.flow, 2e-2);
      EXPECT_LT(fine.flow, 3e-3);
    }
}

// The order rises towards two on finer grids: see wall_stencil_test.cpp, up to 128 cells across, at more offsets.
void expect_quartic_order(double b) {
  for (double offset : {0.0, 0.47}) {
    std::array<Errors, 3> e;
    for (int level = 0; level < 3; ++level) e[static_cast<std::size_t>(level)] = profile_errors(b, 8 << level, offset, true);
    std::printf("quartic profile, %s tube, offset %.2f: relative velocity error %.2e %.2e %.2e (8, 16, 32 cells across), order %.2f %.2f; flow rate %.2e %.2e %.2e, order %.2f over both\n",
                shape(b), offset, e[0].velocity, e[1].velocity, e[2].velocity, mv::test::observed_order(e[0].velocity, e[1].velocity),
                mv::test::observed_order(e[1].velocity, e[2].velocity), e[0].flow, e[1].flow, e[2].flow, mv::test::observed_order(e[0].flow, e[2].flow, 4));
    EXPECT_GT(mv::test::observed_order(e[0].velocity, e[2].velocity, 4), 1.7);
    EXPECT_GT(mv::test::observed_order(e[1].velocity, e[2].velocity), 1.8);
    EXPECT_LT(e[2].velocity, 5e-3);
    EXPECT_LT(e[2].flow, 5e-3);
  }
}

TEST(Poiseuille, quartic_profile_in_a_circular_tube_converges) { expect_quartic_order(1.0); }
TEST(Poiseuille, quartic_profile_in_an_elliptic_tube_converges) { expect_quartic_order(0.8); }

}  // namespace
