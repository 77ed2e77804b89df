// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/generic/generic_valve.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>

#include "geometry/annulus/annulus_fit.h"
#include "geometry/core/errors.h"
#include "support/real_annulus.h"

namespace {

using mv::GenericValveParameters;
using mv::Vec2;
using mv::Vec3;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

struct Wrapped {
  mv::Annulus annulus;
  mv::FlatPattern pattern;
  mv::ConeWrap wrap;
};

Wrapped wrap_default(double slope, double saddle = 0, double anterior_height = 0.9) {
  GenericValveParameters p;
  p.saddle_height = saddle;
  mv::NormalHints hints;
  hints.ventricle_direction = -Vec3::UnitZ();
  mv::Annulus annulus = mv::fit_annulus(mv::generic_annulus_points(p), hints);
  mv::PatternParameters pattern;
  pattern.perimeter = mv::ClosedCurve(annulus.points).length();
  pattern.anterior_height = anterior_height;
  const mv::FlatPattern flat(pattern);
  return {annulus, flat, mv::ConeWrap(annulus, Vec3::UnitY(), flat, slope)};
}

TEST(ConeWrap, lengths_along_base_and_height_are_kept) {
  for (double saddle : {0.0, 5.0})
    for (double slope : {0.0, 0.35, 1.0}) {
      const Wrapped w = wrap_default(slope, saddle, 2.0);
      for (double u = 0.3; u < w.pattern.perimeter(); u += 6.7) {
        EXPECT_NEAR(w.wrap.along_u({u, 0}).norm(), 1, 2e-3);
        double length = 0;
        constexpr int n = 400;
        const double height = w.pattern.height(u);
        for (int i = 0; i < n; ++i)
          length += (w.wrap.position({u, height * (i + 1) / n}) - w.wrap.position({u, height * i / n})).norm();
        EXPECT_NEAR(length, height, 1e-4 * height) << "u " << u << " slope " << slope;
        EXPECT_NEAR(w.wrap.along_v({u, 0.7 * height}).norm(), 1, 1e-12);
      }
    }
}

TEST(ConeWrap, default_wall_is_a_cone_whose_lines_meet_in_one_apex) {
  const Wrapped w = wrap_default(0.35);
  double mean_slope = 0;
  constexpr int n = 200;
  double apex = 0;
  for (int i = 0; i < n; ++i) {
    const double u = w.pattern.perimeter() * i / n;
    const Vec3 top = w.wrap.position({u, 0}), tip = w.wrap.position({u, w.pattern.height(u)});
    const double travel = (tip - top).head<2>().norm(), slope = travel / (top.z() - tip.z());
    mean_slope += slope / n;
    const double depth = top.head<2>().norm() / slope;
    if (i == 0) apex = depth;
    EXPECT_NEAR(depth, apex, 1e-6);
    EXPECT_NEAR(tip.head<2>().normalized().dot(top.head<2>().normalized()), 1, 1e-9);
    EXPECT_LT(tip.head<2>().norm(), top.head<2>().norm());
  }
  EXPECT_NEAR(mean_slope, 0.35, 1e-3);
}

TEST(ConeWrap, anterior_leaflet_is_centred_on_its_direction_and_u_runs_counter_clockwise_from_the_atrium) {
  const Wrapped w = wrap_default(0.35);
  EXPECT_LT((w.wrap.position({18, 0}) - Vec3(0, 15, 0)).norm(), 1e-3);
  EXPECT_GT(w.wrap.along_u({18, 0}).dot(-Vec3::UnitX()), 0.999);  // at +y counter-clockwise from above goes to -x
  EXPECT_GT(w.wrap.normal({18, 5}).dot(-Vec3::UnitY()), 0.9);     // towards the inside
}

TEST(ConeWrap, a_leaflet_longer_than_the_radius_neither_crosses_the_centre_nor_closes_the_orifice) {
  const Wrapped w = wrap_default(1.0, 0, 2.5);
  EXPECT_GT(w.pattern.height(18), 45);
  EXPECT_NEAR(w.wrap.smallest_orifice_radius(), 0.35 * 15, 0.3);
  for (double u = 0; u < w.pattern.perimeter(); u += 1.7)
    for (double share : {0.2, 0.5, 0.8, 1.0}) {
      const Vec3 start = w.wrap.position({u, 0}) - w.wrap.centre(),
                 x = w.wrap.position({u, share * w.pattern.height(u)}) - w.wrap.centre();
      EXPECT_GT(start.head<2>().dot(x.head<2>()), 0);
    }
}

TEST(ConeWrap, curves_that_are_not_star_shaped_or_of_another_length_are_refused) {
  std::vector<Vec3> banana;
  for (int i = 0; i < 200; ++i) {
    const double t = 2 * std::acos(-1.0) * i / 200, x = 20 * std::cos(t);
    banana.push_back({x, 4 * std::sin(t) + 0.06 * x * x, 0});
  }
  mv::NormalHints hints;
  const mv::Annulus annulus = mv::fit_annulus(banana, hints);
  mv::PatternParameters p;
  p.perimeter = mv::ClosedCurve(banana).length();
  EXPECT_THROW(mv::ConeWrap(annulus, Vec3::UnitY(), mv::FlatPattern(p), 0.35), mv::InputError);
  p.perimeter = 90;
  EXPECT_THROW(mv::ConeWrap(annulus, Vec3::UnitY(), mv::FlatPattern(p), 0.35), mv::InputError);
}

/// Border edges, manifold test and orientation of the mid-surface.
void expect_a_ring(const mv::MidSurface& s) {
  std::map<std::pair<int, int>, int> directed;
  for (const auto& t : s.triangles)
    for (std::size_t k = 0; k < 3; ++k) ++directed[{t[k], t[(k + 1) % 3]}];
  long border_annulus = 0, border_free = 0, edges = 0;
  for (const auto& [e, count] : directed) {
    EXPECT_EQ(count, 1);
    const bool interior = directed.contains({e.second, e.first});
    edges += interior ? 1 : 2;
    if (interior) continue;
    const bool annulus = s.on_annulus[at(e.first)] && s.on_annulus[at(e.second)];
    const bool free_edge = s.on_free_edge[at(e.first)] && s.on_free_edge[at(e.second)];
    EXPECT_TRUE(annulus != free_edge);
    border_annulus += annulus;
    border_free += free_edge;
  }
  EXPECT_EQ(border_annulus, std::count(s.on_annulus.begin(), s.on_annulus.end(), 1));
  EXPECT_EQ(border_free, std::count(s.on_free_edge.begin(), s.on_free_edge.end(), 1));
  // A ring (annulus of genus 0 with two borders) has Euler characteristic 0.
  EXPECT_EQ(static_cast<long>(s.points.size()) - edges / 2 + static_cast<long>(s.triangles.size()), 0);
}

TEST(GenericValve, mesh_is_a_ring_of_near_equilateral_triangles_on_the_wrapped_pattern) {
  const mv::GenericValve valve = mv::build_generic_valve({}, 1.0);
  const mv::MidSurface& s = valve.mid_surface;
  expect_a_ring(s);
  EXPECT_LE(valve.report.face_edge_max, 1.0 + 1e-9);
  EXPECT_GT(valve.report.edge_mean, 0.7);
  EXPECT_GT(valve.report.angle_min, 20);
  EXPECT_GT(valve.orifice_radius_min, 5);
  const mv::FlatPattern pattern(valve.pattern);
  double flat_area = 0;
  for (int t = 0; t < static_cast<int>(s.triangles.size()); ++t) {
    const auto& tri = s.triangles[at(t)];
    const auto uv = mv::unfolded_triangle(s, t);
    const Vec2 a = uv[1] - uv[0], b = uv[2] - uv[0];
    const double area = 0.5 * (a.x() * b.y() - a.y() * b.x());
    EXPECT_GT(area, 0);
    flat_area += area;
    // Counter-clockwise seen from the inner side, and no triangle belongs to two leaflets.
    const Vec3 n = (s.points[at(tri[1])] - s.points[at(tri[0])]).cross(s.points[at(tri[2])] - s.points[at(tri[0])]);
    EXPECT_GT(n.dot(s.normals[at(tri[0])]), 0);
    for (const Vec2& c : uv) {
      EXPECT_GE(s.region[at(t)] == mv::anterior ? 36 - c.x() : c.x() - 36, -1e-9);
    }
  }
  EXPECT_NEAR(flat_area, pattern.area(), 0.01 * pattern.area());
  for (std::size_t i = 0; i < s.points.size(); ++i) {
    EXPECT_EQ(s.on_annulus[i] != 0, s.unfolded[i].y() == 0);
    if (s.on_annulus[i]) {
      EXPECT_NEAR(s.points[i].z(), 0, 1e-9);
    }
    EXPECT_LE(s.unfolded[i].y(), pattern.height(s.unfolded[i].x()) + 1e-3);
    EXPECT_NEAR(s.normals[i].norm(), 1, 1e-12);
  }
}

TEST(GenericValve, same_input_gives_the_same_mesh) {
  const mv::GenericValve a = mv::build_generic_valve({}, 1.5), b = mv::build_generic_valve({}, 1.5);
  EXPECT_EQ(a.mid_surface.triangles, b.mid_surface.triangles);
  ASSERT_EQ(a.mid_surface.points.size(), b.mid_surface.points.size());
  for (std::size_t i = 0; i < a.mid_surface.points.size(); ++i) EXPECT_EQ(a.mid_surface.points[i], b.mid_surface.points[i]);
}

TEST(GenericValve, two_commissure_columns_and_saddle_follow_the_parameters) {
  GenericValveParameters p;
  p.saddle_height = 4;
  p.posterior_scallops = 2;
  const mv::GenericValve valve = mv::build_generic_valve(p, 1.5);
  expect_a_ring(valve.mid_surface);
  double lowest = 1e300, highest = -1e300;
  for (const Vec3& x : valve.annulus.points) {
    lowest = std::min(lowest, x.z());
    highest = std::max(highest, x.z());
  }
  EXPECT_NEAR(highest - lowest, 4, 1e-3);
}

TEST(GenericValve, real_annulus_is_scaled_by_its_perimeter) {
  const auto folder = mv::test::real_annulus_folder();
  if (!folder) GTEST_SKIP() << "SKIPPED: no normal_1 data in configs/data or ../shared/data";
  const auto curve = mv::clean_closed_curve(mv::read_points_csv(*folder / "normal_1_annulus_mm.csv"));
  mv::NormalHints hints;
  hints.papillary_points = mv::read_points_csv(*folder / "normal_1_papillary_insertions_mm.csv");
  const mv::Annulus annulus = mv::fit_annulus(mv::smooth_closed_curve(curve, 10), hints);
  const mv::AnteriorDirection anterior = mv::find_anterior_direction(annulus, hints.papillary_points);
  const mv::GenericValve valve = mv::build_generic_valve({}, 1.0, annulus, anterior.direction);
  EXPECT_NEAR(valve.scale, 120.5 / 107.18, 0.01);
  EXPECT_NEAR(valve.pattern.anterior_radius, 18 * valve.scale, 1e-9);
  expect_a_ring(valve.mid_surface);
  EXPECT_LE(valve.report.face_edge_max, 1.0 + 1e-9);
  EXPECT_GT(valve.orifice_radius_min, 3);
  GenericValveParameters fixed;
  fixed.proportional = false;
  EXPECT_DOUBLE_EQ(mv::build_generic_valve(fixed, 2.0, annulus, anterior.direction).pattern.anterior_radius, 18);
}

}  // namespace
