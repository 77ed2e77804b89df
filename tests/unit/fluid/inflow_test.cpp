// SPDX-License-Identifier: BSD-3-Clause
// Sides with a given normal velocity (BoundaryKind::inflow).
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "solver/fluid/navier_stokes.h"

namespace {

using mv::BoundaryKind;

constexpr double h = 1e-3, density = 1000, viscosity = 0.05;

/// A channel along `axis` with the inflow on its `side`, open opposite; across it `across` on the next axis, periodic on the third.
mv::NavierStokes channel(std::size_t axis, std::size_t side, int length, int width, BoundaryKind across) {
  mv::FluidGrid grid;
  grid.n[axis] = length;
  grid.n[(axis + 1) % 3] = width;
  grid.n[(axis + 2) % 3] = 3;
  grid.h = h;
  mv::FluidBoundary boundary;
  boundary.side[axis] = {BoundaryKind::open, BoundaryKind::open};
  boundary.side[axis][side] = BoundaryKind::inflow;
  boundary.side[(axis + 1) % 3] = {across, across};
  boundary.side[(axis + 2) % 3] = {BoundaryKind::periodic, BoundaryKind::periodic};
  return {grid, boundary, mv::make_tube_wall(grid, {}), density, viscosity};
}

std::size_t face(const mv::FluidGrid& grid, std::size_t axis, int along, int q1, int q2) {
  std::array<int, 3> at{};
  at[axis] = along;
  at[(axis + 1) % 3] = q1;
  at[(axis + 2) % 3] = q2;
  return static_cast<std::size_t>(grid.index(at[0], at[1], at[2]));
}

/// Sum of the normal velocities of a plane of faces.
double flow_through(const mv::NavierStokes& fluid, const mv::FlowState& state, std::size_t axis, int along) {
  const mv::FluidGrid& grid = fluid.grid();
  double sum = 0;
  for (int q2 = 0; q2 < grid.n[(axis + 2) % 3]; ++q2)
    for (int q1 = 0; q1 < grid.n[(axis + 1) % 3]; ++q1) sum += state.velocity.c[axis][face(grid, axis, along, q1, q2)];
  return sum;
}

TEST(Inflow, rough_and_changing_inflow_leaves_through_the_open_side_to_round_off) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t side = 0; side < 2; ++side) {
      mv::NavierStokes fluid = channel(axis, side, 12, 7, BoundaryKind::wall);
      mv::FlowState state = fluid.make_state();
      const mv::FaceField force(fluid.grid());
      std::mt19937 random(5);
      std::uniform_real_distribution<double> uniform(-0.1, 0.3);
      std::vector<double> profile(7 * 3);
      for (int step = 0; step < 5; ++step) {
        double entering = 0;
        for (double& u : profile) entering += u = uniform(random);
        fluid.set_inflow(axis, side, profile);
        fluid.advance(state, force, 1e-4, {});
        for (int along : {0, 5, 12}) EXPECT_NEAR(flow_through(fluid, state, axis, along), entering, 1e-12);
        EXPECT_EQ(state.velocity.c[axis][face(fluid.grid(), axis, side == 0 ? 0 : 12, 2, 1)], profile[2 + 7 * 1]);
      }
      EXPECT_LT(fluid.relative_divergence(state), 1e-12);
    }
}

TEST(Inflow, uniform_profile_fills_a_slippery_channel_at_once) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    mv::NavierStokes fluid = channel(axis, 1, 10, 6, BoundaryKind::symmetry);
    mv::FlowState state = fluid.make_state();
    const mv::FaceField force(fluid.grid());
    fluid.set_inflow(axis, 1, std::vector<double>(6 * 3, -0.2));
    for (int step = 0; step < 20; ++step) fluid.advance(state, force, 1e-4, {});
    for (int along = 0; along <= 10; ++along)
      for (int q1 = 0; q1 < 6; ++q1) EXPECT_NEAR(state.velocity.c[axis][face(fluid.grid(), axis, along, q1, 1)], -0.2, 1e-12);
  }
}

// The scheme's own Poiseuille profile: where the wall lies half a cell beyond the last value, second differences of y (H - y) + h^2/4
// are -2 everywhere. From rest the channel needs a few H^2 / nu to fill.
TEST(Inflow, parabolic_profile_is_carried_through_the_channel_exactly) {
  constexpr int width = 8, length = 16;
  constexpr double curvature = 2e3, dt = 1e-3;  // 1/(m s), s
  for (std::size_t axis : {0u, 2u}) {
    mv::NavierStokes fluid = channel(axis, 0, length, width, BoundaryKind::wall);
    mv::FlowState state = fluid.make_state();
    const mv::FaceField force(fluid.grid());
    std::vector<double> profile(width * 3);
    for (int q = 0; q < width * 3; ++q) {
      const double y = (q % width + 0.5) * h;
      profile[static_cast<std::size_t>(q)] = curvature * (y * (width * h - y) + 0.25 * h * h);
    }
    fluid.set_inflow(axis, 0, profile);
    for (int step = 0; step < 4000; ++step) fluid.advance(state, force, dt, {});
    for (int along = 0; along <= length; ++along)
      for (int q1 = 0; q1 < width; ++q1) {
        const double u = state.velocity.c[axis][face(fluid.grid(), axis, along, q1, 1)];
        EXPECT_NEAR(u, profile[static_cast<std::size_t>(q1)], 1e-10 * profile[width / 2]);
      }
    // The pressure falls by 2 mu curvature a metre, to zero at the open side.
    for (int along = 0; along < length; ++along) {
      const double expected = 2 * viscosity * curvature * (length - along - 0.5) * h;
      EXPECT_NEAR(state.pressure[face(fluid.grid(), axis, along, 3, 1)], expected, 1e-9 * expected);
    }
  }
}

}  // namespace
