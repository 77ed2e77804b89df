// SPDX-License-Identifier: GPL-3.0-or-later
// Sheets bent round a cylinder: what the bend leaves of their thickness.
#include "geometry/unfold/thickness_limit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "geometry/volume/gates.h"
#include "geometry/volume/leaflet_tets.h"

namespace {

constexpr double bend = 1.2;  // mm along the sheet on either side of its middle

/// Flat, a bend of the curvature kappa (1/mm) in the middle, flat again.
mv::MidSurface bent_sheet(double kappa, double thickness, double along = 0.12, double across = 0.3) {
  mv::MidSurface s;
  constexpr int half = 30, rows = 6;
  for (int i = -half; i <= half; ++i) {
    const double x = along * i, in = std::clamp(x, -bend, bend), angle = kappa * in, over = x - in;
    const mv::Vec3 normal(-std::sin(angle), std::cos(angle), 0), tangent(std::cos(angle), std::sin(angle), 0);
    const mv::Vec3 arc(std::sin(angle) / kappa, (1 - std::cos(angle)) / kappa, 0);
    for (int j = 0; j < rows; ++j) {
      s.points.push_back(arc + over * tangent - mv::Vec3(0, 0, across * j));
      s.normals.push_back(normal);
      s.unfolded.push_back({x, across * j});
    }
  }
  for (int i = 0; i < 2 * half; ++i)
    for (int j = 0; j + 1 < rows; ++j) {
      const int a = i * rows + j, b = a + rows;
      s.triangles.push_back({a, b, b + 1});
      s.triangles.push_back({a, b + 1, a + 1});
    }
  s.region.assign(s.triangles.size(), mv::anterior);
  s.on_annulus.assign(s.points.size(), 0);
  s.on_free_edge.assign(s.points.size(), 0);
  s.thickness.assign(s.points.size(), thickness);
  return s;
}

double smallest_angle(const mv::MidSurface& s) { return mv::gate_dihedral_min(mv::thicken(s, {1, 4, 1}), 10).value; }

}  // namespace

TEST(ThicknessLimit, slender_tetrahedra_in_a_bend_thin_it_there_only) {
  mv::MidSurface s = bent_sheet(0.7, 1.9);
  const double before = smallest_angle(s);
  const auto notes = mv::limit_thickness(s, 0.3, 4, 10);
  const double after = smallest_angle(s), thinnest = *std::min_element(s.thickness.begin(), s.thickness.end());
  std::printf("smallest dihedral angle %.2f -> %.2f degrees, thickness 1.9 -> %.2f mm at least\n", before, after, thinnest);
  EXPECT_LT(before, 10) << "nothing to do";
  EXPECT_GE(after, 10);
  EXPECT_GT(thinnest, 0.6);
  EXPECT_DOUBLE_EQ(s.thickness.front(), 1.9);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("slender"), std::string::npos) << notes[0];
}

TEST(ThicknessLimit, a_bend_tighter_than_the_sheet_is_thick_is_thinned_to_its_share_of_the_radius) {
  mv::MidSurface s = bent_sheet(1.0, 1.9);
  mv::limit_thickness(s, 0.3, 2, 0);
  const double middle = s.thickness[s.thickness.size() / 2];
  EXPECT_NEAR(middle, 2 * mv::fold_share / 1.0, 0.02);
  EXPECT_DOUBLE_EQ(s.thickness.front(), 1.9);
}

TEST(ThicknessLimit, where_thinning_does_not_help_nothing_is_thinned) {
  mv::MidSurface s = bent_sheet(0.1, 1.0, 0.03, 0.6);  // the triangles themselves are slender
  EXPECT_LT(smallest_angle(s), 10);
  EXPECT_TRUE(mv::limit_thickness(s, 0.3, 4, 10).empty());
  EXPECT_EQ(std::count(s.thickness.begin(), s.thickness.end(), 1.0), std::ssize(s.thickness));
}
