// SPDX-License-Identifier: BSD-3-Clause
#include "solver/time/annulus_skirt.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "geometry/core/errors.h"

using namespace mv;

namespace {

constexpr double radius = 15, wall = 15.5;  // mm
constexpr int around = 72;

Vec3 on_circle(int i) { return {radius * std::cos(2 * M_PI * i / around), radius * std::sin(2 * M_PI * i / around), 0}; }

Scene scene() {
  Scene s;
  for (int i = 0; i < around; ++i) {
    s.annulus.points.push_back(on_circle(i));
    s.mesh.points.push_back(on_circle(i));
    s.mesh.on_annulus.push_back(1);
    s.mesh.points.push_back(on_circle(i) * 0.8 - Vec3(0, 0, 10));
    s.mesh.on_annulus.push_back(0);
  }
  for (int i = 0; i < 360; ++i) s.tube.cross_section.push_back(wall * Vec2(std::cos(M_PI * i / 180), std::sin(M_PI * i / 180)));
  s.tube.grid_spacing = 1;
  s.tube.z_ventricle = -30, s.tube.z_atrium = 20;
  return s;
}

/// From the place at rest at 0 s to `factor` times the radius, `lift` mm higher, at 1 s.
AnnulusMotion motion(const Scene& s, double factor, double lift) {
  std::vector<Vec3> rest;
  std::vector<std::vector<Vec3>> u;
  for (int i = 0; i < around; ++i) {
    rest.push_back(on_circle(i));
    u.push_back({Vec3::Zero(), (factor - 1) * on_circle(i) + Vec3(0, 0, lift)});
  }
  return AnnulusMotion(MotionTable({0, 1}, rest, u), s.mesh, s.tube, "m.csv");
}

std::string fault(double factor, double lift) {
  const Scene s = scene();
  try {
    AnnulusSkirt(s, motion(s, factor, lift), "m.csv");
  } catch (const InputError& e) {
    EXPECT_TRUE(std::string(e.what()).starts_with("m.csv: at 1 s ")) << e.what();
    return e.what();
  }
  return "";
}

}  // namespace

TEST(AnnulusSkirt, reaches_from_the_annulus_to_the_wall_at_all_times) {
  const Scene s = scene();
  const AnnulusSkirt skirt(s, motion(s, 0.8, 2), "m.csv");  // 3 mm inwards
  std::vector<double> x(3 * skirt.points());
  std::vector<char> is_inside(skirt.points());
  for (const double time : {0.0, 0.3, 0.5, 1.0, 2.0}) {
    skirt.place(time, x, is_inside);
    const double t = std::min(time, 1.0), share = t * t * (3 - 2 * t), inner = 1e-3 * radius * (1 - 0.2 * share);
    std::vector<double> farthest(around, 0.0), nearest(around, 1.0);
    for (std::size_t i = 0; i < skirt.points(); ++i) {
      const Vec3 p = Vec3::Map(x.data() + 3 * i);
      EXPECT_NEAR(p.z(), 2e-3 * share, 1e-9);
      const double r = p.head<2>().norm();
      EXPECT_GT(r, inner + 0.3e-3);
      if (std::abs(r - (1e-3 * wall + 0.5e-3)) > 1e-5) {
        EXPECT_EQ(is_inside[i] != 0, r < 1e-3 * wall + 0.5e-3) << r;
      }
      if (!is_inside[i]) continue;
      const auto sector = static_cast<std::size_t>(std::floor((std::atan2(p.y(), p.x()) + M_PI) / (2 * M_PI + 1e-12) * around));
      farthest[sector] = std::max(farthest[sector], r), nearest[sector] = std::min(nearest[sector], r);
    }
    for (std::size_t i = 0; i < around; ++i) {
      EXPECT_LT(nearest[i], inner + 0.6e-3) << time;
      EXPECT_GE(farthest[i], 1e-3 * wall - 0.01e-3) << time;
    }
  }
}

TEST(AnnulusSkirt, motions_that_leave_the_tube_are_refused) {
  EXPECT_EQ(fault(0.8, 5), "");
  EXPECT_EQ(fault(1.05, 0), "") << "a quarter of a millimetre outside";
  EXPECT_NE(fault(1.2, 0).find("2.50 mm outside the wall"), std::string::npos) << fault(1.2, 0);
  EXPECT_NE(fault(1, -18.1).find("raise tube.length_ventricle"), std::string::npos) << fault(1, -18.1);
  EXPECT_NE(fault(1, 18.1).find("raise tube.length_atrium"), std::string::npos) << fault(1, 18.1);
}

TEST(AnnulusSkirt, two_cells_at_the_ends_suffice) {
  for (const double lift : {-18.0, -17.5, 17.5, 18.0}) EXPECT_EQ(fault(1, lift), "") << lift;
}

TEST(AnnulusSkirt, the_end_that_is_too_near_is_named) {
  Scene s = scene();
  s.tube.z_ventricle = -11;
  try {
    AnnulusSkirt(s, motion(s, 1, 5), "m.csv");
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("raise tube.length_ventricle"), std::string::npos) << e.what();
  }
}

TEST(AnnulusSkirt, the_wall_is_found_in_every_direction) {
  Tube tube;
  tube.cross_section = {{-10, -8}, {12, -8}, {12, 9}, {-10, 9}};
  EXPECT_NEAR(wall_distance(tube, Vec3(1, 0, 5)), 12e-3, 1e-12);
  EXPECT_NEAR(wall_distance(tube, Vec3(-1, 0, 5)), 10e-3, 1e-12);
  EXPECT_NEAR(wall_distance(tube, Vec3(0, -3, 5)), 8e-3, 1e-12);
  EXPECT_NEAR(wall_distance(tube, Vec3(1, 0.5, 0)), std::hypot(12, 6) * 1e-3, 1e-12);
}
