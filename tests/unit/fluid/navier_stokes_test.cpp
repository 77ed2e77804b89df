// SPDX-License-Identifier: BSD-3-Clause
#include "solver/fluid/navier_stokes.h"

#include <gtest/gtest.h>

#include <random>

#include "geometry/core/parallel.h"

namespace {

std::vector<Eigen::Vector2d> ellipse(double a, double b, int n = 200) {
  std::vector<Eigen::Vector2d> p;
  for (int i = 0; i < n; ++i) p.emplace_back(a * std::cos(2 * M_PI * i / n), b * std::sin(2 * M_PI * i / n));
  return p;
}

mv::NavierStokes tube(int nx, int ny, int nz, double h) {
  mv::FluidGrid grid;
  grid.n = {nx, ny, nz};
  grid.h = h;
  grid.lower = {-0.5 * nx * h, -0.5 * ny * h, 0};
  return mv::NavierStokes(grid, mv::FluidBoundary(), mv::make_tube_wall(grid, ellipse(0.4 * nx * h, 0.35 * ny * h)), 1060, 2e-3);
}

void randomise(mv::FaceField& f, double scale) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-scale, scale);
  for (auto& c : f.c)
    for (double& v : c) v = uniform(random);
}

TEST(NavierStokes, divergence_is_at_round_off_after_a_step_with_rough_forces) {
  auto solver = tube(14, 12, 20, 1e-3);
  auto state = solver.make_state();
  mv::FaceField force(solver.grid());
  randomise(force, 1e5);
  for (int n = 0; n < 5; ++n) solver.advance(state, force, 1e-5, {{{0, 0}, {0, 0}, {1000.0 * n, 0}}});
  EXPECT_LT(solver.relative_divergence(state), 1e-11);
  EXPECT_GT(solver.peak_velocity(state), 1e-4);
}

// Also where the tube ends far from the box: who would leave its sides out, because nothing moves beyond the wall, is wrong.
TEST(NavierStokes, layers_beyond_the_sides_mirror_the_flow_however_near_the_wall_of_the_tube_is) {
  for (double share : {0.0, 0.2, 0.25, 0.3, 0.35, 0.38, 0.40, 0.42, 0.44, 0.46, 0.49}) {
    mv::FluidGrid grid;
    grid.n = {16, 14, 6};
    grid.h = 1e-3;
    grid.lower = {-8e-3, -7e-3, 0};
    const auto section = share > 0 ? ellipse(share * 16e-3, share * 14e-3) : std::vector<Eigen::Vector2d>();
    mv::NavierStokes solver(grid, mv::FluidBoundary(), mv::make_tube_wall(grid, section), 1060, 2e-3);
    auto state = solver.make_state();
    mv::FaceField force(grid);
    randomise(force, 1e5);
    for (int n = 0; n < 3; ++n) solver.advance(state, force, 1e-5, {{{0, 0}, {0, 0}, {1000, 0}}});
    solver.apply_velocity_boundary(state.velocity);
    double worst = 0, largest = 0;
    for (std::size_t c = 0; c < 3; ++c)
      for (int k = 0; k < grid.n[2]; ++k)
        for (std::size_t axis = 0; axis < 2; ++axis)
          for (int q = 0; q < grid.n[1 - axis]; ++q)
            for (int layer = 1; layer <= 2; ++layer)
              for (const bool is_upper : {false, true}) {
                const auto value = [&](int along) {
                  return state.velocity.c[c][static_cast<std::size_t>(axis == 0 ? grid.index(along, q, k) : grid.index(q, along, k))];
                };
                const bool is_normal = c == axis;
                const int n = grid.n[axis];
                // No slip, no flow: odd about the side; normal velocities stand on it.
                const int out = is_upper ? (is_normal ? n + layer : n - 1 + layer) : -layer, in = is_upper ? n - layer : (is_normal ? layer : layer - 1);
                worst = std::max(worst, std::abs(value(out) + value(in)));
                largest = std::max(largest, std::abs(value(in)));
                if (is_normal) worst = std::max(worst, std::abs(value(is_upper ? n : 0)));
              }
    EXPECT_EQ(worst, 0) << share;
    EXPECT_GT(largest, 0) << share;  // the projection knows the box alone, so that outside the tube the flow is small, not zero
  }
}

TEST(NavierStokes, energy_budget_of_a_closed_box_closes) {
  mv::FluidGrid grid;
  grid.n = {16, 16, 4};
  grid.h = 1.0 / 16;
  mv::FluidBoundary boundary;
  boundary.side = {{{mv::BoundaryKind::periodic, mv::BoundaryKind::periodic}, {mv::BoundaryKind::periodic, mv::BoundaryKind::periodic}, {mv::BoundaryKind::periodic, mv::BoundaryKind::periodic}}};
  mv::NavierStokes solver(grid, boundary, mv::make_tube_wall(grid, {}), 1.0, 0.01);
  auto state = solver.make_state();
  for (int k = 0; k < 4; ++k)
    for (int j = 0; j < 16; ++j)
      for (int i = 0; i < 16; ++i) {
        const auto p = static_cast<std::size_t>(grid.index(i, j, k));
        state.velocity.c[0][p] = std::sin(2 * M_PI * i / 16) * std::cos(2 * M_PI * (j + 0.5) / 16);
        state.velocity.c[1][p] = -std::cos(2 * M_PI * (i + 0.5) / 16) * std::sin(2 * M_PI * j / 16);
      }
  mv::FaceField force(grid);
  const double before = solver.kinetic_energy(state);
  double lost = 0;
  for (int n = 0; n < 400; ++n) {
    const auto r = solver.advance(state, force, 5e-4, {});
    lost += r.viscous_loss + r.advection_loss;
  }
  const double after = solver.kinetic_energy(state);
  EXPECT_LT(after, 0.9 * before);
  EXPECT_NEAR((before - after) / lost, 1.0, 5e-3);
}

TEST(NavierStokes, does_not_depend_on_the_thread_count) {
  std::vector<double> first;
  for (int threads : {1, 2}) {
    mv::set_thread_count(threads);
    auto solver = tube(14, 12, 20, 1e-3);
    auto state = solver.make_state();
    mv::FaceField force(solver.grid());
    randomise(force, 1e5);
    for (int n = 0; n < 5; ++n) solver.advance(state, force, 1e-5, {{{0, 0}, {0, 0}, {1000.0 * n, 0}}});
    if (first.empty()) first = state.velocity.c[2];
    else EXPECT_EQ(first, state.velocity.c[2]);
  }
}

TEST(NavierStokes, a_column_of_blood_accelerates_as_newton_says) {
  mv::FluidGrid grid;
  grid.n = {4, 4, 30};
  grid.h = 1e-3;
  mv::FluidBoundary boundary;
  boundary.side[0] = boundary.side[1] = {mv::BoundaryKind::symmetry, mv::BoundaryKind::symmetry};
  mv::NavierStokes solver(grid, boundary, mv::make_tube_wall(grid, {}), 1060, 2e-3);
  auto state = solver.make_state();
  mv::FaceField force(grid);
  state.boundary_pressure[2][0] = 100.0;
  for (int n = 0; n < 100; ++n) solver.advance(state, force, 1e-5, {{{0, 0}, {0, 0}, {100.0, 0}}});
  const double expected = 100.0 / (1060 * 30e-3) * 1e-3;
  EXPECT_NEAR(solver.flow_through_z(state, 15) / (16e-6) / expected, 1.0, 0.01);
}

}  // namespace
