// SPDX-License-Identifier: GPL-3.0-or-later
// A spherical zone (a sphere between two parallel planes) of known thickness, area and volume, voxelised in many ways.
#include "geometry/image/label_surface.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdio>

#include "geometry/core/errors.h"
#include "geometry/image/mask_field.h"

using namespace mv;

namespace {

struct Zone {
  double radius = 15, half_height = 8, thickness = 2;  // mm
  double outer() const { return radius + thickness / 2; }
  double inner() const { return radius - thickness / 2; }
  double volume() const { return 2 * M_PI * half_height * (outer() * outer() - inner() * inner()); }
  double area() const { return 4 * M_PI * half_height * (outer() + inner()) + 2 * M_PI * (outer() * outer() - inner() * inner()); }
};

/// `axes`: voxel steps; the zone's own axis is `axis`, its centre the origin.
LabelledParts voxelised(const Zone& zone, const Mat3& axes, const Vec3& axis = Vec3::UnitZ()) {
  LabelImage image;
  image.axes = axes;
  const Vec3 sizes = axes.colwise().norm();
  for (std::size_t a = 0; a < 3; ++a) image.size[a] = 2 * static_cast<int>(std::ceil((zone.outer() + 1) / sizes[static_cast<Eigen::Index>(a)])) + 1;
  image.origin = -axes * Vec3((image.size[0] - 1) / 2.0 + 0.13, (image.size[1] - 1) / 2.0 - 0.21, (image.size[2] - 1) / 2.0 + 0.07);
  const Vec3 across = axis.unitOrthogonal();
  for (int k = 0; k < image.size[2]; ++k)
    for (int j = 0; j < image.size[1]; ++j)
      for (int i = 0; i < image.size[0]; ++i) {
        const Vec3 x = image.world(i, j, k);
        const bool is_inside = std::abs(x.norm() - zone.radius) <= zone.thickness / 2 && std::abs(x.dot(axis)) <= zone.half_height;
        image.values.push_back(!is_inside ? 0 : x.dot(across) > 0 ? 2 : 1);
      }
  return label_parts(image, label_preset("mvseg2023"), {}, "zone");
}

struct Fit {
  double distance_rms = 0, distance_max = 0;  // mm, of the points of both faces, away from the rims
  double angle_mean = 0;                      // degrees, between triangle normals and the sphere's
  double area = 0;                            // mm2, of the faces there
};

Fit fit(const LabelSurface& s, const Zone& zone, const Vec3& axis = Vec3::UnitZ(), double rim = 2) {
  Fit fit;
  double count = 0, area = 0;
  for (const Vec3& p : s.points) {
    if (std::abs(p.dot(axis)) > zone.half_height - rim) continue;
    const double d = std::min(std::abs(p.norm() - zone.outer()), std::abs(p.norm() - zone.inner()));
    fit.distance_rms += d * d, fit.distance_max = std::max(fit.distance_max, d), ++count;
  }
  for (const auto& t : s.triangles) {
    const Vec3 a = s.points[static_cast<std::size_t>(t[0])], b = s.points[static_cast<std::size_t>(t[1])], c = s.points[static_cast<std::size_t>(t[2])];
    const Vec3 middle = (a + b + c) / 3, n = (b - a).cross(c - a);
    if (std::abs(middle.dot(axis)) > zone.half_height - rim) continue;
    const double outwards = middle.norm() > zone.radius ? 1 : -1;
    fit.angle_mean += n.norm() * std::acos(std::clamp(outwards * n.normalized().dot(middle.normalized()), -1.0, 1.0)) * 180 / M_PI;
    area += n.norm();
  }
  fit.distance_rms = std::sqrt(fit.distance_rms / count);
  fit.angle_mean /= area;
  fit.area = area / 2;
  return fit;
}

bool is_closed(const LabelSurface& s) {
  std::vector<std::pair<int, int>> edges;
  for (const auto& t : s.triangles)
    for (std::size_t i = 0; i < 3; ++i) edges.emplace_back(t[i], t[(i + 1) % 3]);
  std::sort(edges.begin(), edges.end());
  if (std::adjacent_find(edges.begin(), edges.end()) != edges.end()) return false;
  return std::all_of(edges.begin(), edges.end(), [&](const auto& e) { return std::binary_search(edges.begin(), edges.end(), std::pair(e.second, e.first)); });
}

Mat3 tilted() { return (Eigen::AngleAxisd(0.5, Vec3(1, 2, 3).normalized())).toRotationMatrix(); }

void print(const char* what, const LabelSurface& s, const Zone& zone, const Fit& f) {
  std::printf("%s: volume %.1f (voxels %.1f, exact %.1f) area %.1f (exact %.1f) offset %.3f mm, faces off by %.3f rms %.3f max mm, %.2f deg, handles %d, %d iterations\n", what,
              s.volume, s.voxel_volume, zone.volume(), s.area, zone.area(), s.offset, f.distance_rms, f.distance_max, f.angle_mean, s.handles, s.iterations);
}

}  // namespace

TEST(LabelSurface, keeps_volume_area_and_thickness_of_a_spherical_zone) {
  const Zone zone;
  for (const auto& [what, axes] : std::vector<std::pair<const char*, Mat3>>{{"iso", 0.5 * Mat3::Identity()},
                                                                           {"oblique", 0.5 * tilted()},
                                                                           {"left-handed", tilted() * Vec3(0.5, 0.5, -0.5).asDiagonal()},
                                                                           {"anisotropic", tilted() * Vec3(0.4, 0.5, 0.7).asDiagonal()}}) {
    const auto s = label_surface(voxelised(zone, axes), {}, "zone");
    const Fit f = fit(s, zone);
    print(what, s, zone, f);
    EXPECT_NEAR(s.volume, s.voxel_volume, 0.002 * s.voxel_volume);
    EXPECT_NEAR(s.volume, zone.volume(), 0.02 * zone.volume());
    const double faces = 4 * M_PI * (zone.half_height - 2) * (zone.outer() + zone.inner());  // without the rims, whose sharp edges are rounded
    EXPECT_NEAR(f.area, faces, 0.02 * faces);
    EXPECT_LT(f.distance_rms, 0.08);
    EXPECT_LT(f.distance_max, 0.35);
    EXPECT_LT(f.angle_mean, 4);
    EXPECT_EQ(s.parts, 1);
    EXPECT_EQ(s.handles, 1);
    EXPECT_TRUE(is_closed(s));
  }
}

TEST(LabelSurface, smoothing_is_what_removes_the_steps) {
  const Zone zone;
  LabelSurfaceOptions stepped;
  stepped.smoothing = 0;
  const auto parts = voxelised(zone, 0.5 * Mat3::Identity());
  const Fit with = fit(label_surface(parts, {}, "zone"), zone), without = fit(label_surface(parts, stepped, "zone"), zone);
  std::printf("angle to the sphere: %.2f deg smooth, %.2f deg stepped\n", with.angle_mean, without.angle_mean);
  EXPECT_LT(with.angle_mean, 0.4 * without.angle_mean);
}

TEST(LabelSurface, slices_three_millimetres_apart_keep_one_ring) {
  const Zone zone{15, 9, 2};
  const Vec3 axis = tilted().col(2);
  const auto s = label_surface(voxelised(zone, tilted() * Vec3(0.7, 0.7, 3).asDiagonal(), axis), {}, "zone");
  const Fit f = fit(s, zone, axis, 3.5);
  print("0.7 x 0.7 x 3", s, zone, f);
  EXPECT_NEAR(s.volume, s.voxel_volume, 0.02 * s.voxel_volume);
  EXPECT_EQ(s.handles, 1);
  EXPECT_TRUE(is_closed(s));
  EXPECT_LT(f.distance_rms, 0.35);
}

TEST(LabelSurface, sheets_thinner_than_two_voxels_stay_whole) {
  for (const double thickness : {0.6, 0.9}) {
    const Zone zone{15, 8, thickness};
    const auto s = label_surface(voxelised(zone, 0.5 * tilted()), {}, "zone");
    const Fit f = fit(s, zone);
    print("thin", s, zone, f);
    EXPECT_EQ(s.parts, 1);
    EXPECT_EQ(s.handles, 1) << "holes through a thin sheet";
    EXPECT_NEAR(s.volume, zone.volume(), 0.03 * zone.volume());  // the voxels themselves are off by up to 1 %
    EXPECT_LT(f.distance_rms, 0.15);
  }
}

TEST(LabelSurface, triangles_carry_the_leaflet_of_the_nearest_voxel) {
  const Zone zone;
  const auto s = label_surface(voxelised(zone, 0.5 * Mat3::Identity()), {}, "zone");
  const Vec3 across = Vec3::UnitZ().unitOrthogonal();
  for (std::size_t t = 0; t < s.triangles.size(); ++t) {
    const double side = s.points[static_cast<std::size_t>(s.triangles[t][0])].dot(across);
    if (std::abs(side) < 0.8) continue;
    ASSERT_EQ(s.region[t], side > 0 ? Region::anterior : Region::posterior) << side;
  }
}

TEST(MaskField, a_punctured_plate_is_filled_and_a_gap_between_plates_is_not) {
  Mask mask{{24, 24, 16}, Vec3::Ones(), std::vector<char>(24 * 24 * 16, 0)};
  const auto at = [&](int i, int j, int k) -> char& { return mask.inside[static_cast<std::size_t>((k * 24 + j) * 24 + i)]; };
  for (int j = 4; j < 20; ++j)
    for (int i = 4; i < 20; ++i) at(i, j, 6) = at(i, j, 9) = 1;  // two plates, two voxels apart
  for (int j = 4; j < 20; ++j)
    for (int k = 6; k <= 9; ++k) at(4, j, k) = 1;  // joined at one side
  const auto sound = mask.inside;
  long set = 0;
  EXPECT_EQ(fill_holes(mask, 2, &set), 0);
  EXPECT_EQ(mask.inside, sound) << "the gap is no hole";
  at(10, 10, 6) = at(11, 10, 6) = at(15, 14, 9) = 0;
  EXPECT_EQ(fill_holes(mask, 2, &set), 2);
  EXPECT_GE(set, 3);
  EXPECT_TRUE(at(10, 10, 6) && at(11, 10, 6) && at(15, 14, 9));
  EXPECT_LE(std::count(mask.inside.begin(), mask.inside.end(), 1) - std::count(sound.begin(), sound.end(), 1), 4);
}

TEST(MaskField, voxels_that_touch_by_edge_or_corner_are_joined_by_faces) {
  Mask mask{{12, 12, 12}, Vec3::Ones(), std::vector<char>(12 * 12 * 12, 0)};
  const auto at = [&](int i, int j, int k) -> char& { return mask.inside[static_cast<std::size_t>((k * 12 + j) * 12 + i)]; };
  at(4, 4, 4) = at(5, 5, 4) = at(6, 6, 5) = 1;
  EXPECT_EQ(join_diagonals(mask), 3);
  EXPECT_EQ(std::count(mask.inside.begin(), mask.inside.end(), 1), 6);
  EXPECT_EQ(join_diagonals(mask), 0);
}
