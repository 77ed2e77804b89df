// SPDX-License-Identifier: GPL-3.0-or-later
// Our exact self-intersection (BSD, in mvsolve) against CGAL's (GPL, in mvprep) on the same surfaces.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <span>

#include "geometry/surface/self_intersection.h"
#include "solver/contact/intersection.h"
#include "unit/contact/shapes.h"

namespace mv::test {
namespace {

using Pairs = std::vector<std::pair<int, int>>;

void expect_agreement(const std::vector<Vec3>& points, const std::vector<std::array<int, 3>>& triangles, std::size_t at_least) {
  const Pairs ours = self_intersections(std::span<const Vec3>(points), std::span<const std::array<int, 3>>(triangles));
  const Pairs cgal = self_intersections(points, triangles);
  EXPECT_EQ(ours, cgal);
  EXPECT_GE(ours.size(), at_least);
}

TEST(SelfIntersectionAgainstCgal, crumpled_sheets) {
  std::mt19937 random(5);
  for (double noise : {0.0, 0.2e-3, 0.6e-3, 2e-3}) {
    std::normal_distribution<double> shake(0.0, noise > 0 ? noise : 1.0);
    TriangleMesh m;
    m.add_sheet(40, 40, 20e-3, 20e-3, [&](const Vec3& p) -> Vec3 {
      return noise > 0 ? Vec3(p + Vec3(shake(random), shake(random), shake(random))) : p;
    });
    std::vector<Vec3> points;
    for (int n = 0; n < m.node_count(); ++n) points.push_back(m.point(n));
    expect_agreement(points, m.triangles, noise > 0.5e-3 ? 100 : 0);
  }
}

TEST(SelfIntersectionAgainstCgal, points_on_a_coarse_lattice_full_of_coplanar_and_touching_triangles) {
  std::mt19937 random(17);
  std::size_t found = 0;
  for (int trial = 0; trial < 40; ++trial) {
    std::uniform_int_distribution<int> coordinate(-4, 4);
    std::vector<Vec3> points;
    std::vector<std::array<int, 3>> triangles;
    while (triangles.size() < 40) {
      std::array<Vec3, 3> t;
      for (auto& p : t) p = Vec3(coordinate(random), coordinate(random), trial % 2 ? 0 : coordinate(random));
      if ((t[1] - t[0]).cross(t[2] - t[0]).isZero(0)) continue;
      const int first = static_cast<int>(points.size());
      points.insert(points.end(), t.begin(), t.end());
      triangles.push_back({first, first + 1, first + 2});
    }
    expect_agreement(points, triangles, 1);
    found += triangles.size();
  }
  EXPECT_GT(found, 1000u);
}

TEST(SelfIntersectionAgainstCgal, thick_sheet_rolled_through_itself) {
  const TetMesh m = tet_box(30, 10, 2, 15e-3, 5e-3, 1e-3);
  const auto surface = extract_contact_surface(m.x, m.tets, 1, m.side, ContactFaces::both);
  for (double radius : {6e-3, 2.2e-3, 1.5e-3}) {
    const auto x = m.mapped([&](const Vec3& p) -> Vec3 {
      const double angle = p[0] / radius, r = radius - p[2];
      return {r * std::sin(angle), p[1], -r * std::cos(angle)};
    });
    std::vector<Vec3> points;
    for (int n : surface.nodes) points.push_back(Eigen::Map<const Vec3>(x.data() + 3 * n));
    expect_agreement(points, surface.triangles, radius < 2e-3 ? 100 : 0);
  }
}

}  // namespace
}  // namespace mv::test
