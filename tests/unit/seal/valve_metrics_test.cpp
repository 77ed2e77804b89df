// SPDX-License-Identifier: BSD-3-Clause
// Valve scalars against closed formulas.

#include "solver/seal/valve_metrics.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "geometry/core/errors.h"
#include "unit/seal/seal_shapes.h"

namespace mv {
namespace {

constexpr double pi = std::numbers::pi;

/// Part of a sphere around (0, 0, 0) from the pole down to colatitude `angle`, normals outwards.
struct Cap {
  std::vector<Vec3> points;
  Triangles triangles;
};
Cap sphere_cap(double radius, double angle, int rings, int sectors) {
  Cap c;
  c.points.emplace_back(0, 0, radius);
  for (int i = 1; i <= rings; ++i)
    for (int j = 0; j < sectors; ++j) {
      const double a = angle * i / rings, b = 2 * pi * j / sectors;
      c.points.emplace_back(radius * std::sin(a) * std::cos(b), radius * std::sin(a) * std::sin(b), radius * std::cos(a));
    }
  const auto at = [&](int i, int j) { return i == 0 ? 0 : 1 + (i - 1) * sectors + j % sectors; };
  for (int j = 0; j < sectors; ++j) c.triangles.push_back({0, at(1, j), at(1, j + 1)});
  for (int i = 1; i < rings; ++i)
    for (int j = 0; j < sectors; ++j) {
      c.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      c.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return c;
}

TEST(Bulging, spherical_cap_above_the_plane) {
  const double radius = 10, plane_height = 6, cap_height = radius - plane_height;
  const Cap c = sphere_cap(radius, 2.4, 200, 400);  // reaches well below the plane
  const Mat3 rotation = Eigen::AngleAxisd(1.1, Vec3(1, 1, 0.2).normalized()).toRotationMatrix();
  const Vec3 shift(3, -20, 7);
  std::vector<Vec3> points;
  for (const Vec3& p : c.points) points.push_back(rotation * p + shift);
  const Bulging b = measure_bulging(points, c.triangles, {rotation * Vec3(0, 0, plane_height) + shift, rotation * Vec3::UnitZ()});
  EXPECT_NEAR(b.area_mm2, 2 * pi * radius * cap_height, 2e-4 * 2 * pi * radius * cap_height);
  const double volume = pi * cap_height * cap_height * (3 * radius - cap_height) / 3;
  EXPECT_NEAR(b.volume_ml, volume * 1e-3, 2e-4 * volume * 1e-3);
  EXPECT_NEAR(b.area_ratio, cap_height / (radius * (1 - std::cos(2.4))), 2e-4);
  EXPECT_NEAR(b.height_mm, cap_height, 1e-9);
}

TEST(Bulging, nothing_above_the_plane) {
  const Cap c = sphere_cap(10, 1, 20, 40);
  const Bulging b = measure_bulging(c.points, c.triangles, {Vec3(0, 0, 11), Vec3::UnitZ()});
  EXPECT_EQ(b.area_mm2, 0);
  EXPECT_EQ(b.volume_ml, 0);
  EXPECT_EQ(b.height_mm, 0);
}

TEST(Bulging, one_triangle_is_cut_exactly) {
  const std::vector<Vec3> p{{0, 0, -1}, {2, 0, -1}, {0, 0, 1}};
  const Bulging b = measure_bulging(p, {{0, 1, 2}}, {Vec3::Zero(), Vec3::UnitZ()});
  EXPECT_NEAR(b.area_mm2, 0.5, 1e-14);  // half the base and half the height of an area of 2
  EXPECT_NEAR(b.area_ratio, 0.25, 1e-14);
}

TEST(Swept, equals_the_change_of_volume_of_a_closed_surface) {
  test::Solid solid = test::ring_plate(2, 8, 3, {1, 0});
  std::mt19937 random(7);
  std::uniform_real_distribution<double> step(-0.6, 0.6);
  std::vector<Vec3> later = solid.points;
  for (Vec3& p : later) p = 1.2 * p + Vec3(step(random) + 5, step(random), step(random) - 2);
  const double change = enclosed_volume(later, solid.triangles) - enclosed_volume(solid.points, solid.triangles);
  EXPECT_NEAR(swept_volume(solid.points, later, solid.triangles), change, 1e-9 * std::abs(change));
}

TEST(Swept, flat_piece_moved_along_its_normal) {
  const std::vector<Vec3> a{{0, 0, 0}, {2, 0, 0}, {2, 3, 0}, {0, 3, 0}};
  std::vector<Vec3> b = a;
  for (Vec3& p : b) p += Vec3(7, -4, 1.5);
  const Triangles t{{0, 1, 2}, {0, 2, 3}};
  EXPECT_NEAR(swept_volume(a, b, t), 9, 1e-12);
  EXPECT_NEAR(swept_volume(b, a, t), -9, 1e-12);
}

TEST(Swept, matches_many_small_steps) {
  const std::vector<Vec3> a{{0, 0, 0}, {2, 0.3, 0}, {0.4, 3, 0.2}}, b{{1, 0, 2}, {1, 3, -1}, {-2, 2, 1}};
  const Triangles t{{0, 1, 2}};
  double sum = 0;
  const int steps = 1000;
  std::vector<Vec3> last = a;
  for (int s = 1; s <= steps; ++s) {
    std::vector<Vec3> next(3);
    for (std::size_t i = 0; i < 3; ++i) next[i] = a[i] + static_cast<double>(s) / steps * (b[i] - a[i]);
    const Vec3 area = 0.5 * (next[1] - next[0] + last[1] - last[0]).cross(next[2] - next[0] + last[2] - last[0]) / 4;
    sum += area.dot(next[0] - last[0] + next[1] - last[1] + next[2] - last[2]) / 3;
    last = next;
  }
  EXPECT_NEAR(swept_volume(a, b, t), sum, 1e-5);
}

TEST(Volume, under_a_paraboloid) {
  // h = 4 - r^2 / 9 over a disc of radius 6: integral = pi (4 R^2 - R^4 / 18)
  const Cap flat = [] {
    Cap c = sphere_cap(1, 1, 120, 240);
    for (Vec3& p : c.points) {
      const double r = 6 * std::acos(std::min(1.0, p.z()));
      const Vec2 e = p.head<2>().norm() > 0 ? Vec2(p.head<2>().normalized()) : Vec2::Zero();
      p = Vec3(r * e.x(), r * e.y(), 4 - r * r / 9);
    }
    return c;
  }();
  const double expected = pi * (4 * 36 - 1296.0 / 18);
  EXPECT_NEAR(volume_under_surface(flat.points, flat.triangles, {Vec3::Zero(), Vec3::UnitZ()}), expected, 3e-4 * expected);
}

TEST(Orifice, known_polygons) {
  EXPECT_NEAR(positively_wound_area(std::vector<Vec2>{{0, 0}, {4, 0}, {4, 3}, {0, 3}}), 12, 1e-12);
  EXPECT_NEAR(positively_wound_area(std::vector<Vec2>{{0, 0}, {0, 3}, {4, 3}, {4, 0}}), 0, 1e-12);
  // Not convex, with a horizontal edge and a spike.
  EXPECT_NEAR(positively_wound_area(std::vector<Vec2>{{0, 0}, {6, 0}, {6, 4}, {3, 1}, {0, 4}}), 24 - 9, 1e-12);
  // Figure of eight: of its two equal lobes the one that runs backwards counts as closed.
  EXPECT_NEAR(positively_wound_area(std::vector<Vec2>{{0, 0}, {2, 2}, {2, 0}, {0, 2}}), 1, 1e-12);
}

TEST(Orifice, overlapping_edges_do_not_cancel_what_is_open) {
  // Anterior edge y = 2 - x along 0..4 (overlaps the posterior edge y = 0 beyond x = 2): open triangle 2, overlap 2.
  const std::vector<Vec2> loop{{0, 0}, {2, 0}, {4, 0}, {4, -2}, {2, 0}, {0, 2}};
  EXPECT_NEAR(positively_wound_area(loop), 2, 1e-12);
}

TEST(Orifice, ellipse_in_a_tilted_plane_and_closed_valve) {
  const Mat3 rotation = Eigen::AngleAxisd(0.9, Vec3(0.3, 1, -0.4).normalized()).toRotationMatrix();
  const AnnulusPlane plane{rotation * Vec3(1, 2, 3), rotation * Vec3::UnitZ()};
  std::vector<Vec3> open, closed;
  const int n = 200;
  for (int i = 0; i < n; ++i) {
    const double a = 2 * pi * i / n;
    open.push_back(rotation * Vec3(15 * std::cos(a), 10 * std::sin(a), -9 + std::cos(2 * a)));
    closed.push_back(rotation * Vec3(15 * std::cos(a), -0.5 * std::sin(a) - 3, -6));  // edges passed each other
  }
  const double inscribed = 0.5 * n * std::sin(2 * pi / n) * 150 * 1e-2;
  EXPECT_NEAR(orifice_area_cm2(open, open, plane), inscribed, 1e-9);
  EXPECT_NEAR(orifice_area_cm2(closed, open, plane), 0, 1e-12);
  std::vector<Vec3> backwards(open.rbegin(), open.rend());
  EXPECT_NEAR(orifice_area_cm2(backwards, backwards, plane), inscribed, 1e-9);
}

TEST(Loops, free_edge_of_a_ring_is_found_in_order) {
  const int rings = 4, sectors = 12;
  Triangles t;
  const auto at = [&](int i, int j) { return i * sectors + j % sectors; };
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j < sectors; ++j) {
      t.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      t.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  std::vector<char> edge(static_cast<std::size_t>((rings + 1) * sectors), 0);
  for (int j = 0; j < sectors; ++j) edge[static_cast<std::size_t>(at(rings, j))] = 1;
  const auto loops = flagged_boundary_loops(t, edge);
  ASSERT_EQ(loops.size(), 1u);
  ASSERT_EQ(loops[0].size(), static_cast<std::size_t>(sectors));
  for (std::size_t j = 0; j + 1 < loops[0].size(); ++j) {
    const int step = loops[0][j + 1] - loops[0][j];
    EXPECT_TRUE(step == 1 || step == 1 - sectors) << step;
  }
  // Cut open: a chain, starting where nothing arrives.
  edge[static_cast<std::size_t>(at(rings, 5))] = 0;
  const auto chain = flagged_boundary_loops(t, edge);
  ASSERT_EQ(chain.size(), 1u);
  ASSERT_EQ(chain[0].size(), static_cast<std::size_t>(sectors - 1));
  EXPECT_EQ(chain[0].front(), at(rings, 6));
}

TEST(Coaptation, depth_and_height_of_the_contact_inside_the_window) {
  const std::vector<Vec3> p{{0, 0, -2}, {0, 0, -5}, {0, 0, -9}, {0, 0, -1}};
  const std::vector<Vec2> uv{{10, 0}, {11, 0}, {12, 0}, {30, 0}};
  const std::vector<char> contact{0, 1, 1, 1};
  const Coaptation c = measure_coaptation(p, uv, contact, 5, 20, {Vec3(0, 0, 1), Vec3::UnitZ()});
  EXPECT_TRUE(c.present);
  EXPECT_NEAR(c.depth_mm, 6, 1e-12);
  EXPECT_NEAR(c.height_mm, 4, 1e-12);
  EXPECT_FALSE(measure_coaptation(p, uv, contact, 0, 5, {Vec3::Zero(), Vec3::UnitZ()}).present);
}

TEST(Metrics, sizes_that_do_not_match_are_refused) {
  const std::vector<Vec3> two(2, Vec3::Zero()), three(3, Vec3::Zero());
  EXPECT_THROW(swept_volume(two, three, {}), InputError);
  EXPECT_THROW(orifice_area_cm2(two, three, {}), InputError);
}

}  // namespace
}  // namespace mv
