// SPDX-License-Identifier: GPL-3.0-or-later
// A valve whose annulus, commissures, muscles and direction are known, in several poses on several voxels.
#include "geometry/image/label_landmarks.h"

#include <gtest/gtest.h>

#include "geometry/core/errors.h"
#include "geometry/image/nifti.h"
#include "geometry/image/papillary_heads.h"
#include "support/label_valve.h"
#include "unit/core/sample_case.h"

using namespace mv;
using mv::test::LabelValve;
using mv::test::NiftiFile;

namespace {

LabelledParts parts_of(const NiftiFile& f, LabelTable table = label_preset("visible_human")) {
  const mv_test::TemporaryDirectory dir;
  test::write_nifti(dir / "valve.nii", f);
  return label_parts(read_nifti_labels(dir / "valve.nii").image, table, {}, "valve");
}

double distance_to_annulus(const LabelValve& valve, const Vec3& x) {
  double nearest = 1e300;
  for (int n = 0; n < 3600; ++n) nearest = std::min(nearest, (valve.annulus_at(2 * M_PI * n / 3600) - x).norm());
  return nearest;
}

}  // namespace

TEST(LabelLandmarks, of_a_tilted_ellipse_valve_are_where_they_were_put) {
  LabelValve valve;
  valve.turn = Eigen::AngleAxisd(0.7, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  valve.centre = Vec3(120, -35, 60);
  const Mat3 voxel_turn = Eigen::AngleAxisd(0.4, Vec3(0, 1, 1).normalized()).toRotationMatrix();
  for (const Vec3& size : {Vec3(0.7, 0.7, 0.7), Vec3(0.6, 0.8, 1.2), Vec3(-0.8, 0.7, 0.7)}) {
    const auto parts = parts_of(valve.voxels(size, voxel_turn));
    const auto marks = find_landmarks(parts, {}, "valve");
    for (const auto& note : marks.notes) std::printf("note: %s\n", note.c_str());
    const double diagonal = size.norm();
    ASSERT_FALSE(marks.annulus_curve.empty());
    double worst = 0, mean = 0;
    for (const Vec3& p : marks.annulus_curve) {
      const double d = distance_to_annulus(valve, p);
      worst = std::max(worst, d), mean += d / static_cast<double>(marks.annulus_curve.size());
    }
    std::printf("voxels %.1f x %.1f x %.1f: annulus off by %.2f mm mean, %.2f max, hinge %.0f %%\n", size[0], size[1], size[2], mean, worst, 100 * marks.hinge_share);
    EXPECT_LT(mean, 0.8 * diagonal);
    EXPECT_LT(worst, 1.5 * diagonal);
    EXPECT_GT(marks.hinge_share, 0.9);

    ASSERT_TRUE(marks.ventricle_direction);
    EXPECT_GT(marks.ventricle_direction->dot(valve.turn * -Vec3::UnitZ()), 0.9);
    ASSERT_EQ(marks.papillary_points.size(), 2u);
    EXPECT_EQ(marks.papillary_names, (std::vector<std::string>{"anterolateral", "posteromedial"}));
    EXPECT_LT((marks.papillary_points[0] - valve.tip(-1)).norm(), 1.3);
    EXPECT_LT((marks.papillary_points[1] - valve.tip(1)).norm(), 1.3);
    ASSERT_EQ(marks.commissures.size(), 2u);
    double nearest_right = 1e300, nearest_left = 1e300;
    for (const Vec3& c : marks.commissures) {
      nearest_right = std::min(nearest_right, (c - valve.annulus_at(0)).norm());
      nearest_left = std::min(nearest_left, (c - valve.annulus_at(M_PI)).norm());
    }
    EXPECT_LT(nearest_right, 2.5 * diagonal);
    EXPECT_LT(nearest_left, 2.5 * diagonal);
  }
}

TEST(LabelLandmarks, without_walls_the_annulus_is_left_to_the_border) {
  LabelValve valve;
  valve.has_walls = false;
  const auto marks = find_landmarks(parts_of(valve.voxels(Vec3(0.8, 0.8, 0.8))), {}, "valve");
  EXPECT_TRUE(marks.annulus_curve.empty());
  EXPECT_EQ(marks.direction_rule, "from leaflets to papillary labels");
  EXPECT_NE(marks.notes.at(0).find("own border"), std::string::npos);
  valve.has_muscles = false;
  const auto bare = find_landmarks(parts_of(valve.voxels(Vec3(0.8, 0.8, 0.8))), {}, "valve");
  EXPECT_FALSE(bare.ventricle_direction);
  EXPECT_TRUE(bare.papillary_points.empty());
}

TEST(LabelLandmarks, muscles_above_the_annulus_are_refused) {
  LabelTable table = label_preset("visible_human");
  std::swap(table.atrium, table.ventricle);
  const auto parts = parts_of(LabelValve().voxels(Vec3(0.8, 0.8, 0.8)), table);
  EXPECT_THROW(
      {
        try {
          find_landmarks(parts, {}, "valve");
        } catch (const InputError& e) {
          EXPECT_NE(std::string(e.what()).find("labels.atrium"), std::string::npos) << e.what();
          throw;
        }
      },
      InputError);
}

TEST(PapillaryHeads, a_forked_muscle_has_two_and_a_blunt_one_has_one) {
  LabelImage image;
  image.size = {60, 40, 80};
  image.axes = 0.5 * Mat3::Identity();
  image.values.assign(60 * 40 * 80, 0);
  const auto fill = [&](double cx, double radius, double low, double high) {
    for (int k = 0; k < 80; ++k)
      for (int j = 0; j < 40; ++j)
        for (int i = 0; i < 60; ++i) {
          const Vec3 x = image.world(i, j, k);
          if (std::hypot(x.x() - cx, x.y() - 10) <= radius && x.z() >= low && x.z() <= high) image.values[image.index(i, j, k)] = static_cast<int>(Part::papillary);
        }
  };
  fill(15, 6, 2, 15);   // the trunk
  fill(11, 2, 15, 26);  // its heads
  fill(19, 2, 15, 22);
  const Vec3 valve(15, 10, 60);
  const auto heads = papillary_heads(image, Part::papillary, valve, 3, 1);
  ASSERT_EQ(heads.size(), 2u);
  EXPECT_LT((heads[0].tip - Vec3(11, 10, 25.5)).norm(), 0.8);
  EXPECT_LT((heads[1].tip - Vec3(19, 10, 21.5)).norm(), 0.8);
  EXPECT_NEAR(heads[1].prominence, 7, 0.8);
  EXPECT_EQ(papillary_heads(image, Part::papillary, valve, 8, 1).size(), 1u);
}
