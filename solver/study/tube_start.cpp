// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <cmath>
#include <ctime>
#include <numbers>

#include "geometry/core/log.h"
#include "geometry/core/version.h"
#include "solver/fluid/navier_stokes.h"
#include "solver/study/known_answers.h"

namespace mv {
namespace {

constexpr double radius = 10e-3, density = 1060, viscosity = 0.02;  // m, kg/m3, Pa s: ten times blood's, so that the profile forms within half a second
constexpr double gradient = 40;                                     // Pa/m
constexpr double end = 0.5;                                         // s: a tenth of R^2/nu, the flow is at 40 % of its final value
constexpr int cells_along = 6;

/// Zero number n (1, 2, ...) of the Bessel function J0: McMahon's start, Newton steps.
double bessel_zero(int n) {
  const double beta = (n - 0.25) * std::numbers::pi;
  double z = beta + 1 / (8 * beta);
  for (int i = 0; i < 4; ++i) z += std::cyl_bessel_j(0, z) / std::cyl_bessel_j(1, z);
  return z;
}

StudyRow run_tube(int cells, double step) {
  const std::clock_t start = std::clock();
  FluidGrid grid;
  grid.h = 2 * radius / cells;
  // The axis lies off the grid's planes, as it does in a case.
  const double offset = 0.3 * grid.h;
  const int across = cells + 6;
  grid.n = {across, across, cells_along};
  grid.lower = {-0.5 * across * grid.h + offset, -0.5 * across * grid.h - 0.5 * offset, 0};
  std::vector<Eigen::Vector2d> circle;
  for (int i = 0; i < 720; ++i) circle.emplace_back(radius * std::cos(i * std::numbers::pi / 360), radius * std::sin(i * std::numbers::pi / 360));
  NavierStokes fluid(grid, FluidBoundary(), make_tube_wall(grid, circle), density, viscosity);
  FlowState state = fluid.make_state();
  const FaceField none(grid);
  const double pressure = gradient * cells_along * grid.h;
  state.boundary_pressure[2][0] = pressure;
  for (int k = 0; k < grid.n[2]; ++k)
    for (int j = 0; j < grid.n[1]; ++j)
      for (int i = 0; i < grid.n[0]; ++i) state.pressure[static_cast<std::size_t>(grid.index(i, j, k))] = pressure * (1 - (k + 0.5) / grid.n[2]);
  const double stable = std::min(step, fluid.stable_step(state));
  const long steps = std::lround(std::ceil(end / stable));
  for (long s = 0; s < steps; ++s) fluid.advance(state, none, end / static_cast<double>(steps), {{{0, 0}, {0, 0}, {pressure, 0}}});

  StudyRow row;
  row.mesh = {1e3 * grid.h, 0, 1};
  row.has_values = true;
  row.values = {1e6 * fluid.flow_through_z(state, grid.n[2] / 2), fluid.peak_velocity(state)};
  row.seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  row.revision = git_revision();
  row.what = fmt::format("{} cells across, steps of {:.3g} ms", cells, 1e3 * end / static_cast<double>(steps));
  return row;
}

}  // namespace

TubeStart tube_start(double g, double r, double rho, double mu, double time) {
  // u(0) = G R^2/(4 mu) (1 - 8 sum exp(-z^2 tau) / (z^3 J1(z))),  Q = pi G R^4/(8 mu) (1 - 32 sum exp(-z^2 tau) / z^4),  tau = nu t / R^2.
  const double tau = mu / rho * time / (r * r);
  double velocity = 1, flow = 1;
  for (int n = 1; n <= 200; ++n) {
    const double z = bessel_zero(n), decay = std::exp(-z * z * tau);
    velocity -= 8 * decay / (z * z * z * std::cyl_bessel_j(1, z));
    flow -= 32 * decay / (z * z * z * z);
  }
  return {std::numbers::pi * g * std::pow(r, 4) / (8 * mu) * flow, g * r * r / (4 * mu) * velocity};
}

StudyTable tube_start_table(bool is_small) {
  StudyTable table;
  table.id = "tube_start";
  table.title = "Flow starting in a tube";
  table.explanation =
      "Blood at rest in a circular tube of 20 mm, set in motion by a sudden pressure difference. Flow and velocity on the axis after 0.5 s against the exact series (Szymanski 1932). "
      "The wall cuts the cells anywhere; the two ladders are the cells across the tube and the step.";
  const TubeStart exact = tube_start(gradient, radius, density, viscosity, end);
  table.quantities = {{"flow", "ml/s", "Flow", "through the middle of the tube", 1e6 * exact.flow, 0, std::nan(""), false, 1},
                      {"peak_velocity", "m/s", "Peak velocity", "on the axis", exact.axial_velocity, 0, std::nan(""), false, 1}};
  const auto add = [&](int cells, double step, const char* axis, const std::string& name) {
    StudyRow row = run_tube(cells, step);
    row.axis = axis;
    row.run = name;
    spdlog::info("tube start, {}: {:.2g} s", row.what, row.seconds);
    table.rows.push_back(std::move(row));
  };
  if (is_small) {
    for (int cells : {6, 10}) add(cells, 1, "fluid spacing", fmt::format("cells-{}", cells));
  } else {
    for (int cells : {6, 8, 12, 16, 24, 32}) add(cells, 1, "fluid spacing", fmt::format("cells-{}", cells));
    for (double step : {2e-3, 1e-3, 5e-4, 5e-5}) add(12, step, "step", fmt::format("cells-12-step-{:g}ms", 1e3 * step));
  }
  put_errors(table);
  return table;
}

}  // namespace mv
