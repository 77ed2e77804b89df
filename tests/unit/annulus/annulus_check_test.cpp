// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/annulus/annulus_check.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>
#include <random>

#include "geometry/core/errors.h"

using mv::Vec3;

namespace {

constexpr double pi = std::numbers::pi;

/// Saddle-shaped ellipse, tilted and off the origin.
std::vector<Vec3> annulus(int n, double scale = 1, double noise = 0) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal(0, noise > 0 ? noise : 1);
  const Eigen::AngleAxisd tilt(0.9, Vec3(1, 2, -1).normalized());
  std::vector<Vec3> points;
  for (int i = 0; i < n; ++i) {
    const double a = 2 * pi * i / n;
    Vec3 p(19 * std::cos(a), 15 * std::sin(a), 3 * std::cos(2 * a));
    if (noise > 0) p += Vec3(normal(random), normal(random), normal(random));
    points.push_back(scale * (tilt * p + Vec3(40, -120, 300)));
  }
  return points;
}

std::string fault(const std::vector<Vec3>& curve) {
  try {
    for (const std::string& note : mv::check_annulus_curve(curve, "a.csv")) EXPECT_TRUE(note.starts_with("a.csv: ")) << note;
  } catch (const mv::InputError& e) {
    EXPECT_TRUE(std::string(e.what()).starts_with("a.csv: ")) << e.what();
    return e.what();
  }
  return "";
}

#define EXPECT_NAMES(message, part) EXPECT_NE((message).find(part), std::string::npos) << (message)

}  // namespace

TEST(AnnulusCheck, real_shapes_pass_without_a_word) {
  for (const int n : {8, 12, 100, 3000}) EXPECT_TRUE(mv::check_annulus_curve(annulus(n), "a.csv").empty()) << n;
  EXPECT_TRUE(mv::check_annulus_curve(annulus(400, 1, 0.25), "a.csv").empty()) << "noise as large as the distance of points";
  std::vector<Vec3> backwards = annulus(100);
  std::reverse(backwards.begin(), backwards.end());
  EXPECT_TRUE(mv::check_annulus_curve(backwards, "a.csv").empty());
  std::vector<Vec3> kidney;
  for (int i = 0; i < 200; ++i) {
    const double a = 2 * pi * i / 200, r = 18 - 7 * std::exp(-8 * std::pow(std::remainder(a - 1.5, 2 * pi), 2));
    kidney.emplace_back(r * std::cos(a), 0.8 * r * std::sin(a), 0);
  }
  EXPECT_TRUE(mv::check_annulus_curve(kidney, "a.csv").empty());
}

TEST(AnnulusCheck, small_loops_of_noise_pass_without_smoothing) {
  EXPECT_TRUE(mv::check_annulus_curve(annulus(450, 1, 0.1), "a.csv", 0).empty());
  std::vector<Vec3> half = annulus(450, 1, 0.1);
  std::reverse(half.begin() + 225, half.end());
  EXPECT_THROW(mv::check_annulus_curve(half, "a.csv", 0), mv::InputError);
}

TEST(AnnulusCheck, dense_points_on_one_part_do_not_move_the_middle_out_of_the_curve) {
  std::vector<Vec3> kidney;  // its horns, where the points are, lie on a line outside
  for (double a = -pi, step = 0; a < pi; a += step) {
    const double r = 22 - 12 * std::exp(-8 * a * a);
    kidney.emplace_back(r * std::cos(a), r * std::sin(a), 0);
    step = std::abs(std::abs(a) - 0.75) < 0.2 ? 4e-4 : 0.016;
  }
  EXPECT_NO_THROW(mv::check_annulus_curve(kidney, "a.csv"));
}

TEST(AnnulusCheck, sizes_of_other_units_are_named) {
  EXPECT_NAMES(fault(annulus(100, 1e-3)), "metres instead of millimetres");
  EXPECT_NAMES(fault(annulus(100, 1e3)), "micrometres instead of millimetres");
  const auto small = mv::check_annulus_curve(annulus(100, 0.1), "a.csv");
  ASSERT_EQ(small.size(), 1u);
  EXPECT_NAMES(small[0], "3.8 mm across");
  std::vector<Vec3> outlier = annulus(100);
  outlier[30] = Vec3(9e4, 0, 0);
  EXPECT_NAMES(fault(outlier), "because of the point at (90000.0, 0.0, 0.0) mm");
}

TEST(AnnulusCheck, order_is_checked) {
  const std::vector<Vec3> good = annulus(120);
  std::vector<Vec3> twice = good;
  twice.insert(twice.end(), good.begin(), good.end());
  EXPECT_NAMES(fault(twice), "goes round 2 times");
  std::vector<Vec3> half = good;
  std::reverse(half.begin() + 60, half.end());
  EXPECT_NAMES(fault(half), "crosses itself");
  std::vector<Vec3> there_and_back;
  for (int i = 0; i <= 60; ++i) there_and_back.emplace_back(20 * std::cos(pi * i / 60), 20 * std::sin(pi * i / 60), 0);
  for (int i = 60; i >= 0; --i) there_and_back.emplace_back(16 * std::cos(pi * i / 60), 16 * std::sin(pi * i / 60), 0);
  EXPECT_NAMES(fault(there_and_back), "does not go round its middle");
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::vector<Vec3> shuffled = good;
    std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937(seed));
    EXPECT_NAMES(fault(shuffled), "not in order");
  }
  for (const int quarter : {20, 30, 40}) {
    std::vector<Vec3> swapped = good;
    std::rotate(swapped.begin() + 30, swapped.begin() + 30 + quarter, swapped.begin() + 30 + 2 * quarter);
    EXPECT_NE(fault(swapped), "") << quarter;
    std::vector<Vec3> turned = good;
    std::reverse(turned.begin() + 30, turned.begin() + 30 + quarter);
    EXPECT_NE(fault(turned), "") << quarter;
  }
}

TEST(AnnulusCheck, a_missing_part_is_an_error_or_a_warning) {
  const std::vector<Vec3> good = annulus(200);
  EXPECT_NAMES(fault({good.begin(), good.begin() + 100}), "a part of the annulus is missing");
  const auto gap = mv::check_annulus_curve({good.begin(), good.begin() + 150}, "a.csv");
  ASSERT_EQ(gap.size(), 1u);
  EXPECT_NAMES(gap[0], "closed by a straight line");
  EXPECT_NAMES(fault(std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}, {5, 0, 0}, {6, 0, 0}, {30, 0, 0}}), "on a line");
}

TEST(AnnulusCheck, papillary_points_of_another_space_are_named) {
  const std::vector<Vec3> curve = annulus(100);
  EXPECT_TRUE(mv::check_papillary_points({curve[0] + Vec3(0, 0, -35), curve[50] + Vec3(0, 0, -35)}, curve, "p.csv").empty());
  EXPECT_EQ(mv::check_papillary_points({curve[0] + Vec3(0, 0, -120), curve[0]}, curve, "p.csv").size(), 1u);
  EXPECT_THROW(mv::check_papillary_points({Vec3(-40, 120, 300), curve[0]}, curve, "p.csv"), mv::InputError);
}
