// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/surface/leaflet_surface.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "geometry/chordae/leaflet_chart.h"
#include "geometry/core/errors.h"
#include "geometry/surface/self_intersection.h"
#include "geometry/volume/gates.h"
#include "geometry/volume/leaflet_tets.h"
#include "unit/unfold/shapes.h"

namespace {

using mv::Vec2;
using mv::Vec3;
using namespace mv_test;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

mv::LeafletSurfaceOptions coarse() {
  mv::LeafletSurfaceOptions o;
  o.spacing = 1.0;
  return o;
}

/// What every result must satisfy, whatever the input was.
void expect_valid(const mv::LeafletSurface& r, double spacing) {
  const mv::MidSurface& s = r.surface;
  ASSERT_EQ(s.unfolded.size(), s.points.size());
  for (std::size_t i = 0; i < s.points.size(); ++i) {
    EXPECT_NEAR(s.normals[i].norm(), 1, 1e-9);
    EXPECT_GE(s.unfolded[i].x(), 0);
    EXPECT_LT(s.unfolded[i].x(), s.perimeter);
    EXPECT_EQ(s.on_annulus[i] != 0, s.unfolded[i].y() == 0) << i;
  }
  for (std::size_t t = 0; t < s.triangles.size(); ++t) {
    const auto p = mv::unfolded_triangle(s, static_cast<int>(t));
    const Vec2 a = p[1] - p[0], b = p[2] - p[0];
    EXPECT_GT(a.x() * b.y() - a.y() * b.x(), 0) << "the pattern folds at triangle " << t;
    const auto& tri = s.triangles[t];
    const Vec3 n = (s.points[at(tri[1])] - s.points[at(tri[0])]).cross(s.points[at(tri[2])] - s.points[at(tri[0])]);
    EXPECT_GT(n.dot(s.normals[at(tri[0])]), 0);
  }
  const mv::LeafletMesh mesh = mv::thicken(s, {1.0, 2, 1});
  for (const mv::Gate& g : {mv::gate_boundary(mesh), mv::gate_volumes(mesh), mv::gate_dihedral_min(mesh, 10), mv::gate_dihedral_max(mesh, 170),
                            mv::gate_layers(mesh, 2), mv::gate_self_intersection(mesh), mv::gate_spacing(mesh, 2 * spacing, 1.0)})
    EXPECT_TRUE(g.passed) << g.name << ": " << g.message;
  const mv::LeafletChart chart(mesh);
  EXPECT_NEAR(chart.period(), s.perimeter, 0.02 * s.perimeter);
  EXPECT_GE(chart.junctions().size(), 2u);
}

std::string message_of(const mv::RawLeaflets& raw) {
  try {
    mv::build_leaflet_surface(raw, coarse());
  } catch (const mv::InputError& e) {
    return e.what();
  }
  return "no error";
}

TEST(LeafletSurface, cylinder_unfolds_to_a_rectangle_of_its_size) {
  mv::RawLeaflets raw = cylinder(15, 12);
  raw.anterior_hint = Vec3(0, 40, 5);
  raw.ventricle_direction = Vec3(0.1, 0, -2);
  const mv::LeafletSurface r = mv::build_leaflet_surface(raw, coarse());
  expect_valid(r, 1.0);
  const double perimeter = 2 * std::numbers::pi * 15;
  EXPECT_NEAR(r.surface.perimeter, perimeter, 0.002 * perimeter);
  EXPECT_NEAR(r.report.area_anterior + r.report.area_posterior, perimeter * 12, 0.01 * perimeter * 12);
  EXPECT_NEAR(r.report.area_anterior / (perimeter * 12), 0.36, 0.01);
  EXPECT_NEAR((r.annulus.normal - Vec3(0, 0, -1)).norm(), 0, 0.01);
  EXPECT_NEAR((r.anterior_direction - Vec3(0, 1, 0)).norm(), 0, 0.02);
  EXPECT_LT(r.report.area_distortion_max, 1.06);
  double worst = 0;
  for (std::size_t i = 0; i < r.surface.points.size(); ++i) {
    worst = std::max(worst, std::abs(-r.surface.points[i].z() - r.surface.unfolded[i].y()));
    EXPECT_NEAR(r.surface.points[i].head<2>().norm(), 15, 0.08);
    EXPECT_LT(r.surface.normals[i].dot(Vec3(r.surface.points[i].x(), r.surface.points[i].y(), 0)), 0) << "towards the axis";
  }
  std::printf("cylinder: v against depth %.3f mm, distortion %.3f, perimeter %.3f of %.3f mm\n", worst, r.report.area_distortion_max,
              r.surface.perimeter, perimeter);
  EXPECT_LT(worst, 0.15);
}

TEST(LeafletSurface, cone_has_its_slant_height_as_v) {
  // Frustum of radii 18 and 10 over a depth of 12 mm: slant sqrt(64 + 144) = 14.42 mm.
  mv::RawLeaflets raw = ring([](double phi, double t) {
    const double r = 18 - 8 * t;
    return Vec3(-r * std::sin(phi), r * std::cos(phi), -12 * t);
  });
  raw.anterior_hint = Vec3(0, 40, 0);
  const mv::LeafletSurface r = mv::build_leaflet_surface(raw, coarse());
  expect_valid(r, 1.0);
  double lowest = 1e300, highest = 0;
  for (std::size_t i = 0; i < r.surface.points.size(); ++i)
    if (r.surface.on_free_edge[i]) {
      lowest = std::min(lowest, r.surface.unfolded[i].y());
      highest = std::max(highest, r.surface.unfolded[i].y());
    }
  std::printf("cone: free edge at v = %.3f to %.3f mm, slant 14.422\n", lowest, highest);
  EXPECT_NEAR(lowest, std::sqrt(208.0), 0.15);
  EXPECT_NEAR(highest, std::sqrt(208.0), 0.15);
}

TEST(LeafletSurface, generic_valve_comes_back_wherever_it_lies) {
  mv::RawLeaflets raw = generic_raw();
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.rotate(Eigen::AngleAxisd(2.1, Vec3(1, 2, -0.5).normalized())).pretranslate(Vec3(-31, 12, 140));
  transform(raw, motion);
  raw.region.clear();
  mv::LeafletSurfaceOptions options;
  options.spacing = 0.5;
  const mv::LeafletSurface r = mv::build_leaflet_surface(raw, options);
  expect_valid(r, 0.5);
  const mv::GenericValve truth = mv::build_generic_valve(mv::GenericValveParameters{}, 1.5);
  std::printf("generic: %s; moved %.3f mm mean, %.3f max; perimeter %.2f (107.2); anterior %.1f, posterior %.1f mm2\n", r.report.region_rule.c_str(),
              r.report.surface_moved_mean, r.report.surface_moved_max, r.surface.perimeter, r.report.area_anterior, r.report.area_posterior);
  EXPECT_LT((r.annulus.normal - motion.linear() * Vec3(0, 0, -1)).norm(), 0.01);
  EXPECT_LT((r.anterior_direction - motion.linear() * Vec3(0, 1, 0)).norm(), 0.05);
  EXPECT_NEAR(r.surface.perimeter, 107.2, 0.5);
  EXPECT_LT(r.report.surface_moved_mean, 0.1);
  // Areas of the known leaflets.
  std::array<double, 3> area{};
  const mv::MidSurface& s = truth.mid_surface;
  for (std::size_t t = 0; t < s.triangles.size(); ++t)
    area[at(s.region[t])] += 0.5 * (s.points[at(s.triangles[t][1])] - s.points[at(s.triangles[t][0])])
                                       .cross(s.points[at(s.triangles[t][2])] - s.points[at(s.triangles[t][0])])
                                       .norm();
  EXPECT_NEAR(r.report.area_anterior, area[mv::anterior], 0.03 * area[mv::anterior]);
  EXPECT_NEAR(r.report.area_posterior, area[mv::posterior], 0.03 * area[mv::posterior]);
  const mv::LeafletChart chart(mv::thicken(r.surface, {1.0, 2, 1}));
  EXPECT_EQ(chart.junctions().size(), 4u) << "two commissures and two notches";
}

TEST(LeafletSurface, noise_of_voxel_size_goes_and_the_size_stays) {
  mv::RawLeaflets raw = generic_raw(0.8);
  const mv::RawLeaflets clean = raw;
  add_noise(raw, 0.25);
  const mv::LeafletSurface a = mv::build_leaflet_surface(clean, coarse()), b = mv::build_leaflet_surface(raw, coarse());
  expect_valid(b, 1.0);
  std::printf("noise 0.25 mm: area %.1f against %.1f mm2 without, annulus %.2f against %.2f mm, moved %.3f mm\n",
              b.report.area_anterior + b.report.area_posterior, a.report.area_anterior + a.report.area_posterior, b.surface.perimeter,
              a.surface.perimeter, b.report.surface_moved_mean);
  const double area = a.report.area_anterior + a.report.area_posterior;
  EXPECT_NEAR(b.report.area_anterior + b.report.area_posterior, area, 0.03 * area);
  EXPECT_NEAR(b.surface.perimeter, a.surface.perimeter, 0.03 * a.surface.perimeter);
}

TEST(LeafletSurface, swapped_labels_are_named_and_corrected) {
  mv::RawLeaflets raw = generic_raw();
  raw.anterior_hint = Vec3(0, 40, 10);
  const mv::LeafletSurface right = mv::build_leaflet_surface(raw, coarse());
  EXPECT_FALSE(says(right.report.notes, "swapped"));
  for (int& label : raw.region) label = 3 - label;
  const mv::LeafletSurface corrected = mv::build_leaflet_surface(raw, coarse());
  EXPECT_TRUE(says(corrected.report.notes, "swapped"));
  EXPECT_NEAR(corrected.report.area_anterior, right.report.area_anterior, 1e-6);
}

TEST(LeafletSurface, labels_that_shape_and_papillary_muscles_support_outweigh_a_wrong_anterior_point) {
  mv::RawLeaflets raw = generic_raw();
  const mv::LeafletSurface right = mv::build_leaflet_surface(raw, coarse());
  raw.anterior_hint = Vec3(0, -40, 10);  // behind the posterior leaflet
  const mv::LeafletSurface r = mv::build_leaflet_surface(raw, coarse());
  EXPECT_TRUE(says(r.report.notes, "labels are kept"));
  EXPECT_NEAR(r.report.area_anterior, right.report.area_anterior, 1e-6);
}

TEST(LeafletSurface, separate_leaflets_are_joined_over_a_small_gap_only) {
  for (double gap : {1.5, 9.0}) {
    mv::RawLeaflets raw = generic_raw(1.0);
    // The commissures of the default valve lie at u = 0 and 36 of 107.2 mm; a slot of the given width is cut there from annulus to edge.
    const mv::GenericValve valve = mv::build_generic_valve(mv::GenericValveParameters{}, 1.0);
    std::size_t t = 0;
    remove_if(raw, [&](const Vec3&, int) {
      const auto p = mv::unfolded_triangle(valve.mid_surface, static_cast<int>(t++));
      const double u = (p[0].x() + p[1].x() + p[2].x()) / 3, from_first = std::min(u, valve.mid_surface.perimeter - u);
      return std::min(from_first, std::abs(u - 36)) < 0.5 * gap;
    });
    raw.region.clear();
    if (gap > 5) {
      EXPECT_NE(message_of(raw).find("apart at the commissure"), std::string::npos) << message_of(raw);
      continue;
    }
    const mv::LeafletSurface r = mv::build_leaflet_surface(raw, coarse());
    expect_valid(r, 1.0);
    EXPECT_TRUE(says(r.report.notes, "joined over a gap"));
    EXPECT_NEAR(r.surface.perimeter, 107.2, 1.5);
    std::printf("joined: %s\n", r.report.region_rule.c_str());
  }
}

TEST(LeafletSurface, hole_is_filled_smoothly) {
  mv::RawLeaflets raw = generic_raw(0.8);
  const mv::LeafletSurface whole = mv::build_leaflet_surface(raw, coarse());
  remove_if(raw, [](const Vec3& c, int) { return (c - Vec3(0, 12, -7)).norm() < 3; });
  const mv::LeafletSurface r = mv::build_leaflet_surface(raw, coarse());
  expect_valid(r, 1.0);
  EXPECT_TRUE(says(r.report.notes, "hole"));
  const double area = whole.report.area_anterior;
  std::printf("hole: anterior %.2f mm2, whole %.2f\n", r.report.area_anterior, area);
  EXPECT_NEAR(r.report.area_anterior, area, 0.005 * area);
}

TEST(LeafletSurface, what_is_no_valve_is_refused_by_name) {
  const mv::RawLeaflets good = generic_raw();
  mv::RawLeaflets raw = good;
  raw.points[17].y() = std::nan("");
  EXPECT_NE(message_of(raw).find("point 17 are not finite"), std::string::npos) << message_of(raw);

  raw = good;
  raw.triangles.clear();
  EXPECT_NE(message_of(raw).find("no triangles"), std::string::npos) << message_of(raw);

  raw = good;
  raw.triangles[3][1] = 1 << 30;
  EXPECT_NE(message_of(raw).find("triangle 3"), std::string::npos) << message_of(raw);

  raw = good;  // one leaflet only
  remove_if(raw, [](const Vec3&, int region) { return region == mv::posterior; });
  EXPECT_NE(message_of(raw).find("one leaflet only"), std::string::npos) << message_of(raw);

  raw = good;  // two valves
  const int shift = static_cast<int>(raw.points.size());
  for (int i = 0; i < shift; ++i) raw.points.push_back(raw.points[at(i)] + Vec3(60, 0, 0));
  for (std::size_t t = good.triangles.size(); t-- > 0;) {
    const auto tri = good.triangles[t];
    raw.triangles.push_back({tri[0] + shift, tri[1] + shift, tri[2] + shift});
    raw.region.push_back(1);
  }
  EXPECT_NE(message_of(raw).find("2 rings"), std::string::npos) << message_of(raw);

  raw = good;  // an annulus curve that the leaflets do not reach over a quarter
  for (int i = 0; i < 120; ++i) {
    const double phi = 2 * std::numbers::pi * i / 120, r = std::abs(phi - 1.5) < 0.8 ? 1.35 : 1.0;
    raw.annulus_curve.push_back({-19 * r * std::sin(phi), 15 * r * std::cos(phi), 0});
  }
  EXPECT_NE(message_of(raw).find("torn off"), std::string::npos) << message_of(raw);

  // Moebius band
  raw = {};
  for (int i = 0; i < 60; ++i)
    for (int j = 0; j < 2; ++j) {
      const double phi = 2 * std::numbers::pi * i / 60, w = j ? 4 : -4;
      raw.points.push_back({(15 + w * std::cos(phi / 2)) * std::cos(phi), (15 + w * std::cos(phi / 2)) * std::sin(phi), w * std::sin(phi / 2)});
    }
  for (int i = 0; i < 60; ++i) {
    const bool last = i == 59;
    const int a = 2 * i, b = 2 * i + 1, c = last ? 1 : 2 * i + 2, d = last ? 0 : 2 * i + 3;
    raw.triangles.push_back({a, c, b});
    raw.triangles.push_back({b, c, d});
  }
  EXPECT_NE(message_of(raw).find("one-sided"), std::string::npos) << message_of(raw);

  // Klein bottle: closed and one-sided.
  raw = {};
  constexpr int n = 24, m = 16;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < m; ++j) {
      const double a = 2 * std::numbers::pi * i / n, b = 2 * std::numbers::pi * (j + 0.5) / m;
      const double r = 12 + std::cos(a / 2) * std::sin(b) * 3 - std::sin(a / 2) * std::sin(2 * b) * 3;
      raw.points.push_back({r * std::cos(a), r * std::sin(a), 3 * (std::sin(a / 2) * std::sin(b) + std::cos(a / 2) * std::sin(2 * b))});
    }
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < m; ++j) {
      const auto index = [&](int p, int q) { return p < n ? p * m + (q % m) : m - 1 - (q % m); };
      raw.triangles.push_back({index(i, j), index(i + 1, j), index(i + 1, j + 1)});
      raw.triangles.push_back({index(i, j), index(i + 1, j + 1), index(i, j + 1)});
    }
  EXPECT_NE(message_of(raw).find("one-sided"), std::string::npos) << message_of(raw);

  // A closed thick shell.
  raw = {};
  raw.points = {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {0, 0, 10}};
  raw.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  EXPECT_NE(message_of(raw).find("closed"), std::string::npos) << message_of(raw);

  // A cylinder without any evidence, and one that only says where down is.
  mv::RawLeaflets bare = cylinder(15, 12);
  bare.ventricle_direction = Vec3(0, 0, -1);
  EXPECT_NE(message_of(bare).find("where the commissures are"), std::string::npos) << message_of(bare);
  EXPECT_NE(message_of(cylinder(15, 12)).find("nothing tells"), std::string::npos) << message_of(cylinder(15, 12));
}

TEST(LeafletSurface, thickness_is_carried_and_kept_in_bounds) {
  mv::RawLeaflets raw = generic_raw();
  for (const Vec3& p : raw.points) raw.thickness.push_back(p.y() > 0 ? 1.4 : 0.8);
  const mv::LeafletSurface r = mv::build_leaflet_surface(raw, coarse());
  expect_valid(r, 1.0);
  ASSERT_EQ(r.surface.thickness.size(), r.surface.points.size());
  int compared = 0;
  for (std::size_t i = 0; i < r.surface.points.size(); ++i) {
    if (std::abs(r.surface.points[i].y()) < 5 || r.surface.unfolded[i].y() < 2) continue;
    const double expected = r.surface.points[i].y() > 0 ? 1.4 : 0.8;
    compared += std::abs(r.surface.thickness[i] - expected) < 0.05;
    EXPECT_LT(r.surface.thickness[i], expected + 0.1);
  }
  std::printf("thickness: %d points as given\n", compared);
  EXPECT_GT(compared, static_cast<int>(0.5 * static_cast<double>(r.surface.points.size())));
}

TEST(LeafletSurface, the_same_input_gives_the_same_surface) {
  const mv::RawLeaflets raw = generic_raw();
  const mv::LeafletSurface a = mv::build_leaflet_surface(raw, coarse()), b = mv::build_leaflet_surface(raw, coarse());
  EXPECT_EQ(a.surface.points, b.surface.points);
  EXPECT_EQ(a.surface.triangles, b.surface.triangles);
}

}  // namespace
