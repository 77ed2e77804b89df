// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "solver/fluid/navier_stokes.h"

// Orders in space and in time apart, of velocity and pressure, for the Taylor-Green vortex carried by a uniform stream through a periodic box.
namespace {

constexpr double viscosity = 0.01, k = 2 * M_PI, stream = 0.5, end_time = 0.25;  // density and box are one

double decay(double t) { return std::exp(-2 * viscosity * k * k * t); }
double exact_u(double x, double y, double t) { return stream + decay(t) * std::sin(k * (x - stream * t)) * std::cos(k * (y - stream * t)); }
double exact_v(double x, double y, double t) { return stream - decay(t) * std::cos(k * (x - stream * t)) * std::sin(k * (y - stream * t)); }
double exact_p(double x, double y, double t) { return 0.25 * decay(t) * decay(t) * (std::cos(2 * k * (x - stream * t)) + std::cos(2 * k * (y - stream * t))); }

struct Fields {
  std::vector<double> u, v, p;  // p at the end, extrapolated from the middles of the last two steps
};

Fields run(int n, int steps) {
  mv::FluidGrid grid;
  grid.n = {n, n, 1};
  grid.h = 1.0 / n;
  mv::FluidBoundary boundary;
  for (auto& axis : boundary.side) axis = {mv::BoundaryKind::periodic, mv::BoundaryKind::periodic};
  mv::NavierStokes solver(grid, boundary, mv::make_tube_wall(grid, {}), 1.0, viscosity);
  auto state = solver.make_state();
  const auto at = [&](int i, int j) { return static_cast<std::size_t>(grid.index(i, j, 0)); };
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      state.velocity.c[0][at(i, j)] = exact_u(i * grid.h, (j + 0.5) * grid.h, 0);
      state.velocity.c[1][at(i, j)] = exact_v((i + 0.5) * grid.h, j * grid.h, 0);
    }
  const mv::FaceField no_force(grid);
  std::vector<double> pressure_before;
  for (int s = 0; s < steps; ++s) {
    if (s + 1 == steps) pressure_before = state.pressure;
    solver.advance(state, no_force, end_time / steps, {});
  }
  Fields fields;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      fields.u.push_back(state.velocity.c[0][at(i, j)]);
      fields.v.push_back(state.velocity.c[1][at(i, j)]);
      fields.p.push_back(1.5 * state.pressure[at(i, j)] - 0.5 * pressure_before[at(i, j)]);
    }
  return fields;
}

Fields exact(int n) {
  Fields fields;
  const double h = 1.0 / n;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      fields.u.push_back(exact_u(i * h, (j + 0.5) * h, end_time));
      fields.v.push_back(exact_v((i + 0.5) * h, j * h, end_time));
      fields.p.push_back(exact_p((i + 0.5) * h, (j + 0.5) * h, end_time));
    }
  return fields;
}

struct Errors {
  double velocity = 0, pressure = 0;  // root mean square
};

Errors difference(const Fields& a, const Fields& b) {
  Errors e;
  for (std::size_t q = 0; q < a.u.size(); ++q) {
    e.velocity += std::pow(a.u[q] - b.u[q], 2) + std::pow(a.v[q] - b.v[q], 2);
    e.pressure += std::pow(a.p[q] - b.p[q], 2);
  }
  const double count = static_cast<double>(a.u.size());
  return {std::sqrt(e.velocity / count), std::sqrt(e.pressure / count)};
}

void expect_second_order(const char* what, const std::array<Errors, 3>& e, double least_order) {
  const auto order = [](double coarse, double fine) { return std::log2(coarse / fine); };
  std::printf("Taylor-Green, order in %s: velocity %.2e %.2e %.2e, order %.2f %.2f; pressure %.2e %.2e %.2e, order %.2f %.2f\n", what, e[0].velocity, e[1].velocity, e[2].velocity,
              order(e[0].velocity, e[1].velocity), order(e[1].velocity, e[2].velocity), e[0].pressure, e[1].pressure, e[2].pressure, order(e[0].pressure, e[1].pressure),
              order(e[1].pressure, e[2].pressure));
  for (std::size_t level = 0; level < 2; ++level) {
    EXPECT_GT(order(e[level].velocity, e[level + 1].velocity), least_order);
    EXPECT_GT(order(e[level].pressure, e[level + 1].pressure), least_order);
  }
}

// One step for all grids, so small that its error (below) does not count.
TEST(TaylorGreenOrder, second_order_in_space) {
  std::array<Errors, 3> e;
  for (std::size_t level = 0; level < 3; ++level) {
    const int n = 16 << level;
    e[level] = difference(run(n, 2000), exact(n));
  }
  expect_second_order("space (16, 32, 64 cells)", e, 2.0);
}

// One grid for all steps; reference: the same grid with a step eight times smaller than the smallest.
TEST(TaylorGreenOrder, second_order_in_time) {
  const int n = 16;
  const Fields reference = run(n, 1280);
  std::array<Errors, 3> e;
  for (std::size_t level = 0; level < 3; ++level) e[level] = difference(run(n, 40 << level), reference);
  expect_second_order("time (40, 80, 160 steps)", e, 1.95);
}

}  // namespace
