// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/tube_flow.h"

// NavierStokes::stable_step is honest: at that step everything stays bounded, at a few times that step it does not.
namespace {

using mv::BoundaryKind;

mv::FluidBoundary all_periodic() {
  mv::FluidBoundary boundary;
  for (auto& axis : boundary.side) axis = {BoundaryKind::periodic, BoundaryKind::periodic};
  return boundary;
}

void randomise(mv::FaceField& field, const std::array<double, 3>& mean, double scale) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-scale, scale);
  for (std::size_t c = 0; c < 3; ++c)
    for (double& v : field.c[c]) v = mean[c] + uniform(random);
}

// Noise on a uniform stream in a periodic box; its kinetic energy after 300 steps over that at the start. `factor` multiplies the stable step.
double noise_growth(const Eigen::Vector3d& stream, double cell_reynolds, double factor) {
  mv::FluidGrid grid;
  grid.n = {8, 8, 8};
  grid.h = 1.0 / 8;
  const double viscosity = cell_reynolds > 0 ? stream.norm() * grid.h / cell_reynolds : 0.0;
  mv::NavierStokes solver(grid, all_periodic(), mv::make_tube_wall(grid, {}), 1.0, viscosity);
  auto state = solver.make_state();
  randomise(state.velocity, {0, 0, 0}, 1e-4);
  solver.project(state.velocity);
  const double noise_before = solver.kinetic_energy(state);
  for (std::size_t c = 0; c < 3; ++c)
    for (double& v : state.velocity.c[c]) v += stream[static_cast<Eigen::Index>(c)];
  const mv::FaceField no_force(grid);
  for (int s = 0; s < 300 && solver.peak_velocity(state) < 10; ++s) solver.advance(state, no_force, factor * solver.stable_step(state), {});
  mv::FlowState noise = state;
  for (std::size_t c = 0; c < 3; ++c)
    for (double& v : noise.velocity.c[c]) v -= stream[static_cast<Eigen::Index>(c)];
  return solver.kinetic_energy(noise) / noise_before;
}

TEST(StableStep, noise_on_a_stream_does_not_grow_whatever_the_direction_and_the_cell_reynolds_number) {
  double worst = 0;
  for (const Eigen::Vector3d& direction : {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 1), Eigen::Vector3d(1, 1, 1), Eigen::Vector3d(-1, 0.5, 0.2)})
    for (double cell_reynolds : {0.0, 0.1, 1.0, 2.0, 4.5, 10.0, 100.0}) {  // 0: no viscosity; 4.5: both limits alike
      const double growth = noise_growth(direction.normalized(), cell_reynolds, 1.0);
      worst = std::max(worst, growth);
      EXPECT_LT(growth, 1.0) << direction.transpose() << ", cell Reynolds number " << cell_reynolds;
    }
  std::printf("stable step: largest growth of noise energy over 28 streams %.3g\n", worst);
  const double viscous = noise_growth(Eigen::Vector3d(1, 1, 1).normalized(), 0.1, 1.5), inviscid = noise_growth(Eigen::Vector3d(1, 1, 1).normalized(), 0.0, 1.5);
  std::printf("at 1.5 times the stable step: %.3g (viscous) %.3g (inviscid)\n", viscous, inviscid);
  EXPECT_GT(viscous, 10.0);
  EXPECT_GT(inviscid, 10.0);
}

// Rough flow in a tube, closed on itself along z with a stream, or open at both ends without one (a stream through open ends brings energy in).
TEST(StableStep, flow_along_walls_that_cut_cells_loses_energy_without_and_with_extreme_viscosity) {
  for (bool is_closed : {true, false})
    for (double viscosity : {0.0, 4e-3, 0.1, 1.0})
      for (double offset : {0.0, 0.31, 0.47}) {
        const mv::FluidGrid grid = mv::test::tube_grid(8e-3, 16, offset, 12);
        mv::FluidBoundary boundary;
        if (is_closed) boundary.side[2] = {BoundaryKind::periodic, BoundaryKind::periodic};
        mv::NavierStokes solver(grid, boundary, mv::make_tube_wall(grid, mv::test::ellipse_section(8e-3, 6.5e-3)), 1060, viscosity);
        auto state = solver.make_state();
        randomise(state.velocity, {0, 0, is_closed ? 1.0 : 0.0}, 1.0);
        solver.project(state.velocity);
        const double before = solver.kinetic_energy(state);
        const mv::FaceField no_force(grid);
        double largest = 0, time = 0;
        constexpr int steps = 200;
        for (int s = 0; s < steps; ++s) {
          const double dt = solver.stable_step(state);
          solver.advance(state, no_force, dt, {});
          time += dt;
          largest = std::max(largest, solver.kinetic_energy(state) / before);
        }
        std::printf("tube, %s, viscosity %g Pa s, offset %.2f: mean step %.2e s, kinetic energy at most %.3f, at the end %.3f of the start's\n", is_closed ? "periodic" : "open", viscosity,
                    offset, time / steps, largest, solver.kinetic_energy(state) / before);
        EXPECT_LT(largest, 1.0);
        EXPECT_LT(solver.relative_divergence(state), 1e-10);
      }
}

// The three-dimensional vortex without viscosity, far beyond the time at which the grid no longer resolves it: what the scheme loses it must not give back.
TEST(StableStep, inviscid_taylor_green_vortex_stays_bounded) {
  mv::FluidGrid grid;
  grid.n = {16, 16, 16};
  grid.h = 2 * M_PI / 16;
  mv::NavierStokes solver(grid, all_periodic(), mv::make_tube_wall(grid, {}), 1.0, 0.0);
  auto state = solver.make_state();
  for (int k = 0; k < 16; ++k)
    for (int j = 0; j < 16; ++j)
      for (int i = 0; i < 16; ++i) {
        const auto p = static_cast<std::size_t>(grid.index(i, j, k));
        const double h = grid.h;
        state.velocity.c[0][p] = std::sin(i * h) * std::cos((j + 0.5) * h) * std::cos((k + 0.5) * h);
        state.velocity.c[1][p] = -std::cos((i + 0.5) * h) * std::sin(j * h) * std::cos((k + 0.5) * h);
      }
  const double before = solver.kinetic_energy(state);
  const mv::FaceField no_force(grid);
  double energy = before, lost = 0, time = 0;
  while (time < 20) {
    const double dt = solver.stable_step(state);
    const auto report = solver.advance(state, no_force, dt, {});
    const double now = solver.kinetic_energy(state);
    // The first step is Euler's.
    EXPECT_LT(now, energy * (1 + (time == 0 ? 2e-4 : 1e-6))) << "at " << time;
    energy = now;
    lost += report.advection_loss;
    time += dt;
    ASSERT_LT(solver.peak_velocity(state), 4.0);
  }
  std::printf("inviscid Taylor-Green, 16^3, t = 20: kinetic energy %.4f of the start's, reported loss of the scheme %.4f\n", energy / before, lost / before);
  EXPECT_NEAR((before - energy) / lost, 1.0, 0.02);
}

}  // namespace
