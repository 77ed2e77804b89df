// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/tube_stage.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "geometry/core/motion_table.h"
#include "geometry/core/tube_ends.h"
#include "unit/core/sample_case.h"

using mv::Vec3;

namespace {

constexpr double radius = 15, depth = 10, spacing = 2;  // mm

std::vector<Vec3> circle(int n) {
  std::vector<Vec3> points;
  for (int i = 0; i < n; ++i) points.emplace_back(radius * std::cos(2 * std::numbers::pi * i / n), radius * std::sin(2 * std::numbers::pi * i / n), 0);
  return points;
}

/// The tube of a round valve whose annulus is at `factors[k]` times its radius and `lifts[k]` mm higher at 0.1 k seconds.
mv::Tube tube(int points, const std::vector<double>& factors, const std::vector<double>& lifts, mv::TubeReport& report) {
  mv::Annulus annulus;
  annulus.points = circle(72);
  mv::LeafletMesh mesh;
  for (const Vec3& p : annulus.points)
    for (const bool is_annulus : {true, false}) {
      mesh.points.push_back(is_annulus ? p : Vec3(0.8 * p - depth * Vec3::UnitZ()));
      mesh.on_annulus.push_back(is_annulus);
    }
  const mv_test::TemporaryDirectory dir;
  const std::vector<Vec3> rest = circle(points);
  std::vector<double> times;
  std::vector<std::vector<Vec3>> moved(rest.size());
  for (std::size_t k = 0; k < factors.size(); ++k) {
    times.push_back(0.1 * static_cast<double>(k));
    for (std::size_t i = 0; i < rest.size(); ++i) moved[i].push_back((factors[k] - 1) * rest[i] + lifts[k] * Vec3::UnitZ());
  }
  mv::write_motion(dir / "m.csv", times, rest, moved);
  mv::Config config;
  config.set("annulus.motion=" + (dir / "m.csv").string());
  config.set("tube.spacing=2 mm");
  config.set("tube.length_ventricle=14 mm");
  config.set("tube.length_atrium=10 mm");
  return mv::make_tube(config, annulus, mesh, {}, &report);
}

}  // namespace

TEST(TubeStage, holds_the_leaflets_wherever_the_annulus_takes_them) {
  mv::TubeReport report;
  const mv::Tube t = tube(72, {1, 1, 1}, {0, -8, 9}, report);
  EXPECT_NEAR(t.z_ventricle, -(depth + 8 + mv::tube_end_cells * spacing), 1e-6);
  EXPECT_GE(t.z_atrium, 9 + mv::tube_end_cells * spacing);
  EXPECT_LT(t.z_atrium, 9 + (mv::tube_end_cells + 1) * spacing + 1e-6);
}

TEST(TubeStage, motions_of_few_points_are_taken) {
  mv::TubeReport report;
  EXPECT_NO_THROW(tube(7, {1, 0.9}, {0, 0}, report));
}

TEST(TubeStage, the_largest_stretch_is_said_once) {
  mv::TubeReport report;
  tube(72, {1, 1.5, 1.7, 1.6}, {0, 0, 0, 0}, report);
  ASSERT_EQ(report.warnings.size(), 1u);
  EXPECT_NE(report.warnings[0].find("at 0.2 s the annulus is 70 % longer"), std::string::npos) << report.warnings[0];
}
