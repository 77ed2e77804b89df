// SPDX-License-Identifier: BSD-3-Clause
// Rigid bodies made of grid faces: tightness of the staircase, what it stops, what it carries.
#include "solver/coupling/rest_faces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <set>
#include <vector>

namespace {

using Eigen::Vector3d;
using mv::FluidGrid;
using mv::RestTriangle;

FluidGrid box(int n, double h) {
  FluidGrid grid;
  grid.n = {n, n, n};
  grid.h = h;
  grid.lower = {-0.5 * n * h, -0.5 * n * h, -0.5 * n * h};
  return grid;
}

/// Sphere of radius r: every triangle of an octahedron split `times` times.
std::vector<RestTriangle> sphere(double r, int times) {
  std::vector<RestTriangle> triangles;
  for (int s = 0; s < 8; ++s)
    triangles.push_back({Vector3d(s & 1 ? -r : r, 0, 0), Vector3d(0, s & 2 ? -r : r, 0), Vector3d(0, 0, s & 4 ? -r : r)});
  for (int t = 0; t < times; ++t) {
    std::vector<RestTriangle> finer;
    for (const RestTriangle& q : triangles) {
      const auto middle = [&](std::size_t a, std::size_t b) { return Vector3d(r * (q[a] + q[b]).normalized()); };
      const Vector3d ab = middle(0, 1), bc = middle(1, 2), ca = middle(2, 0);
      for (const RestTriangle& f : {RestTriangle{q[0], ab, ca}, RestTriangle{ab, q[1], bc}, RestTriangle{ca, bc, q[2]}, RestTriangle{ab, bc, ca}}) finer.push_back(f);
    }
    triangles = finer;
  }
  return triangles;
}

TEST(RestFaces, a_closed_surface_lets_no_path_of_cells_out) {
  const FluidGrid grid = box(16, 1e-3);
  const mv::RestFaces faces = mv::faces_crossed(grid, sphere(5.3e-3, 4));
  std::array<std::set<std::ptrdiff_t>, 3> closed;
  for (std::size_t c = 0; c < 3; ++c) closed[c] = {faces[c].begin(), faces[c].end()};
  std::set<std::array<int, 3>> reached{{8, 8, 8}};
  std::vector<std::array<int, 3>> front{{8, 8, 8}};
  while (!front.empty()) {
    const std::array<int, 3> cell = front.back();
    front.pop_back();
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (int side : {0, 1}) {
        std::array<int, 3> face = cell, next = cell;
        face[axis] += side;
        next[axis] += 2 * side - 1;
        if (next[axis] < 0 || next[axis] >= 16 || closed[axis].count(grid.index(face[0], face[1], face[2]))) continue;
        if (reached.insert(next).second) front.push_back(next);
      }
  }
  const double volume = 4.0 / 3.0 * M_PI * std::pow(5.3, 3);
  std::printf("cells inside %zu, volume of the sphere %.0f cells\n", reached.size(), volume);
  EXPECT_NEAR(static_cast<double>(reached.size()), volume, 0.05 * volume);
}

TEST(RestFaces, a_plane_closes_one_layer_and_its_borders_leave_no_hole) {
  const FluidGrid grid = box(8, 1e-3);
  const auto at = [](double x, double y) { return Vector3d(1e-3 * x, 1e-3 * y, 0.2e-3); };
  // Borders run through cell centres (half numbers).
  const mv::RestFaces faces = mv::faces_crossed(grid, {{at(-9, -9), at(0.5, -9), at(0.5, 9)}, {at(-9, -9), at(0.5, 9), at(-9, 9)}, {at(0.5, -9), at(9, -9), at(9, 9)}, {at(0.5, -9), at(9, 9), at(0.5, 9)}});
  EXPECT_TRUE(faces[0].empty());
  EXPECT_TRUE(faces[1].empty());
  ASSERT_EQ(faces[2].size(), 64u);
  for (int j = 0; j < 8; ++j)
    for (int i = 0; i < 8; ++i) EXPECT_EQ(faces[2][static_cast<std::size_t>(i + 8 * j)], grid.index(i, j, 4));
}

TEST(RestFaces, a_closed_plane_stops_the_blood_carries_the_pressure_and_does_no_work_to_speak_of) {
  const FluidGrid grid = box(12, 1e-3);
  constexpr double pressure = 100, density = 1000, dt = 2e-5, side = 12e-3;
  mv::FluidBoundary boundary;
  for (std::size_t axis : {0u, 1u}) boundary.side[axis] = {mv::BoundaryKind::symmetry, mv::BoundaryKind::symmetry};
  mv::NavierStokes fluid(grid, boundary, mv::make_tube_wall(grid, {}), density, 1e-3);
  const auto at = [](double x, double y) { return Vector3d(x, y, 0.2e-3); };
  fluid.set_rest_faces(mv::faces_crossed(grid, {{at(-1, -1), at(1, -1), at(1, 1)}, {at(-1, -1), at(1, 1), at(-1, 1)}}));
  mv::FlowState state = fluid.make_state();
  const mv::FaceField none(grid);
  mv::FlowStepReport report;
  double work = 0, supplied = 0;
  constexpr int steps = 400;
  for (int n = 0; n < steps; ++n) {
    report = fluid.advance(state, none, dt, {{{0, 0}, {0, 0}, {pressure, 0}}});
    work += report.rest_work;
    supplied += report.pressure_work;
  }
  const double free_flow = pressure / density / side * dt * steps * side * side;
  std::printf("flow %.3g of a free column's, force %.4f of the pressure's, work %.3g J of %.3g J\n", fluid.flow_through_z(state, 3) / free_flow,
              -report.rest_force[2] / (pressure * side * side), work, supplied);
  EXPECT_LT(std::abs(fluid.flow_through_z(state, 3)), 1e-6 * free_flow);
  EXPECT_NEAR(-report.rest_force[2], pressure * side * side, 1e-3 * pressure * side * side);
  // What flowed while the pressure built up was taken out by what holds.
  EXPECT_NEAR(work, -supplied, 0.02 * supplied);
}

}  // namespace
