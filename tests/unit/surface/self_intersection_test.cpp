// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/surface/self_intersection.h"

#include <gtest/gtest.h>

#include <limits>

#include "geometry/core/errors.h"
#include "geometry/generic/generic_valve.h"
#include "geometry/volume/leaflet_tets.h"

namespace {

using mv::self_intersections;
using mv::Vec3;
using Triangles = std::vector<std::array<int, 3>>;
using Pairs = std::vector<std::pair<int, int>>;

TEST(SelfIntersection, crossing_touching_and_separate_triangles) {
  const std::vector<Vec3> base{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  auto with = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    std::vector<Vec3> points = base;
    points.insert(points.end(), {a, b, c});
    return self_intersections(points, {{0, 1, 2}, {3, 4, 5}}).size();
  };
  EXPECT_EQ(with({1, 1, -1}, {1, 1, 1}, {3, 3, 1}), 1u);      // pierced
  EXPECT_EQ(with({1, 1, 0.1}, {1, 1, 1}, {3, 3, 1}), 0u);     // above
  EXPECT_EQ(with({1, 1, 0}, {1, 1, 1}, {3, 3, 1}), 1u);       // a corner rests on the face
  EXPECT_EQ(with({1, 1, 1e-300}, {1, 1, 1}, {3, 3, 1}), 0u);  // exact: the smallest gap counts
  EXPECT_EQ(with({1, 1, 0}, {2, 1, 0}, {1, 2, 0}), 1u);       // coplanar overlap
}

TEST(SelfIntersection, neighbours_that_share_a_corner_or_an_edge) {
  const std::vector<Vec3> points{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {4, 4, 0}, {1, 1, 0}, {3, 3, 2}, {2, 1, 3}, {-1, 1, 3}};
  EXPECT_TRUE(self_intersections(points, Triangles{{0, 1, 2}, {1, 3, 2}}).empty());         // flat neighbours
  EXPECT_EQ(self_intersections(points, Triangles{{0, 1, 2}, {1, 4, 2}}), (Pairs{{0, 1}}));  // folded onto each other
  EXPECT_TRUE(self_intersections(points, Triangles{{0, 1, 2}, {1, 6, 2}}).empty());         // folded up
  EXPECT_TRUE(self_intersections(points, Triangles{{0, 1, 2}, {0, 5, 7}}).empty());         // share a corner only
  std::vector<Vec3> pierced = points;
  pierced[5] = {2, 1, 1};
  pierced[7] = {1, 1, -1};
  EXPECT_EQ(self_intersections(pierced, Triangles{{0, 1, 2}, {0, 5, 7}}), (Pairs{{0, 1}}));  // far edge goes through
  EXPECT_EQ(self_intersections(points, Triangles{{0, 1, 2}, {2, 1, 0}}), (Pairs{{0, 1}}));   // twice the same
}

TEST(SelfIntersection, degenerate_triangles_pair_with_themselves_and_bad_input_is_refused) {
  const std::vector<Vec3> points{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}};
  EXPECT_EQ(self_intersections(points, Triangles{{0, 1, 3}, {0, 1, 2}, {1, 1, 3}}), (Pairs{{1, 1}, {2, 2}}));
  EXPECT_THROW(self_intersections(points, Triangles{{0, 1, 4}}), mv::InputError);
  std::vector<Vec3> broken = points;
  broken[2].x() = std::numeric_limits<double>::infinity();
  EXPECT_THROW(self_intersections(broken, Triangles{{0, 1, 3}}), mv::InputError);
}

TEST(SelfIntersection, agrees_with_a_count_over_all_pairs_of_shifted_sheets) {
  // Two grids of 10 x 10 squares, the second tilted through the first along x = 5: only squares of the crossing strip can meet.
  std::vector<Vec3> points;
  Triangles triangles;
  for (int g = 0; g < 2; ++g) {
    const int first = static_cast<int>(points.size());
    for (int i = 0; i <= 10; ++i)
      for (int j = 0; j <= 10; ++j) points.push_back({double(i), j + 0.37 * g, g * 0.8 * (i - 5.03)});
    for (int i = 0; i < 10; ++i)
      for (int j = 0; j < 10; ++j) {
        const int a = first + 11 * i + j;
        triangles.push_back({a, a + 11, a + 12});
        triangles.push_back({a, a + 12, a + 1});
      }
  }
  Pairs brute;
  for (int s = 0; s < static_cast<int>(triangles.size()); ++s)
    for (int t = s + 1; t < static_cast<int>(triangles.size()); ++t) {
      const auto pair =
          self_intersections(points, {triangles[static_cast<std::size_t>(s)], triangles[static_cast<std::size_t>(t)]});
      if (!pair.empty()) brute.emplace_back(s, t);
    }
  EXPECT_EQ(self_intersections(points, triangles), brute);
  EXPECT_GT(brute.size(), 20u);
}

TEST(SelfIntersection, generic_valve_is_free_and_a_pushed_through_leaflet_is_found) {
  for (int order : {1, 2}) {
    mv::GenericValveParameters p;
    p.anterior_height = 1.2;
    const mv::LeafletMesh m = mv::thicken(mv::build_generic_valve(p, 1.5).mid_surface, {1.0, 2, order});
    const mv::Gate good = mv::gate_self_intersection(m);
    EXPECT_TRUE(good.passed) << good.message;
    std::vector<Vec3> moved = m.points;
    for (Vec3& x : moved)
      if (x.y() > 0 && x.z() < -8) x.y() -= 1.5 * (-8 - x.z());  // anterior leaflet swings through the posterior one
    const mv::Gate bad = mv::gate_self_intersection(m, moved, "test");
    EXPECT_FALSE(bad.passed);
    EXPECT_GT(bad.value, 10);
    EXPECT_GE(bad.worst_element, 0);
  }
}

}  // namespace
