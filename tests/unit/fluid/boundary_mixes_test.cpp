// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "solver/fluid/navier_stokes.h"

// Every pair of sides on every axis, for the pressure solver alone and for a step of the flow.
namespace {

using mv::BoundaryKind;
using mv::PoissonSide;

// phi of a cell's neighbour; `given` is the value on Dirichlet sides.
double neighbour(const std::array<int, 3>& n, const std::array<std::array<PoissonSide, 2>, 3>& sides, const std::vector<double>& phi, std::array<int, 3> at, std::size_t axis,
                 std::size_t side, double given) {
  const auto value = [&](const std::array<int, 3>& c) { return phi[static_cast<std::size_t>(c[0] + n[0] * (c[1] + n[1] * c[2]))]; };
  const double here = value(at);
  at[axis] += side == 0 ? -1 : 1;
  if (at[axis] >= 0 && at[axis] < n[axis]) return value(at);
  if (sides[axis][side] == PoissonSide::dirichlet_at_face) return 2 * given - here;
  if (sides[axis][side] == PoissonSide::neumann) return here;
  at[axis] = (at[axis] + n[axis]) % n[axis];
  return value(at);
}

TEST(BoundaryMixes, pressure_solver_is_exact_to_round_off_for_all_125_mixes_with_given_boundary_values) {
  const auto N = PoissonSide::neumann, D = PoissonSide::dirichlet_at_face, P = PoissonSide::periodic;
  const std::array<std::array<PoissonSide, 2>, 5> pairs{{{N, N}, {N, D}, {D, N}, {D, D}, {P, P}}};
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  double worst = 0;
  for (const std::array<int, 3> n : {std::array<int, 3>{6, 5, 7}, std::array<int, 3>{1, 4, 2}, std::array<int, 3>{3, 1, 1}, std::array<int, 3>{2, 2, 48}})
    for (int mix = 0; mix < 125; ++mix) {
      const std::array<std::array<PoissonSide, 2>, 3> sides{pairs[static_cast<std::size_t>(mix % 5)], pairs[static_cast<std::size_t>(mix / 5 % 5)], pairs[static_cast<std::size_t>(mix / 25)]};
      const double h = 1e-3;
      mv::PoissonSolver solver(n, h, sides);
      std::array<std::array<double, 2>, 3> given{};
      bool is_singular = true;
      for (std::size_t axis = 0; axis < 3; ++axis)
        for (std::size_t side = 0; side < 2; ++side)
          if (sides[axis][side] == D) {
            given[axis][side] = normal(random);
            is_singular = false;
          }
      std::vector<double> rhs(static_cast<std::size_t>(n[0] * n[1] * n[2]));
      double mean = 0;
      for (double& r : rhs) {
        r = normal(random) / (h * h);
        mean += r / static_cast<double>(rhs.size());
      }
      if (is_singular)
        for (double& r : rhs) r -= mean;
      std::vector<double> phi = rhs;
      for (std::size_t q = 0; q < phi.size(); ++q) {
        const int i = static_cast<int>(q) % n[0], j = static_cast<int>(q) / n[0] % n[1], k = static_cast<int>(q) / (n[0] * n[1]);
        const std::array<int, 3> at{i, j, k};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          if (at[axis] == 0) phi[q] -= solver.dirichlet_weight() * given[axis][0];
          if (at[axis] == n[axis] - 1) phi[q] -= solver.dirichlet_weight() * given[axis][1];
        }
      }
      solver.solve(phi);
      double largest = 1e-300, residual = 0, sum = 0;
      for (std::size_t q = 0; q < phi.size(); ++q) {
        const int i = static_cast<int>(q) % n[0], j = static_cast<int>(q) / n[0] % n[1], k = static_cast<int>(q) / (n[0] * n[1]);
        double lap = 0;
        for (std::size_t axis = 0; axis < 3; ++axis)
          for (std::size_t side = 0; side < 2; ++side) lap += neighbour(n, sides, phi, {i, j, k}, axis, side, given[axis][side]) - phi[q];
        residual = std::max(residual, std::abs(lap / (h * h) - rhs[q]));
        largest = std::max({largest, std::abs(rhs[q]), std::abs(phi[q]) / (h * h)});
        sum += phi[q];
      }
      worst = std::max(worst, residual / largest);
      EXPECT_LT(residual / largest, 1e-12) << "mix " << mix << ", cells " << n[0] << " " << n[1] << " " << n[2];
      if (is_singular) {
        EXPECT_NEAR(sum / static_cast<double>(phi.size()), 0.0, 1e-12 * largest * h * h) << "mix " << mix;
      }
    }
  std::printf("pressure solver, 125 mixes of sides on four grids: largest relative residual %.1e\n", worst);
}

TEST(BoundaryMixes, a_step_leaves_no_divergence_for_all_1000_mixes) {
  const auto W = BoundaryKind::wall, O = BoundaryKind::open, S = BoundaryKind::symmetry, P = BoundaryKind::periodic;
  const std::array<std::array<BoundaryKind, 2>, 10> pairs{{{W, W}, {W, O}, {W, S}, {O, W}, {O, O}, {O, S}, {S, W}, {S, O}, {S, S}, {P, P}}};
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1e4, 1e4);
  double worst = 0;
  for (std::size_t mix = 0; mix < 1000; ++mix) {
    mv::FluidGrid grid;
    grid.n = {5, 4, 6};
    grid.h = 1e-3;
    mv::FluidBoundary boundary;
    boundary.side = {pairs[mix % 10], pairs[mix / 10 % 10], pairs[mix / 100]};
    // Walls that slide along themselves.
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t side = 0; side < 2; ++side) boundary.wall_velocity[axis][side][static_cast<Eigen::Index>((axis + 1) % 3)] = 0.1;
    mv::NavierStokes solver(grid, boundary, mv::make_tube_wall(grid, {}), 1060, 4e-3);
    auto state = solver.make_state();
    mv::FaceField force(grid);
    for (auto& c : force.c)
      for (double& f : c) f = uniform(random);
    for (int n = 0; n < 3; ++n) solver.advance(state, force, 1e-5, {{{10.0, 0}, {0, 20.0}, {30.0 * n, 0}}});
    worst = std::max(worst, solver.relative_divergence(state));
    EXPECT_LT(solver.relative_divergence(state), 1e-11) << "mix " << mix;
    EXPECT_GT(solver.peak_velocity(state), 1e-5) << "mix " << mix;
  }
  std::printf("a step of the flow, 1000 mixes of sides: largest relative divergence %.1e\n", worst);
}

TEST(BoundaryMixes, pressure_work_is_what_the_blood_gains_however_the_pressure_jumps) {
  mv::FluidGrid grid;
  grid.n = {3, 3, 12};
  grid.h = 1e-3;
  mv::FluidBoundary boundary;
  boundary.side[0] = boundary.side[1] = {BoundaryKind::symmetry, BoundaryKind::symmetry};
  mv::NavierStokes solver(grid, boundary, mv::make_tube_wall(grid, {}), 1060, 0.0);
  auto state = solver.make_state();
  const mv::FaceField no_force(grid);
  double work = 0, turnover = 0;
  for (int n = 0; n < 40; ++n) {
    const double p = n % 7 == 0 ? 1000.0 : -300.0 * (n % 3);
    const auto report = solver.advance(state, no_force, 1e-4, {{{0, 0}, {0, 0}, {p, 0.5 * p - 20}}});
    work += report.pressure_work;
    turnover += std::abs(report.pressure_work);
  }
  EXPECT_GT(turnover, 0.0);
  EXPECT_NEAR((solver.kinetic_energy(state) - work) / turnover, 0.0, 1e-10);
}

}  // namespace
