// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/annulus/annulus_fit.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <numbers>
#include <random>

#include "geometry/core/errors.h"
#include "support/real_annulus.h"

namespace {

using mv::Vec3;
using std::numbers::pi;

std::vector<Vec3> ellipse(double a, double b, const Eigen::Isometry3d& pose, int n = 400, double saddle = 0) {
  std::vector<Vec3> points;
  for (int i = 0; i < n; ++i) {
    const double t = 2 * pi * i / n;
    points.push_back(pose * Vec3(a * std::cos(t), b * std::sin(t), -saddle / 2 * std::cos(2 * t)));
  }
  return points;
}

Eigen::Isometry3d tilted() {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translate(Vec3(12, -40, 7)).rotate(Eigen::AngleAxisd(0.7, Vec3(1, 2, -0.5).normalized()));
  return pose;
}

TEST(AnnulusFit, tilted_ellipse_gives_its_plane_axes_and_eigenvalues) {
  const Eigen::Isometry3d pose = tilted();
  mv::NormalHints hints;
  hints.ventricle_direction = pose.rotation() * Vec3(0.3, 0, -1);
  const mv::Annulus annulus = mv::fit_annulus(ellipse(20, 12, pose), hints);
  EXPECT_LT((annulus.normal - pose.rotation() * Vec3(0, 0, -1)).norm(), 1e-10);
  EXPECT_NEAR(std::abs(annulus.axis_major.dot(pose.rotation() * Vec3::UnitX())), 1, 1e-10);
  EXPECT_LT((annulus.origin - pose.translation()).norm(), 1e-9);
  EXPECT_LT(annulus.residual_rms, 1e-6);
  EXPECT_GT(annulus.eigenvalues[0], annulus.eigenvalues[1]);
  EXPECT_EQ(annulus.sign_rule, "given direction");
  // A circle has both in-plane eigenvalues r^2 / 2.
  const mv::Annulus round = mv::fit_annulus(ellipse(10, 10, pose), hints);
  EXPECT_NEAR(round.eigenvalues[0], 50, 1e-6);
  EXPECT_NEAR(round.eigenvalues[1], 50, 1e-6);
}

TEST(AnnulusFit, residual_is_the_noise_normal_to_the_plane) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, 0.2);
  std::vector<Vec3> points = ellipse(20, 15, Eigen::Isometry3d::Identity(), 4000);
  for (Vec3& p : points) p.z() += noise(random);
  const mv::Annulus annulus = mv::fit_annulus(points, {});
  EXPECT_NEAR(annulus.residual_rms, 0.2, 0.01);
  EXPECT_GT(-annulus.normal.z(), 0.9999);
  EXPECT_EQ(annulus.sign_rule, "assumed -z (superior is atrial)");
}

TEST(AnnulusFit, uneven_sampling_does_not_tilt_the_plane) {
  // Half of the saddle is sampled twenty times as densely; without arc-length weights the centre moves by millimetres.
  std::vector<Vec3> points;
  for (int i = 0; i < 2000; ++i) points.push_back({20 * std::cos(pi * i / 2000), 20 * std::sin(pi * i / 2000), 0});
  for (int i = 0; i < 100; ++i) points.push_back({20 * std::cos(pi + pi * i / 100), 20 * std::sin(pi + pi * i / 100), 0});
  EXPECT_LT(mv::fit_annulus(points, {}).origin.norm(), 0.02);
}

TEST(AnnulusFit, papillary_points_decide_the_sign) {
  mv::NormalHints hints;
  hints.papillary_points = {{5, 0, 30}, {-5, 0, 28}};
  const mv::Annulus annulus = mv::fit_annulus(ellipse(20, 15, Eigen::Isometry3d::Identity()), hints);
  EXPECT_GT(annulus.normal.z(), 0.999);
  EXPECT_EQ(annulus.sign_rule, "papillary points");
}

TEST(AnnulusFit, hints_in_the_plane_lines_and_short_curves_are_refused) {
  mv::NormalHints hints;
  hints.ventricle_direction = Vec3::UnitX();
  EXPECT_THROW(mv::fit_annulus(ellipse(20, 15, Eigen::Isometry3d::Identity()), hints), mv::InputError);
  EXPECT_THROW(mv::fit_annulus(ellipse(20, 0, Eigen::Isometry3d::Identity()), {}), mv::InputError);
  EXPECT_THROW(mv::fit_annulus(std::vector<Vec3>(5, Vec3::Zero()), {}), mv::InputError);
}

TEST(AnnulusMetrics, ellipse_and_saddle_have_their_known_sizes) {
  mv::NormalHints hints;
  const Eigen::Isometry3d pose = tilted();
  hints.ventricle_direction = pose.rotation() * Vec3(0, 0, -1);
  const mv::Annulus flat = mv::fit_annulus(ellipse(19, 15, pose, 2000), hints);
  const mv::AnnulusMetrics m = mv::measure_annulus(flat, pose.rotation() * Vec3::UnitY());
  EXPECT_NEAR(m.ap_diameter, 30, 1e-3);
  EXPECT_NEAR(m.al_pm_diameter, 38, 1e-3);
  EXPECT_NEAR(m.sphericity, 30.0 / 38.0, 1e-4);
  EXPECT_NEAR(m.area_2d, pi * 19 * 15, 0.01);
  EXPECT_NEAR(m.area_3d, pi * 19 * 15, 1.0);  // 144-point polygon of the rim
  EXPECT_NEAR(m.height, 0, 1e-9);
  // Ramanujan's second formula
  const double q = std::pow(4.0 / 34.0, 2);
  EXPECT_NEAR(m.perimeter, pi * 34 * (1 + 3 * q / (10 + std::sqrt(4 - 3 * q))), 1e-3);
  EXPECT_NEAR(m.perimeter_2d, m.perimeter, 1e-4);  // a 2048-gon is shorter by 107 mm times pi^2 / (6 2048^2)

  const mv::Annulus saddle = mv::fit_annulus(ellipse(15, 15, pose, 2000, 4), hints);
  const mv::AnnulusMetrics s = mv::measure_annulus(saddle, pose.rotation() * Vec3::UnitY());
  EXPECT_NEAR(s.height, 4, 1e-3);
  EXPECT_NEAR(s.height_to_al_pm, 4.0 / 30.0, 1e-3);
  EXPECT_GT(s.perimeter, s.perimeter_2d + 0.1);
  EXPECT_NEAR(s.area_2d, pi * 225, 0.05);
  // h = 2 (r/15)^2 cos 2t has |grad h|^2 = 16 r^2 / 15^4; area = 2 pi int sqrt(1 + |grad h|^2) r dr
  const double k = 16.0 / std::pow(15.0, 4);
  EXPECT_NEAR(s.area_3d, 2 * pi / (3 * k) * (std::pow(1 + k * 225, 1.5) - 1), 1.0);
}

TEST(Papillary, eight_points_make_two_named_tips) {
  mv::NormalHints hints;
  hints.ventricle_direction = Vec3(0, 0, -1);
  const mv::Annulus annulus = mv::fit_annulus(ellipse(19, 15, Eigen::Isometry3d::Identity()), hints);
  const std::vector<Vec3> points{{10, -2, -32}, {-10, -2, -32}, {11, -2, -32}, {-11, -3, -32}, {9, -2, -32}, {-9, -1, -32}};
  const mv::Papillary tips = mv::group_papillary_points(points, annulus, Vec3::UnitY());
  ASSERT_EQ(tips.tips.size(), 2u);
  // Seen from the atrium (+z) with the anterior leaflet up (+y) the anterolateral tip is on the left (-x).
  EXPECT_EQ(tips.names[0], "anterolateral");
  EXPECT_LT((tips.tips[0] - Vec3(-10, -2, -32)).norm(), 1e-12);
  EXPECT_LT((tips.tips[1] - Vec3(10, -2, -32)).norm(), 1e-12);
  EXPECT_THROW(mv::group_papillary_points({{1, 2, 3}}, annulus, Vec3::UnitY()), mv::InputError);
  EXPECT_THROW(mv::group_papillary_points({{1, 2, 3}, {1, 2, 3}}, annulus, Vec3::UnitY()), mv::InputError);
}

TEST(Papillary, anterior_direction_is_away_from_the_tips_or_towards_the_higher_horn) {
  mv::NormalHints hints;
  hints.ventricle_direction = Vec3(0, 0, -1);
  const mv::Annulus annulus = mv::fit_annulus(ellipse(19, 15, Eigen::Isometry3d::Identity()), hints);
  const mv::AnteriorDirection away = mv::find_anterior_direction(annulus, {{10, -2, -32}, {-10, -2, -32}});
  EXPECT_LT((away.direction - Vec3::UnitY()).norm(), 1e-9);
  EXPECT_EQ(away.rule, "papillary tips lie posterior");
  EXPECT_NEAR(away.confidence, 2, 1e-6);
  std::vector<Vec3> horned = ellipse(19, 15, Eigen::Isometry3d::Identity(), 400);
  for (Vec3& p : horned) p.z() += 3 * std::pow(std::max(0.0, -p.y() / 15), 3);  // a horn at -y only
  const mv::Annulus raised = mv::fit_annulus(horned, hints);
  const mv::AnteriorDirection higher = mv::find_anterior_direction(
      raised, {raised.origin + 30 * raised.normal + Vec3(10, 0, 0), raised.origin + 30 * raised.normal - Vec3(10, 0, 0)});
  EXPECT_EQ(higher.rule, "anterior horn is higher");
  EXPECT_LT(higher.direction.y(), -0.9);
  EXPECT_THROW(mv::find_anterior_direction(annulus, {}, Vec3::UnitZ()), mv::InputError);
}

class PointsCsv : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& text) {
    const std::filesystem::path file = std::filesystem::path(::testing::TempDir()) / ("annulus_points_" + std::to_string(::getpid()) + ".csv");
    std::ofstream(file) << text;
    return file;
  }
  std::string complaint(const std::string& text) {
    try {
      mv::read_points_csv(write(text));
    } catch (const mv::InputError& e) {
      return e.what();
    }
    return "";
  }
};

TEST_F(PointsCsv, columns_may_stand_in_any_order_among_others) {
  const auto points = mv::read_points_csv(write("name,z_mm,x_mm,y_mm\r\na,3,1,2\r\n\r\nb,6,4,5\r\n"));
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[1], Vec3(4, 5, 6));
}

TEST_F(PointsCsv, errors_name_line_and_column) {
  EXPECT_NE(complaint("x_mm,y_mm\n1,2\n").find("'z_mm' is missing"), std::string::npos);
  EXPECT_NE(complaint("x_mm,y_mm,z_mm\n1,2,3\n1,two,3\n").find("line 3: y_mm: 'two'"), std::string::npos);
  EXPECT_NE(complaint("x_mm,y_mm,z_mm\n1,2\n").find("line 2: z_mm: ''"), std::string::npos);
  EXPECT_NE(complaint("x_mm,y_mm,z_mm\n1,2,inf\n").find("not a finite number"), std::string::npos);
  EXPECT_NE(complaint("x_mm,y_mm,z_mm\n1,1e308,3\n").find("line 2: y_mm: '1e308' mm is no place"), std::string::npos);
  EXPECT_NE(complaint("x_mm,y_mm,z_mm\n").find("no points"), std::string::npos);
  EXPECT_THROW(mv::read_points_csv("/nonexistent/points.csv"), mv::IoError);
}

TEST(RealAnnulus, normal_1_has_the_printed_perimeter_and_a_decided_frame) {
  const auto folder = mv::test::real_annulus_folder();
  if (!folder) GTEST_SKIP() << "SKIPPED: no normal_1 data in configs/data or ../shared/data";
  mv::CurveReport report;
  const auto curve = mv::clean_closed_curve(mv::read_points_csv(*folder / "normal_1_annulus_mm.csv"), &report);
  const auto papillary = mv::read_points_csv(*folder / "normal_1_papillary_insertions_mm.csv");
  mv::NormalHints hints;
  hints.papillary_points = papillary;
  const mv::Annulus annulus = mv::fit_annulus(curve, hints);
  const mv::AnteriorDirection anterior = mv::find_anterior_direction(annulus, papillary);
  EXPECT_EQ(report.points_read, 450);
  EXPECT_NEAR(mv::measure_annulus(annulus, anterior.direction).perimeter, 120.5, 0.2);
  EXPECT_GT(anterior.confidence, 3);
  const mv::Papillary tips = mv::group_papillary_points(papillary, annulus, anterior.direction);
  for (const Vec3& tip : tips.tips) {
    EXPECT_GT((tip - annulus.origin).dot(annulus.normal), 15);
    EXPECT_LT((tip - annulus.origin).dot(anterior.direction), 0);
  }
  EXPECT_GT((tips.tips[0] - tips.tips[1]).dot(anterior.direction.cross(annulus.normal)), 30);
}

}  // namespace
