// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/tube/tube.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "geometry/annulus/annulus_fit.h"
#include "geometry/core/errors.h"
#include "geometry/generic/generic_valve.h"
#include "geometry/volume/leaflet_tets.h"
#include "support/real_annulus.h"

namespace {

using mv::Vec2;
using mv::Vec3;
using std::numbers::pi;

mv::Annulus ellipse_annulus() {
  mv::NormalHints hints;
  hints.ventricle_direction = -Vec3::UnitZ();
  return mv::fit_annulus(mv::generic_annulus_points({}), hints);
}

TEST(Tube, frame_lengths_and_grid) {
  const mv::Tube tube = mv::build_tube(ellipse_annulus(), {});
  EXPECT_LT((tube.axes * tube.axes.transpose() - mv::Mat3::Identity()).norm(), 1e-12);
  EXPECT_NEAR(tube.axes.determinant(), 1, 1e-12);
  EXPECT_LT((tube.axes.row(2).transpose() - Vec3::UnitZ()).norm(), 1e-9);  // ventricle to atrium
  EXPECT_DOUBLE_EQ(tube.z_ventricle, -40);
  EXPECT_DOUBLE_EQ(tube.z_atrium, 20);
  EXPECT_EQ(tube.grid_cells[2], 60);
  EXPECT_DOUBLE_EQ(tube.grid_lower.z(), -40);
  for (const Vec2& p : tube.cross_section)
    for (Eigen::Index k = 0; k < 2; ++k) {
      EXPECT_GE(p[k] - tube.grid_lower[k], 3.0 - 1e-9);
      EXPECT_GE(tube.grid_lower[k] + tube.grid_cells[static_cast<std::size_t>(k)] * tube.grid_spacing - p[k], 3.0 - 1e-9);
    }
  EXPECT_GE(tube.grid_cells[0] * tube.grid_cells[1] * tube.grid_cells[2], 72000);
}

TEST(Tube, volume_converges_to_the_ellipse_and_every_jacobian_is_positive) {
  mv::TubeOptions options;
  options.clearance = 0.25;
  double last = 1e300;
  for (double size : {4.0, 2.0, 1.0}) {
    options.hex_size = size;
    mv::TubeReport report;
    const mv::Tube tube = mv::build_tube(ellipse_annulus(), options, &report);
    EXPECT_GT(report.jacobian_min, 0.5);
    EXPECT_NEAR(report.gap_min, 0.25, 0.02);
    EXPECT_LT(report.gap_max, 0.3);
    const double error = std::abs(mv::hex_volume(tube) / (pi * 19.25 * 15.25 * 60) - 1);
    EXPECT_LT(error, 0.5 * last + 1e-3);
    last = error;
  }
  EXPECT_LT(last, 2e-3);
}

TEST(Tube, cross_section_area_equals_hexahedra_over_length) {
  const mv::Tube tube = mv::build_tube(ellipse_annulus(), {});
  double twice = 0;
  const auto& c = tube.cross_section;
  for (std::size_t i = 0; i < c.size(); ++i) {
    const Vec2 &a = c[i], &b = c[(i + 1) % c.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  EXPECT_GT(twice, 0);  // counter-clockwise
  EXPECT_NEAR(mv::hex_volume(tube), 0.5 * twice * 60, 0.01 * 30 * twice);
}

TEST(Tube, lengths_are_rounded_up_to_whole_cells_and_lengthened_for_deep_tips) {
  mv::TubeOptions options;
  options.spacing = 0.7;
  mv::Tube tube = mv::build_tube(ellipse_annulus(), options);
  EXPECT_NEAR(tube.z_ventricle, -40.6, 1e-9);
  EXPECT_NEAR(tube.z_atrium, 20.3, 1e-9);
  options.spacing = 1;
  options.tips = {{10, -2, -45.5}, {-10, -2, -45}};
  mv::TubeReport report;
  tube = mv::build_tube(ellipse_annulus(), options, &report);
  EXPECT_DOUBLE_EQ(tube.z_ventricle, -48);
  EXPECT_DOUBLE_EQ(report.lengthened_ventricle, 8);
  ASSERT_EQ(report.notes.size(), 1u);
  EXPECT_NE(report.notes[0].find("lengthened"), std::string::npos);
}

TEST(Tube, leaflet_at_the_annulus_lies_inside_by_the_clearance_and_not_much_more) {
  const mv::GenericValve valve = mv::build_generic_valve({}, 1.5);
  mv::TubeOptions options;
  options.contained = mv::thicken(valve.mid_surface, {}).points;
  mv::TubeReport report;
  const mv::Tube tube = mv::build_tube(valve.annulus, options, &report);
  for (const Vec3& p : options.contained)
    EXPECT_TRUE(mv::inside_outline(tube.cross_section, (tube.axes * (p - tube.origin)).head<2>()));
  EXPECT_LT(report.gap_max, 0.5 + 0.25 + 0.1);
  for (const mv::Gate& gate : mv::check_tube(tube, valve.annulus, {{10, -2, -32}, {-10, -2, -32}}))
    EXPECT_TRUE(gate.passed) << gate.message;
}

TEST(Tube, a_tip_outside_the_wall_is_noted_and_widens_only_on_request) {
  mv::TubeOptions options;
  options.tips = {{21, 0, -30}, {-10, 0, -30}};
  mv::TubeReport report;
  mv::Tube tube = mv::build_tube(ellipse_annulus(), options, &report);
  EXPECT_NEAR(report.tips_outside, 21 - 19.25, 0.05);
  EXPECT_FALSE(mv::inside_outline(tube.cross_section, {21, 0}));
  EXPECT_EQ(report.notes.size(), 1u);
  options.widen_for_tips = true;
  tube = mv::build_tube(ellipse_annulus(), options, &report);
  EXPECT_TRUE(mv::inside_outline(tube.cross_section, {21, 0}));
  EXPECT_GT(report.gap_max, 1.5);
  const auto gates = mv::check_tube(tube, ellipse_annulus(), {{60, 0, -30}});
  EXPECT_FALSE(gates[2].passed);
}

TEST(Tube, wrong_lengths_and_folded_outlines_are_refused) {
  mv::TubeOptions options;
  options.spacing = 0;
  EXPECT_THROW(mv::build_tube(ellipse_annulus(), options), mv::ConfigError);
  options.spacing = 1;
  options.length_atrium = 0.5;
  EXPECT_THROW(mv::build_tube(ellipse_annulus(), options), mv::ConfigError);
  std::vector<Vec3> banana;
  for (int i = 0; i < 200; ++i) {
    const double t = 2 * pi * i / 200, x = 20 * std::cos(t);
    banana.push_back({x, 4 * std::sin(t) + 0.06 * x * x, 0});
  }
  EXPECT_THROW(mv::build_tube(mv::fit_annulus(banana, {}), {}), mv::InputError);
}

TEST(Tube, inverted_hexahedron_is_seen) {
  mv::Tube tube = mv::build_tube(ellipse_annulus(), {});
  std::swap(tube.hexes[5][0], tube.hexes[5][1]);
  EXPECT_LT(mv::smallest_scaled_jacobian(tube), 0);
  EXPECT_FALSE(mv::check_tube(tube, ellipse_annulus(), {})[0].passed);
}

TEST(Tube, real_annulus_is_wrapped_closely) {
  const auto folder = mv::test::real_annulus_folder();
  if (!folder) GTEST_SKIP() << "SKIPPED: no normal_1 data in configs/data or ../shared/data";
  const auto curve = mv::clean_closed_curve(mv::read_points_csv(*folder / "normal_1_annulus_mm.csv"));
  mv::NormalHints hints;
  hints.papillary_points = mv::read_points_csv(*folder / "normal_1_papillary_insertions_mm.csv");
  const mv::Annulus annulus = mv::fit_annulus(mv::smooth_closed_curve(curve, 10), hints);
  mv::TubeOptions options;
  options.tips = mv::group_papillary_points(hints.papillary_points, annulus,
                                            mv::find_anterior_direction(annulus, hints.papillary_points).direction)
                     .tips;
  mv::TubeReport report;
  const mv::Tube tube = mv::build_tube(annulus, options, &report);
  EXPECT_GT(report.jacobian_min, 0.3);
  EXPECT_GT(report.gap_min, 0.2);
  EXPECT_LT(report.gap_max, 1.0);
  for (const mv::Gate& gate : mv::check_tube(tube, annulus, options.tips))
    EXPECT_TRUE(gate.passed) << gate.name << ": " << gate.message;
}

}  // namespace
