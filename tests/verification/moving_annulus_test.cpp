// SPDX-License-Identifier: BSD-3-Clause
// A disc of points in a tube, carried along as a moving annulus is (Coupling::carry_held), with a skirt that holds the blood along the tube alone where the disc does not
// reach the wall. A disc that moves displaces A V of blood, whatever presses on it; one at rest lets nothing pass, whether it fills the tube or its skirt does.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <vector>

#include "solver/coupling/coupling.h"
#include "support/tube_flow.h"

namespace mv::test {
namespace {

constexpr double density = 1060, viscosity = 4e-3, tube_radius = 16e-3, h = 2e-3, dt = 50e-6;  // SI
constexpr int cells_along = 24;

struct Disc {
  double radius = tube_radius;   // m, at the start
  double contraction = 0;        // m, by which its radius shrinks within `duration`
  double lift = 0;               // m, along the tube within `duration`
  double duration = 20e-3;       // s
  bool has_skirt = true;
  double pressure = 0;           // Pa
};

struct Seen {
  double passed = 0;     // m3 through the tube during the motion
  double rate = 0;       // m3/s at its end
  double work = 0;       // J, of what carries the disc (HoldWork::by_motion)
  double energy_error = 0;  // of the budget of hold and pressure, over what both moved to and fro
};

double progress(double t, double duration) {
  const double s = std::min(t / duration, 1.0);
  return s * s * (3 - 2 * s);
}

Seen move(const Disc& disc) {
  const FluidGrid grid = tube_grid(tube_radius, static_cast<int>(std::lround(2 * tube_radius / h)), 0.2, cells_along);
  NavierStokes fluid(grid, FluidBoundary(), make_tube_wall(grid, ellipse_section(tube_radius, tube_radius)), density, viscosity);
  Coupling coupling(Transfer(grid, fluid.wall(), Kernel::ib4), density);
  struct Point {
    double radius, angle;
    bool is_skirt;
  };
  std::vector<Point> points;
  const double step = 0.5 * h, middle = 0.5 * cells_along * h + 0.3 * h;
  for (const bool is_skirt : {false, true})
    for (int ring = 0; ring * step < tube_radius + disc.contraction + step; ++ring) {
      const double radius = ring * step;
      if (is_skirt ? !disc.has_skirt || radius <= disc.radius : radius > disc.radius) continue;
      const int count = std::max(1, static_cast<int>(std::ceil(2 * M_PI * radius / step)));
      for (int q = 0; q < count; ++q) points.push_back({radius, 2 * M_PI * (q + 0.5 * (ring % 2)) / count, is_skirt});
    }
  int axial = 0;
  for (const Point& p : points) axial += p.is_skirt;
  std::vector<double> x(3 * points.size()), next(x.size()), velocity(x.size());
  std::vector<char> is_active(points.size(), 1);
  const auto place = [&](double t, std::vector<double>& at) {
    const double s = progress(t, disc.duration);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Point& p = points[i];
      // The disc shrinks as a whole, its skirt follows the border.
      const double r = p.is_skirt ? p.radius - s * disc.contraction : p.radius * (1 - s * disc.contraction / disc.radius);
      at[3 * i] = r * std::cos(p.angle), at[3 * i + 1] = r * std::sin(p.angle), at[3 * i + 2] = middle + s * disc.lift;
      is_active[i] = r < tube_radius + step;
    }
  };
  place(0, x);
  std::vector<double> holding(3 * static_cast<std::size_t>(coupling.set_held(x, axial)), 0.0);
  coupling.set_hold_share(0.6);
  FlowState state = fluid.make_state();
  start_from(fluid, state, disc.pressure, [](double, double) { return 0.0; });
  FaceField force(grid);
  Seen seen;
  double hold_work = 0, pressure_work = 0, losses = 0, turnover = 0;
  const int steps = static_cast<int>(std::lround(1.5 * disc.duration / dt));
  for (int n = 0; n < steps; ++n) {
    place((n + 1) * dt, next);
    place(n * dt, x);
    for (std::size_t a = 0; a < x.size(); ++a) velocity[a] = (next[a] - x[a]) / dt;
    coupling.carry_held(x, velocity, is_active);
    force.set_zero();
    const auto work = coupling.hold(holding, state.velocity, dt, force);
    const double held = work.on_blood;
    hold_work += held;
    seen.work += work.by_motion;
    const FlowStepReport report = fluid.advance(state, force, dt, {{{0, 0}, {0, 0}, {disc.pressure, 0}}});
    pressure_work += report.pressure_work + report.boundary_kinetic;
    turnover += std::abs(held) + std::abs(report.pressure_work);
    losses += report.viscous_loss + report.advection_loss;
    seen.passed += dt * open_flow(fluid, state, cells_along / 4);
  }
  seen.rate = open_flow(fluid, state, cells_along / 4);
  const double gained = fluid.kinetic_energy(state);
  seen.energy_error = std::abs(hold_work + pressure_work - losses - gained) / turnover;
  return seen;
}

double tube_area() {
  const FluidGrid grid = tube_grid(tube_radius, static_cast<int>(std::lround(2 * tube_radius / h)), 0.2, cells_along);
  NavierStokes fluid(grid, FluidBoundary(), make_tube_wall(grid, ellipse_section(tube_radius, tube_radius)), density, viscosity);
  double count = 0;
  for_open_faces(fluid, cells_along / 4, [&](double, double, std::size_t) { ++count; });
  return count * h * h;
}

TEST(MovingAnnulus, a_disc_pushes_the_blood_that_it_sweeps) {
  for (const double pressure : {0.0, 16e3})
    for (const double lift : {-4e-3, 4e-3}) {
      const Seen seen = move({.lift = lift, .pressure = pressure});
      const double swept = tube_area() * lift;
      std::printf("full disc, %5.0f Pa, lift %+.0f mm: passed %+.4f ml, swept %+.4f ml, rate at the end %+.3f ml/s, work %+.2f mJ of %+.2f mJ, energy budget open by %.1e\n", pressure, 1e3 * lift, 1e6 * seen.passed, 1e6 * swept,
                  1e6 * seen.rate, 1e3 * seen.work, -1e3 * pressure * swept, seen.energy_error);
      EXPECT_NEAR(seen.passed, swept, 0.02 * std::abs(swept));
      EXPECT_LT(seen.energy_error, 0.02);
      // The disc is moved against the pressure, or braked; starting and stopping the blood gives back what it takes, but for the losses.
      EXPECT_NEAR(seen.work, -pressure * swept, 0.05 * 16e3 * std::abs(swept));
    }
}

// A gap of two and a half cells around the disc lets blood pass under 120 mmHg (one cell the kernels close by themselves); its skirt closes it, also while the disc moves.
TEST(MovingAnnulus, a_contracted_disc_is_closed_by_its_skirt) {
  const double area = tube_area();
  const Seen open = move({.contraction = 5e-3, .has_skirt = false, .pressure = 16e3});
  const Seen closed = move({.contraction = 5e-3, .pressure = 16e3});
  const Seen lifted = move({.contraction = 5e-3, .lift = 4e-3, .pressure = 16e3});
  const Seen narrow = move({.radius = tube_radius - 6e-3, .pressure = 16e3});
  std::printf("without skirt %.2f ml passed, at last %.0f ml/s; with it %.3f ml, %.2f ml/s; lifted by 4 mm as well %.3f ml for %.3f ml swept, %.2f ml/s; 6 mm from the wall from the start %.3f ml, %.2f ml/s\n",
              1e6 * open.passed, 1e6 * open.rate, 1e6 * closed.passed, 1e6 * closed.rate, 1e6 * lifted.passed, 1e6 * area * 4e-3, 1e6 * lifted.rate, 1e6 * narrow.passed, 1e6 * narrow.rate);
  EXPECT_GT(open.rate, 100e-6);
  for (const Seen& seen : {closed, lifted, narrow}) EXPECT_LT(std::abs(seen.rate), 0.02 * open.rate);
  EXPECT_LT(std::abs(closed.passed), 0.02 * open.passed);
  EXPECT_LT(std::abs(lifted.passed - area * 4e-3), 0.03 * open.passed);
}

}  // namespace
}  // namespace mv::test
