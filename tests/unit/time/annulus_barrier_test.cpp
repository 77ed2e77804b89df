// SPDX-License-Identifier: BSD-3-Clause
// What the annulus closes: nothing passes between the leaflets' hinge and the wall, nothing else is closed.
#include "solver/time/annulus_barrier.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

namespace {

using mv::Vec2;
using mv::Vec3;

constexpr double inner = 14.75, outer = 15.75, wall = 16;  // mm
constexpr int around = 60;

/// A ring of tissue that hangs on an annulus of height `saddle` cos(2 angle), and a tube around it.
mv::Scene ring_scene(double h, double saddle) {
  mv::Scene scene;
  const auto point = [&](int q, double r, double depth) {
    const double angle = 2 * M_PI * q / around;
    return Vec3(r * std::cos(angle), r * std::sin(angle), saddle * std::cos(2 * angle) - depth);
  };
  for (int q = 0; q < around; ++q)
    for (double depth : {0.0, 1.0})
      for (double r : {inner, outer}) {
        scene.mesh.points.push_back(point(q, r, depth));
        scene.mesh.on_annulus.push_back(depth == 0);
      }
  constexpr std::array<std::array<int, 4>, 6> split{{{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}}};
  for (int q = 0; q < around; ++q)
    for (const auto& s : split) {
      std::array<int, 10> tet;
      tet.fill(-1);
      for (std::size_t c = 0; c < 4; ++c) {
        const int corner = s[c];  // bit 0: outer, bit 1: below, bit 2: next column
        tet[c] = 4 * ((q + (corner >> 2)) % around) + (corner & 3);
      }
      scene.mesh.tets.push_back(tet);
    }
  for (int q = 0; q < 360; ++q) scene.tube.cross_section.push_back(wall * Vec2(std::cos(M_PI * q / 180), std::sin(M_PI * q / 180)));
  for (int q = 0; q < around; ++q) scene.annulus.points.push_back(point(q, 0.5 * (inner + outer), 0));
  scene.tube.grid_spacing = h;
  return scene;
}

/// Columns of cells along the tube: how many that lie under the annulus or in the gap beside it are open, and how many further in are closed.
std::pair<int, int> open_and_closed(const mv::Scene& scene) {
  const double h = 1e-3 * scene.tube.grid_spacing;
  mv::FluidGrid grid;
  grid.h = h;
  const int n = 2 * static_cast<int>(std::ceil(18e-3 / h));
  grid.n = {n, n, n};
  grid.lower = Eigen::Vector3d::Constant(-0.5 * n * h);
  const mv::RestFaces faces = mv::faces_crossed(grid, mv::annulus_barrier(scene));
  int open = 0, closed_inside = 0;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const double r = 1e3 * (grid.lower.head<2>() + h * Vec2(i + 0.5, j + 0.5)).norm();
      bool is_closed = false;
      for (std::ptrdiff_t face : faces[2]) is_closed |= (face - grid.index(i, j, 0)) % grid.stride_z() == 0 && face >= grid.index(i, j, 0);
      if (r > inner + 0.03 && r < wall) open += !is_closed;
      if (r < inner - 0.06) closed_inside += is_closed;
    }
  return {open, closed_inside};
}

TEST(AnnulusBarrier, closes_the_hinge_and_the_gap_beside_it_and_nothing_else) {
  for (const double h : {2.0, 0.7})
    for (const double saddle : {0.0, 3.0}) {
      const auto [open, closed] = open_and_closed(ring_scene(h, saddle));
      std::printf("h %.1f mm, saddle %.0f mm: %d open columns beside the orifice, %d closed ones in it\n", h, saddle, open, closed);
      EXPECT_EQ(open, 0);
      EXPECT_EQ(closed, 0);
    }
}

TEST(AnnulusBarrier, falls_back_on_the_curve_when_no_face_is_held) {
  mv::Scene scene = ring_scene(1.0, 0.0);
  for (std::size_t i = 0; i < scene.mesh.on_annulus.size(); ++i) scene.mesh.on_annulus[i] = i % 4 == 0;  // one node a column
  const std::vector<mv::RestTriangle> triangles = mv::annulus_barrier(scene);
  ASSERT_EQ(triangles.size(), 2u * around);
  EXPECT_NEAR(triangles[0][0].norm(), 0.5e-3 * (inner + outer), 1e-9);
  EXPECT_GT(triangles[0][2].norm(), 1e-3 * wall);
}

}  // namespace
