// SPDX-License-Identifier: BSD-3-Clause
// Steady flow past a rigid cylinder in a channel at Re 20: test case 2D-1 of
//   Schaefer & Turek 1996, Benchmark computations of laminar flow around a cylinder (intervals that its authors agreed on).
// The cylinder is faces of the grid that carry no flow, with the true distance to its surface in the viscous links that it cuts (verification/slab_body.h). No
// kernel is involved. Channels of 41, 82 and 123 cells have faces on both of the cylinder's axes and see a symmetric body; in others its staircase is not symmetric, which the
// lift, a fivehundredth of the drag, feels most.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <vector>

#include "verification/fsi/channel.h"

namespace mv::test {
namespace {

// Reference intervals.
constexpr Range cd_range{5.57, 5.59}, cl_range{0.0104, 0.0110}, dp_range{0.1172, 0.1176}, recirculation_range{0.0842, 0.0852};
double middle(Range r) { return 0.5 * (r.low + r.high); }

constexpr double width = 0.41, length = 2.2, radius = 0.05, centre_x = 0.2, centre_z = 0.2;  // m
constexpr double density = 1.0, viscosity = 1e-3, mean_velocity = 0.2;                       // kg/m3, Pa s, m/s

struct CylinderResult {
  double cd = 0, cl = 0, dp = 0, recirculation = 0;
  double drift = 0;  // relative change of cd over the last twentieth of the run
  double seconds = 0;
};

/// Pressure (Pa) at the surface along the flow axis, up- or downstream (direction -1 or 1): a parabola through three points beside it.
double surface_pressure(const SlabFlow& flow, int direction) {
  const double h = flow.fluid().grid().h;
  const auto at = [&](double cells) { return pressure_at(flow, centre_x, centre_z + direction * (radius + cells * h)); };
  constexpr double first = 2.5;  // cells
  const double a = at(first), b = at(first + 1), c = at(first + 2);
  const double slope = -1.5 * a + 2 * b - 0.5 * c, curvature = a - 2 * b + c;
  return a - first * slope + 0.5 * first * first * curvature;
}

/// From the rear stagnation point to where the flow on the axis turns downstream again, m.
double recirculation_of(const SlabFlow& flow) {
  const FluidGrid& grid = flow.fluid().grid();
  const double s = centre_x / grid.h - 0.5;
  const int i = static_cast<int>(s);
  const auto w = [&](int k) {
    const std::vector<double>& c = flow.flow().velocity.c[2];
    const double low = c[static_cast<std::size_t>(grid.index(i, 0, k))], high = c[static_cast<std::size_t>(grid.index(i + 1, 0, k))];
    return low + (s - i) * (high - low);
  };
  for (int k = static_cast<int>((centre_z + radius) / grid.h) + 3; k < grid.n[2]; ++k)
    if (w(k) >= 0) return (k - w(k) / (w(k) - w(k - 1))) * grid.h - centre_z - radius;
  return -1;
}

CylinderResult run_cylinder(int cells, double end) {
  const OneThread one_thread;
  SlabSetup setup = channel_setup(width, length, cells, density, viscosity);
  const double h = setup.grid.h;
  SlabTissue none;
  none.depth = h;
  SlabFlow flow(setup, none, {});
  flow.set_body(disc_body(setup.grid, centre_x, centre_z, radius));
  flow.set_inflow(2, 0, parabola(setup.grid, 6 * mean_velocity / (width * width)));
  const double dt = std::min(0.05 * h * h * density / viscosity, 0.25 * h / (2 * mean_velocity));
  const double scale = 2 / (density * mean_velocity * mean_velocity * 2 * radius * h);
  CylinderResult result;
  const auto start = std::chrono::steady_clock::now();
  double cd_before = 0;
  const int steps = static_cast<int>(std::ceil(end / dt));
  for (int step = 0; step < steps; ++step) {
    flow.advance(dt, 0);
    if (step == steps - steps / 20) cd_before = -scale * flow.force_on_blood()[2];
  }
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  result.cd = -scale * flow.force_on_blood()[2];
  result.cl = -scale * flow.force_on_blood()[0];
  result.dp = surface_pressure(flow, -1) - surface_pressure(flow, 1);
  result.recirculation = recirculation_of(flow);
  result.drift = std::abs(result.cd - cd_before) / result.cd;
  return result;
}

void print(int cells, const CylinderResult& r) {
  std::printf("%d cells across the channel, %.1f across the cylinder (%.0f s), drift of cd %.1e\n", cells, cells * 2 * radius / width, r.seconds,
              r.drift);
  print_comparison("cd", r.cd, middle(cd_range));
  print_comparison("cl", r.cl, middle(cl_range));
  print_comparison("pressure difference Pa", r.dp, middle(dp_range));
  print_comparison("recirculation length m", r.recirculation, middle(recirculation_range));
}

// On a grid that lies symmetric to the cylinder and on one that does not. The lift's bound is a share of the drag; it still swings after 5 s.
TEST(Cylinder2d1, coarse_drag_is_within_one_per_cent) {
  for (const int cells : {41, 48}) {
    const CylinderResult r = run_cylinder(cells, 7.0);
    print(cells, r);
    EXPECT_LT(r.drift, 1e-5);
    EXPECT_NEAR(r.cd, middle(cd_range), 0.01 * middle(cd_range));
    EXPECT_NEAR(r.cl, middle(cl_range), 0.001 * middle(cd_range));
    EXPECT_NEAR(r.dp, middle(dp_range), 0.02 * middle(dp_range));
    EXPECT_NEAR(r.recirculation, middle(recirculation_range), 0.015 * middle(recirculation_range));
  }
}

TEST(Cylinder2d1, DISABLED_refinement) {
  for (const int cells : {48, 96, 41, 82, 123}) {
    const CylinderResult r = run_cylinder(cells, 8.0);
    print(cells, r);
    EXPECT_NEAR(r.cd, middle(cd_range), (cells < 80 ? 0.01 : 0.003) * middle(cd_range));
    EXPECT_NEAR(r.cl, middle(cl_range), 0.001 * middle(cd_range));
    EXPECT_NEAR(r.dp, middle(dp_range), 0.035 * middle(dp_range));
    EXPECT_NEAR(r.recirculation, middle(recirculation_range), 0.015 * middle(recirculation_range));
  }
}

// r^2 - R^2 vanishes on the circle and has the Laplacian 4 everywhere, which Shortley and Weller's weights give exactly.
TEST(SlabBody, cut_links_are_exact_for_a_parabola_that_vanishes_on_the_circle) {
  const FluidGrid grid = slab_grid({0, 1}, {0, 1}, 1.0 / 32, 1);
  constexpr double x = 0.513, z = 0.497, r = 0.25;
  const SlabBody body = disc_body(grid, x, z, r);
  constexpr std::array<std::array<double, 2>, 3> offset{{{0, 0.5}, {0.5, 0.5}, {0.5, 0}}};
  FaceField q(grid);
  for (std::size_t c = 0; c < 3; ++c)
    for (int k = 0; k < grid.n[2]; ++k)
      for (int i = 0; i < grid.n[0]; ++i)
        q.c[c][static_cast<std::size_t>(grid.index(i, 0, k))] =
            std::max(0.0, std::pow(grid.h * (i + offset[c][0]) - x, 2) + std::pow(grid.h * (k + offset[c][1]) - z, 2) - r * r);
  const std::array<std::ptrdiff_t, 4> step{-1, 1, -grid.stride_z(), grid.stride_z()};
  int exact = 0, scaled = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(static_cast<double>(body.inside[c].size()) * grid.h * grid.h, M_PI * r * r, 0.02 * M_PI * r * r);
    for (const SlabBody::CutFace& cut : body.cut[c]) {
      const double* at = q.c[c].data() + cut.face;
      double laplacian = 0, sum = 0;
      for (std::size_t d = 0; d < 4; ++d) {
        sum += 1 + cut.excess[d];
        laplacian += (1 + cut.excess[d]) * (at[step[d]] - at[0]) / (grid.h * grid.h);
      }
      EXPECT_LT(sum, 12 + 1e-9);
      if (sum > 12 - 1e-9) {
        ++scaled;
        continue;
      }
      ++exact;
      EXPECT_NEAR(laplacian, 4.0, 1e-10);
    }
  }
  EXPECT_GT(exact, 100);
  EXPECT_GT(scaled, 10);
}

// Periodic along the stream, no shear at the sides: only the disc takes momentum, and advance_around() says how much.
TEST(SlabBody, force_is_what_the_blood_around_it_loses) {
  const OneThread one_thread;
  const FluidGrid grid = slab_grid({0, 1}, {0, 1}, 1.0 / 32, 1);
  const SlabBody body = disc_body(grid, 0.513, 0.497, 0.2);
  FluidBoundary boundary;
  boundary.side[0] = {BoundaryKind::symmetry, BoundaryKind::symmetry};
  boundary.side[1] = boundary.side[2] = {BoundaryKind::periodic, BoundaryKind::periodic};
  NavierStokes fluid(grid, boundary, make_tube_wall(grid, {}), 1.0, 0.01);
  fluid.set_rest_faces(body.inside);
  FlowState state = fluid.make_state();
  std::fill(state.velocity.c[2].begin(), state.velocity.c[2].end(), 1.0);
  fluid.project(state.velocity);
  const auto momentum_around = [&] {
    double sum = 0;
    for (int k = 0; k < grid.n[2]; ++k) sum += grid.h * fluid.flow_through_z(state, k);
    for (const std::ptrdiff_t face : body.inside[2]) sum -= std::pow(grid.h, 3) * state.velocity.c[2][static_cast<std::size_t>(face)];
    return sum;
  };
  const double first = momentum_around();
  double impulse = 0;
  FaceField force(grid);
  for (int s = 0; s < 50; ++s) {
    force.set_zero();
    impulse += 2e-3 * advance_around(body, fluid, state, force, 2e-3, {})[2];
  }
  EXPECT_LT(impulse, -0.01 * first);
  EXPECT_NEAR(momentum_around() - first, impulse, 1e-12 * first);
}

}  // namespace
}  // namespace mv::test
