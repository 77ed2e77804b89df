// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/image/slice_curves.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "geometry/core/errors.h"
#include "geometry/image/medial_path.h"
#include "geometry/loft/curve_surface.h"
#include "support/cone_valve.h"

using namespace mv;
using mv_test::ConeValve;
using mv_test::Noise;

namespace {

struct Quality {
  double mean = 0, most = 0, hinge = 0, tip = 0;
  int curves = 0;
};

/// Curves that run from annulus to free edge, where the slices cut the cone steeply enough for a thickness to be seen.
Quality quality(const ConeValve& cone, const CurveSet& set) {
  Quality q;
  double n = 0;
  for (const auto& c : set.curves) {
    if (c.end != CurveEnd::free_edge) continue;
    ++q.curves;
    for (const Vec3& p : c.points) {
      const double d = std::abs(cone.distance(p));
      q.mean += d, ++n;
      q.most = std::max(q.most, d);
    }
    q.hinge = std::max(q.hinge, std::abs(c.points.front().z()));
    q.tip = std::max(q.tip, std::abs(c.points.back().z() + cone.height));
  }
  q.mean /= n;
  return q;
}

CurveSurfaceOptions from_images() {
  CurveSurfaceOptions options;
  options.is_order_meant = false;
  return options;
}

double surface_error(const ConeValve& cone, const RawLeaflets& raw, double* area = nullptr) {
  double mean = 0;
  for (const Vec3& p : raw.points) mean += std::abs(cone.distance(p)) / static_cast<double>(raw.points.size());
  if (area) {
    *area = 0;
    for (const auto& t : raw.triangles) {
      const auto at = [&](std::size_t k) { return raw.points[static_cast<std::size_t>(t[k])]; };
      *area += 0.5 * (at(1) - at(0)).cross(at(2) - at(0)).norm();
    }
  }
  return mean;
}

void erase_where(std::vector<Slice>& slices, const std::function<bool(const Vec3&)>& rule) {
  for (Slice& s : slices)
    for (int j = 0; j < s.height; ++j)
      for (int i = 0; i < s.width; ++i) {
        auto& part = s.parts[static_cast<std::size_t>(j * s.width + i)];
        const auto p = static_cast<SlicePart>(part);
        if ((p == SlicePart::anterior || p == SlicePart::posterior || p == SlicePart::leaflet) && rule(s.world(i, j))) part = 0;
      }
}

bool any_note(const CurveSet& set, const std::string& part) {
  return std::any_of(set.notes.begin(), set.notes.end(), [&](const std::string& n) { return n.find(part) != std::string::npos; });
}

}  // namespace

TEST(MedialPath, follows_the_middle_of_a_strip_and_ends_on_its_border) {
  const int w = 200, h = 60;
  std::vector<std::uint8_t> inside(w * h, 0);
  for (int j = 20; j < 40; ++j)
    for (int i = 10; i < 190; ++i) inside[static_cast<std::size_t>(j * w + i)] = 1;
  const MaskPaths paths(w, h, inside);
  EXPECT_NEAR(paths.depth(30 * w + 100), 10, 0.01);
  const int tip = 39 * w + 189;  // a corner, as the farthest point is
  std::vector<Vec2> path;
  for (const int c : paths.middle_path(30 * w + 10, tip)) path.push_back(paths.position(c));
  const auto extended = paths.extended_end(path);
  EXPECT_NEAR(extended.back().x(), 189, 1.1);
  EXPECT_NEAR(extended.back().y(), 29.5, 2.5);
  for (const Vec2& p : extended) EXPECT_NEAR(p.y(), 29.5, 3) << p.x();
}

TEST(SliceCurves, lie_in_the_middle_of_the_masks_from_annulus_to_free_edge) {
  const ConeValve cone;
  const CurveSet set = curves_of_slices(cone.slices(3, 0.7));
  const Quality q = quality(cone, set);
  std::printf("%d curves, off by %.3f mm mean, %.3f mm max; hinge %.2f mm, tip %.2f mm\n", q.curves, q.mean, q.most, q.hinge, q.tip);
  EXPECT_GE(q.curves, 10);
  EXPECT_LT(q.mean, 0.2);
  EXPECT_LT(q.most, 0.9);
  EXPECT_LT(q.hinge, 0.8);
  EXPECT_LT(q.tip, 0.8);
  EXPECT_EQ(set.papillary_clouds.size(), 2u);
  EXPECT_NEAR(set.resolution, 0.7, 1e-9);
  EXPECT_GE(set.empty_slices.size(), 1u);
}

TEST(SliceCurves, surface_area_and_thickness_of_the_cone_come_back) {
  const ConeValve cone;
  CurveSurfaceReport report;
  const RawLeaflets raw = surface_from_curves(curves_of_slices(cone.slices(3, 0.7)), from_images(), &report);
  double area = 0;
  const double error = surface_error(cone, raw, &area);
  double thickness = 0;
  for (const double t : raw.thickness) thickness += t / static_cast<double>(raw.thickness.size());
  std::printf("surface off by %.3f mm; area %.0f mm2 (%.0f); thickness %.2f mm (%.2f); deviation %.2f %.2f %.2f\n", error, area, cone.area(), thickness, cone.thickness, report.deviation_mean,
              report.deviation_95, report.deviation_max);
  EXPECT_LT(error, 0.2);
  EXPECT_NEAR(area / cone.area(), 1, 0.07);
  EXPECT_NEAR(thickness, cone.thickness, 0.25);
  ASSERT_EQ(raw.papillary_points.size(), 2u);
  EXPECT_NEAR(raw.papillary_points[0].z(), -25.5, 1.2);
}

TEST(SliceCurves, gaps_are_closed_and_flecks_left_out) {
  const ConeValve cone;
  auto slices = cone.slices(3, 0.7);
  // Where the slices cut across the leaflet; in an arch such a gap would take away its top, and nobody could tell that from a commissure.
  erase_where(slices, [](const Vec3& p) { return std::abs(p.z() + 7) < 0.9 && std::abs(p.x()) < 8; });
  Noise random(5);
  for (Slice& s : slices)
    for (int k = 0; k < 4; ++k) {
      const int i = static_cast<int>((0.5 + 0.45 * random()) * s.width), j = static_cast<int>((0.6 + 0.3 * random()) * s.height);
      auto& part = s.parts[static_cast<std::size_t>(j * s.width + i)];
      if (part == 0) part = static_cast<std::uint8_t>(SlicePart::anterior);
    }
  const CurveSet set = curves_of_slices(slices);
  const Quality q = quality(cone, set);
  std::printf("%d curves, off by %.3f mm mean, %.3f mm max; hinge %.2f mm, tip %.2f mm\n", q.curves, q.mean, q.most, q.hinge, q.tip);
  EXPECT_TRUE(any_note(set, "gap"));
  EXPECT_TRUE(any_note(set, "island"));
  EXPECT_LT(q.hinge, 0.8);
  EXPECT_LT(q.mean, 0.25);
  EXPECT_LT(surface_error(cone, surface_from_curves(set, from_images())), 0.25);
}

TEST(SliceCurves, ragged_masks_give_smooth_curves) {
  const ConeValve cone{16, 9, 14, 2.2};
  auto slices = cone.slices(3, 0.7);
  Noise random(9);
  // Every pixel of the outer layers is dropped with probability 0.3.
  erase_where(slices, [&](const Vec3& p) { return std::abs(cone.distance(p)) > 0.5 && random() > 0.4; });
  const CurveSet set = curves_of_slices(slices);
  EXPECT_LT(quality(cone, set).mean, 0.3);
  EXPECT_LT(surface_error(cone, surface_from_curves(set, from_images())), 0.25);
}

TEST(SliceCurves, a_mask_without_names_and_walls_is_told_apart_by_geometry) {
  // The anterior side is longer: a cone cut off at a slant.
  const ConeValve cone;
  auto slices = cone.slices(3, 0.7, false, false);
  erase_where(slices, [](const Vec3& p) { return p.y() < 0 && p.z() < -10; });
  CurveSurfaceReport report;
  const RawLeaflets raw = surface_from_curves(curves_of_slices(slices), from_images(), &report);
  EXPECT_LT(surface_error(cone, raw), 0.3);
  EXPECT_LT(raw.ventricle_direction->z(), -0.95);
  double anterior_y = 0, posterior_y = 0;
  for (std::size_t t = 0; t < raw.triangles.size(); ++t) (raw.region[t] == anterior ? anterior_y : posterior_y) += raw.points[static_cast<std::size_t>(raw.triangles[t][0])].y();
  EXPECT_GT(anterior_y, 0);
  EXPECT_LT(posterior_y, 0);
}

TEST(SliceCurves, leaflets_that_touch_in_the_middle_slices_coapt) {
  // A steep funnel whose free edges meet.
  const ConeValve cone{14, 0.5, 12, 1.4};
  CurveSurfaceReport report;
  const CurveSet set = curves_of_slices(cone.slices(2, 0.5));
  int open_in_the_middle = 0;
  for (const auto& c : set.curves)
    if (std::abs(c.points.front().x()) < 1.5 && c.end == CurveEnd::free_edge) ++open_in_the_middle;
  EXPECT_GE(open_in_the_middle, 2);
}

TEST(SliceCurves, a_leaflet_cut_twice_gives_two_curves) {
  // Slices y = const through the posterior half: each cuts the posterior leaflet at both sides.
  const ConeValve cone;
  std::vector<Slice> slices = cone.slices(3, 0.7);
  const int w = slices[0].width;
  for (std::size_t k = 0; k < slices.size(); ++k) {
    Slice& s = slices[k];
    const double y = s.origin.x();
    s.origin = {-0.5 * (w - 1) * 0.7, y, 6};
    s.step_x = {0.7, 0, 0};
    for (int j = 0; j < s.height; ++j)
      for (int i = 0; i < s.width; ++i) {
        const Vec3 p = s.world(i, j);
        const double r = std::hypot(p.x(), p.y());
        SlicePart part = SlicePart::none;
        if (p.z() <= 0 && p.z() >= -cone.height && std::abs(cone.distance(p)) <= 0.5 * cone.thickness) part = p.y() > 0 ? SlicePart::anterior : SlicePart::posterior;
        else if (p.z() > 0 && p.z() < 4 && r > cone.annulus - 1.5 && r < cone.annulus + 3) part = SlicePart::atrium;
        s.parts[static_cast<std::size_t>(j * s.width + i)] = static_cast<std::uint8_t>(part);
      }
  }
  const CurveSet set = curves_of_slices(slices);
  EXPECT_TRUE(any_note(set, "leaflet 2 times"));
  EXPECT_LT(quality(cone, set).mean, 0.25);
  EXPECT_LT(surface_error(cone, surface_from_curves(set, from_images())), 0.3);
}

TEST(SliceCurves, empty_single_and_doubled_slices_are_refused_and_disorder_is_sorted) {
  const ConeValve cone;
  auto slices = cone.slices(3, 0.7);
  auto empty = slices;
  erase_where(empty, [](const Vec3&) { return true; });
  EXPECT_THROW(curves_of_slices(empty), InputError);
  EXPECT_THROW(curves_of_slices({slices[6]}), InputError);
  auto doubled = slices;
  doubled.push_back(slices[5]);
  EXPECT_THROW(curves_of_slices(doubled), InputError);
  auto mixed = slices;
  std::swap(mixed[3], mixed[8]);
  const CurveSet set = curves_of_slices(mixed), ordered = curves_of_slices(slices);
  EXPECT_TRUE(any_note(set, "sorted"));
  ASSERT_EQ(set.curves.size(), ordered.curves.size());
  for (std::size_t i = 0; i < set.curves.size(); ++i) EXPECT_EQ(set.curves[i].points, ordered.curves[i].points);
}
