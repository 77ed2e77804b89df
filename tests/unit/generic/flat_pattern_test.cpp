// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/generic/flat_pattern.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "geometry/core/errors.h"

namespace {

using mv::FlatPattern;
using mv::PatternParameters;
using std::numbers::pi;

TEST(FlatPattern, heights_at_the_scallop_centres_are_strip_plus_factor_times_radius) {
  const PatternParameters p;
  const FlatPattern pattern(p);
  const double rp = (p.perimeter - 2 * p.anterior_radius) / 6;
  EXPECT_NEAR(pattern.height(18), 6 + 0.9 * 18, 1e-12);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(pattern.height(36 + (2 * i + 1) * rp), 6 + 0.75 * rp, 1e-12);
  EXPECT_EQ(pattern.region(18), mv::anterior);
  EXPECT_EQ(pattern.region(36.01), mv::posterior);
  EXPECT_EQ(pattern.scallop(36 + 3 * rp), 2);
  EXPECT_EQ(pattern.scallop(-0.1), 3);  // u is periodic
  EXPECT_NEAR(pattern.height(-5), pattern.height(p.perimeter - 5), 1e-12);
}

TEST(FlatPattern, outside_the_fillets_the_free_edge_is_the_half_ellipse) {
  const PatternParameters p;
  const FlatPattern pattern(p);
  for (double u : {3.0, 9.0, 27.0, 33.0}) {
    const double d = (u - 18) / 18, e = (pattern.height(u) - 6) / (0.9 * 18);
    EXPECT_NEAR(d * d + e * e, 1, 1e-12) << u;
  }
}

TEST(FlatPattern, fillets_touch_both_neighbours_without_a_kink) {
  for (double r : {0.3, 1.0, 2.0}) {
    PatternParameters p;
    p.notch_radius = r;
    const FlatPattern pattern(p);
    const auto edge = pattern.free_edge(0.01);
    double total = 0;
    for (std::size_t i = 1; i + 1 < edge.size(); ++i) {
      const mv::Vec2 a = edge[i] - edge[i - 1], b = edge[i + 1] - edge[i];
      const double turn = std::abs(std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b)));
      EXPECT_LT(turn, 1.5 * 0.01 / r + 0.01) << "kink at u = " << edge[i].x() << ", fillet " << r;
      EXPECT_GT(a.x(), 0);  // single-valued in u
      total += a.norm();
    }
    EXPECT_GT(total, p.perimeter);
    for (int i = 0; i < 4; ++i) {
      EXPECT_GT(pattern.notch_height(i), p.strip_height);
      EXPECT_LT(pattern.notch_height(i), p.strip_height + 6);
    }
  }
}

TEST(FlatPattern, free_edge_points_lie_on_height) {
  const FlatPattern pattern{PatternParameters{}};
  for (const mv::Vec2& e : pattern.free_edge(0.05)) EXPECT_NEAR(pattern.height(e.x()), e.y(), 1e-5) << e.x();
}

TEST(FlatPattern, area_tends_to_strip_plus_half_ellipses_as_the_fillets_vanish) {
  PatternParameters p;
  const double rp = (p.perimeter - 36) / 6;
  const double sharp = p.perimeter * 6 + pi / 2 * (18 * 18 * 0.9 + 3 * rp * rp * 0.75);
  p.notch_radius = 1e-3;
  EXPECT_NEAR(FlatPattern(p).area(), sharp, 0.02);
  p.notch_radius = 1;
  EXPECT_GT(FlatPattern(p).area(), sharp + 1);
  EXPECT_LT(FlatPattern(p).area(), sharp + 20);
}

TEST(FlatPattern, parameters_that_leave_no_room_are_refused_by_name) {
  auto complaint = [](PatternParameters p) -> std::string {
    try {
      FlatPattern pattern(p);
    } catch (const mv::ConfigError& e) {
      return e.what();
    }
    return "";
  };
  PatternParameters p;
  p.anterior_radius = 60;
  EXPECT_NE(complaint(p).find("generic.anterior_radius"), std::string::npos);
  p = {};
  p.strip_height = 0;
  EXPECT_NE(complaint(p).find("generic.strip_height"), std::string::npos);
  p = {};
  p.notch_radius = 9;
  EXPECT_NE(complaint(p).find("generic.notch_radius"), std::string::npos);
  p = {};
  p.posterior_scallops = 0;
  EXPECT_NE(complaint(p).find("generic.posterior_scallops"), std::string::npos);
}

}  // namespace
