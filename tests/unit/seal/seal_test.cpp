// SPDX-License-Identifier: BSD-3-Clause
// Verdict and smallest sealing threshold on solids whose gaps are known.

#include "solver/seal/seal.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "geometry/core/errors.h"
#include "unit/seal/seal_shapes.h"

namespace mv {
namespace {

using namespace test;
constexpr double pi = std::numbers::pi;

Map3 tilt(double degrees, const Vec3& shift = Vec3::Zero()) {
  const double slope = std::tan(degrees * pi / 180);
  return [=](const Vec3& p) { return Vec3(p + Vec3(0, 0, slope * p.x() + 0.3 * slope * p.y()) + shift); };
}
auto tilted_annulus(double degrees, double dz = 0) {
  const double slope = std::tan(degrees * pi / 180);
  return [=](const Vec2& p) { return slope * p.x() + 0.3 * slope * p.y() + dz; };
}

TEST(Seal, closed_membrane_seals_at_any_threshold_and_has_no_hole) {
  for (double degrees : {0.0, 20.0, 40.0})
    for (double shift : {0.0, 0.07, 0.21}) {
      const Solid disc = ring_plate(0, 10.2, 1.0, {0, 0}, tilt(degrees, {0, 0, shift}));
      const SealResult r = find_seal(in_tube(disc, circle(10), tilted_annulus(degrees, shift)), 0.05);
      EXPECT_TRUE(r.sealed) << degrees << " " << shift;
      EXPECT_TRUE(r.certain);
      EXPECT_TRUE(r.holes.empty());
      EXPECT_EQ(r.smallest.value_mm, 0) << degrees << " " << shift;
    }
}

TEST(Seal, without_leaflets_nothing_is_sealed) {
  const SealResult r = find_seal(in_tube({}, circle(10)), 1.5);
  EXPECT_FALSE(r.sealed);
  EXPECT_EQ(r.smallest.value_mm, std::numeric_limits<double>::infinity());
  ASSERT_EQ(r.holes.size(), 1u);
  EXPECT_NEAR(r.hole_area_mm2, 100 * pi, 0.05 * 100 * pi);
}

TEST(Seal, smallest_threshold_of_a_round_hole_is_its_diameter) {
  for (double degrees : {0.0, 30.0})
    for (double shift : {0.0, 0.06, 0.19}) {
      const Solid disc = ring_plate(1.5, 10.2, 1.0, {2 + shift, 1 - 0.5 * shift}, tilt(degrees, {0, 0, shift}));
      const SealInput in = in_tube(disc, circle(10), tilted_annulus(degrees, shift));
      const SealingThreshold s = smallest_sealing_threshold(in);
      // Vertical shear keeps the hole's plan but narrows its waist across the slope by cos(angle of the steepest line).
      const double slope = std::tan(degrees * pi / 180) * std::hypot(1.0, 0.3);
      if (degrees == 0) {
        EXPECT_NEAR(s.value_mm, 3.0, 0.06) << shift;
      }
      EXPECT_LE(s.value_mm, 3.06);
      EXPECT_GE(s.value_mm, 3.0 / std::hypot(1.0, slope) - 0.06);
      EXPECT_LE(s.lower_mm, s.value_mm);
      EXPECT_GT(s.lower_mm, s.value_mm - 0.13) << degrees << " " << shift;
      if (shift == 0.06) {
        EXPECT_TRUE(find_seal(in, s.value_mm + 0.01).sealed);
      }
    }
}

TEST(Seal, smallest_threshold_of_two_leaflets_is_their_gap) {
  for (double gap : {0.1, 0.3, 1.0})
    for (double slope : {0.0, 0.3, 1.0})
      for (double offset : {0.0, 0.05, 0.17}) {
        const double expected = gap / std::hypot(1.0, slope);
        const SealInput in = two_leaflets(gap, slope, offset);
        const SealingThreshold s = smallest_sealing_threshold(in);
        EXPECT_NEAR(s.value_mm, expected, 0.03) << gap << " " << slope << " " << offset;
        EXPECT_LE(s.lower_mm, s.value_mm);
        EXPECT_GT(s.lower_mm, expected - 0.06) << gap << " " << slope << " " << offset;
      }
}

TEST(Seal, verdict_changes_at_the_gap) {
  const SealInput in = two_leaflets(0.6, 0.2, 0.03);
  const double gap = 0.6 / std::hypot(1.0, 0.2);
  EXPECT_FALSE(find_seal(in, gap - 0.05).sealed);
  EXPECT_TRUE(find_seal(in, gap + 0.05).sealed);
}

TEST(Seal, leaflets_pressed_into_each_other_seal_at_any_threshold) {
  const SealResult r = find_seal(two_leaflets(-0.2), 0.05);
  EXPECT_TRUE(r.sealed);
  EXPECT_EQ(r.smallest.value_mm, 0);
}

TEST(Seal, gap_of_an_eighth_of_a_voxel_is_seen) {
  const SealingThreshold s = smallest_sealing_threshold(two_leaflets(0.03, 0.0, 0.04));
  EXPECT_NEAR(s.value_mm, 0.03, 0.01);
}

TEST(Seal, slit_between_attached_rim_and_wall_is_no_hole) {
  // The annulus curve runs on the rim of a disc that ends half a millimetre before the wall.
  const Solid disc = ring_plate(0, 9.5, 1.0);
  SealInput in = in_tube(disc, circle(10));
  for (Vec3& p : in.annulus) p.head<2>() *= 9.5 / 10;
  EXPECT_TRUE(find_seal(in, 0.2).sealed);
  // The same disc away from the annulus is not attached: the slit is a hole. The wall is rigid, so it closes at twice its width.
  for (Vec3& p : in.annulus) p.z() += 6;
  const SealResult loose = find_seal(in, 0.2);
  EXPECT_FALSE(loose.sealed);
  EXPECT_NEAR(loose.smallest.value_mm, 1.0, 0.3);
}

TEST(Seal, hole_next_to_the_ring_is_still_seen) {
  const Solid disc = ring_plate(1.0, 10.2, 1.0, {7.0, 0});
  const SealResult r = find_seal(in_tube(disc, circle(10)), 0.5);
  ASSERT_EQ(r.holes.size(), 1u);
  EXPECT_NEAR(r.hole_area_mm2, pi, 0.15 * pi);
}

TEST(Seal, thin_walls_down_to_the_stated_limit_do_not_leak) {
  for (double degrees : {0.0, 45.0})
    for (double shift : {0.0, 0.1}) {
      const double thickness =
          0.6 * std::hypot(1.0, std::tan(degrees * pi / 180) * std::hypot(1.0, 0.3));  // sheared plate: 0.6 along its normal
      const Solid disc = ring_plate(0, 10.2, thickness, {0, 0}, tilt(degrees, {0, 0, shift}));
      EXPECT_TRUE(find_seal(in_tube(disc, circle(10), tilted_annulus(degrees, shift)), 0.05).sealed) << degrees;
    }
}

TEST(Seal, answer_does_not_depend_on_the_frame) {
  const Solid disc = ring_plate(1.2, 10.2, 1.0, {2.3, -1.1}, tilt(15));
  const SealInput in = in_tube(disc, circle(10), tilted_annulus(15));
  const Mat3 rotation = (Eigen::AngleAxisd(0.7, Vec3(1, 2, -0.5).normalized())).toRotationMatrix();
  const Vec3 shift(31.3, -8.7, 102.9);
  const SealResult a = find_seal(in, 0.6), b = find_seal(moved(in, rotation, shift), 0.6);
  EXPECT_EQ(a.sealed, b.sealed);
  EXPECT_NEAR(a.smallest.value_mm, b.smallest.value_mm, 1e-3);
  ASSERT_EQ(a.holes.size(), b.holes.size());
  EXPECT_NEAR(a.hole_area_mm2, b.hole_area_mm2, 0.01 * a.hole_area_mm2);
  EXPECT_LT((rotation * a.holes[0].place + shift - b.holes[0].place).norm(), 0.05);
}

TEST(Seal, orientation_of_the_surface_does_not_matter) {
  SealInput in = two_leaflets(0.4);
  const double outward = smallest_sealing_threshold(in).value_mm;
  for (auto& t : in.triangles) std::swap(t[0], t[1]);
  EXPECT_EQ(smallest_sealing_threshold(in).value_mm, outward);
}

TEST(Seal, defective_input_is_refused) {
  const SealInput good = two_leaflets(0.4);
  SealInput bad = good;
  bad.triangles.pop_back();
  EXPECT_THROW(find_seal(bad, 0.5), InputError);
  bad = good;
  bad.points[3].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(find_seal(bad, 0.5), InputError);
  bad = good;
  bad.triangles[0][0] = 100000;
  EXPECT_THROW(find_seal(bad, 0.5), InputError);
  bad = good;
  bad.tube.cross_section.clear();
  EXPECT_THROW(find_seal(bad, 0.5), InputError);
  bad = good;
  bad.annulus.resize(2);
  EXPECT_THROW(find_seal(bad, 0.5), InputError);
  EXPECT_THROW(find_seal(good, 0.0), InputError);
}

}  // namespace
}  // namespace mv
