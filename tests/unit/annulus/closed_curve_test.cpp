// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/annulus/closed_curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "geometry/core/errors.h"

namespace {

using mv::Vec3;
using std::numbers::pi;

std::vector<Vec3> circle(int n, double radius) {
  std::vector<Vec3> points;
  for (int i = 0; i < n; ++i) points.push_back({radius * std::cos(2 * pi * i / n), radius * std::sin(2 * pi * i / n), 0});
  return points;
}

TEST(ClosedCurve, duplicates_repeated_end_and_spikes_are_removed_in_order) {
  std::vector<Vec3> points = circle(40, 20);
  const std::vector<Vec3> clean = points;
  points.insert(points.begin() + 7, points[7]);
  points.insert(points.begin() + 20, Vec3(points[19] + Vec3(0, 0, 9)));  // out and back
  points.push_back(points.front());
  mv::CurveReport report;
  const std::vector<Vec3> result = mv::clean_closed_curve(points, &report);
  EXPECT_EQ(report.points_read, 43);
  EXPECT_EQ(report.duplicates_removed, 2);
  EXPECT_EQ(report.spikes_removed, 1);
  ASSERT_EQ(result.size(), clean.size());
  for (std::size_t i = 0; i < clean.size(); ++i) EXPECT_LT((result[i] - clean[i]).norm(), 1e-12);
}

TEST(ClosedCurve, dense_noisy_points_are_in_order_and_shuffled_ones_are_not) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 0.1);
  std::vector<Vec3> points;
  for (int i = 0; i < 3000; ++i) points.push_back({19 * std::cos(2 * pi * i / 3000) + noise(random), 15 * std::sin(2 * pi * i / 3000) + noise(random), noise(random)});
  mv::CurveReport report;
  const std::vector<Vec3> smooth = mv::smooth_closed_curve(mv::clean_closed_curve(points, &report), 8, 360);
  for (const Vec3& p : smooth) EXPECT_NEAR(std::hypot(p.x() / 19, p.y() / 15), 1, 0.02);
  std::vector<Vec3> halves;  // one half of the turn and the other, point by point
  for (std::size_t i = 0; i < 1500; ++i) halves.insert(halves.end(), {points[i], points[i + 1500]});
  EXPECT_THROW(mv::clean_closed_curve(halves), mv::InputError);
  for (int trial = 0; trial < 10; ++trial) {
    std::shuffle(points.begin(), points.end(), random);
    EXPECT_THROW(mv::clean_closed_curve(points), mv::InputError);
  }
}

TEST(ClosedCurve, too_few_points_and_non_finite_points_are_refused) {
  EXPECT_THROW(mv::clean_closed_curve(circle(7, 20)), mv::InputError);
  EXPECT_THROW(mv::clean_closed_curve(std::vector<Vec3>(20, Vec3::Ones())), mv::InputError);
  std::vector<Vec3> points = circle(20, 20);
  points[3].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(mv::clean_closed_curve(points), mv::InputError);
}

TEST(ClosedCurve, circle_has_its_length_and_unit_speed_even_from_uneven_points) {
  std::vector<Vec3> points;
  for (int i = 0; i < 200; ++i) {
    const double angle = 2 * pi * (i + 0.4 * std::sin(0.3 * i)) / 200;
    points.push_back({20 * std::cos(angle), 20 * std::sin(angle), 5});
  }
  const mv::ClosedCurve curve(points);
  EXPECT_NEAR(curve.length(), 2 * pi * 20, 2e-3);
  for (double u = -30; u < 300; u += 7.31) {
    EXPECT_NEAR(curve.tangent(u).norm(), 1, 1e-3);
    EXPECT_NEAR(curve.at(u).head<2>().norm(), 20, 2e-3);
    EXPECT_LT((curve.at(u) - curve.at(u + curve.length())).norm(), 1e-9);
  }
}

TEST(ClosedCurve, closest_returns_the_arc_length_of_a_point_on_the_curve) {
  const mv::ClosedCurve curve(circle(360, 15));
  for (double u : {0.001, 3.3, 47.0, 94.2}) EXPECT_NEAR(curve.closest(curve.at(u)), u, 1e-6);
}

TEST(ClosedCurve, smoothing_keeps_low_modes_and_removes_a_kink_and_reports_the_change) {
  mv::CurveReport report;
  const std::vector<Vec3> round = mv::smooth_closed_curve(circle(300, 18), 8, 360, &report);
  EXPECT_EQ(report.harmonics, 8);
  EXPECT_LT(report.smoothing_max, 2e-3);
  std::vector<Vec3> kinked = circle(300, 18);
  kinked[50] *= 1.05;
  const std::vector<Vec3> smooth = mv::smooth_closed_curve(kinked, 8, 360, &report);
  EXPECT_GT(report.smoothing_max, 0.5);  // the kink itself is reported
  // The 0.9 mm spike covers about 2 mm of arc; 17 of 300 modes leave 17/113 of its area of 0.9 mm2 as height, plus its share in
  // the length.
  for (const Vec3& p : smooth) EXPECT_NEAR(p.norm(), 18, 0.2);
}

}  // namespace
