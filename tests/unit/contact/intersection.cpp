// SPDX-License-Identifier: BSD-3-Clause
#include "solver/contact/intersection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

#include "geometry/core/errors.h"
#include "geometry/core/parallel.h"
#include "solver/contact/exact_predicates.h"
#include "unit/contact/shapes.h"

namespace mv::test {
namespace {

using Corners = std::array<Vec3, 3>;
using Integer = std::array<std::int64_t, 3>;
using IntegerCorners = std::array<Integer, 3>;

Integer minus(const Integer& a, const Integer& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Integer cross(const Integer& a, const Integer& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
__extension__ using Wide = __int128;
Wide dot(const Integer& a, const Integer& b) {
  return static_cast<Wide>(a[0]) * b[0] + static_cast<Wide>(a[1]) * b[1] + static_cast<Wide>(a[2]) * b[2];
}
int sign(Wide v) { return v > 0 ? 1 : (v < 0 ? -1 : 0); }
Integer normal_of(const IntegerCorners& t) { return cross(minus(t[1], t[0]), minus(t[2], t[0])); }
bool is_degenerate(const IntegerCorners& t) { return normal_of(t) == Integer{0, 0, 0}; }

/// Oracle: two convex bodies are disjoint when an axis separates them; for triangles the two normals, the nine products of edges
/// and the in-plane normals of the edges suffice. Integer arithmetic, no rounding; another method than the code under test.
bool oracle_intersect(const IntegerCorners& a, const IntegerCorners& b) {
  const Integer na = normal_of(a), nb = normal_of(b);
  std::vector<Integer> axes{na, nb};
  for (int i = 0; i < 3; ++i) {
    const Integer ea = minus(a[(i + 1) % 3], a[i]), eb = minus(b[(i + 1) % 3], b[i]);
    axes.push_back(cross(na, ea));
    axes.push_back(cross(nb, eb));
    for (int j = 0; j < 3; ++j) axes.push_back(cross(ea, minus(b[(j + 1) % 3], b[j])));
  }
  for (const Integer& axis : axes) {
    Wide a_low = dot(axis, a[0]), a_high = a_low, b_low = dot(axis, b[0]), b_high = b_low;
    for (int k = 1; k < 3; ++k) {
      a_low = std::min(a_low, dot(axis, a[k]));
      a_high = std::max(a_high, dot(axis, a[k]));
      b_low = std::min(b_low, dot(axis, b[k]));
      b_high = std::max(b_high, dot(axis, b[k]));
    }
    if (a_high < b_low || b_high < a_low) return false;
  }
  return true;
}

Vec3 to_double(const Integer& p, double scale) {
  return scale * Vec3(static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2]));
}
Corners to_double(const IntegerCorners& t, double scale) {
  return {to_double(t[0], scale), to_double(t[1], scale), to_double(t[2], scale)};
}

TEST(ExactPredicates, orientation_agrees_with_integers_close_to_degeneracy) {
  // Points of a plane far from the origin, moved by single units: the filter cannot decide, the expansions must.
  std::mt19937 random(7);
  std::uniform_int_distribution<std::int64_t> small(-3, 3), large(-(1 << 20), 1 << 20), step(-1, 1);
  int zeros = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    const Integer a{large(random), large(random), large(random)}, u{small(random), small(random), small(random)},
        w{small(random), small(random), small(random)};
    const auto combine = [&](std::int64_t s, std::int64_t t) {
      return Integer{a[0] + s * u[0] + t * w[0] + step(random), a[1] + s * u[1] + t * w[1], a[2] + s * u[2] + t * w[2]};
    };
    const Integer b = combine(large(random), small(random)), c = combine(small(random), large(random)),
                  d = combine(large(random), large(random));
    const Wide det = dot(minus(a, d), cross(minus(b, d), minus(c, d)));
    const double scale = std::ldexp(1.0, -30);
    EXPECT_EQ(orientation_3d(to_double(a, scale), to_double(b, scale), to_double(c, scale), to_double(d, scale)), sign(det));
    zeros += det == 0;
  }
  EXPECT_GT(zeros, 100);
}

TEST(ExactPredicates, orientation_sees_one_unit_in_the_last_place) {
  const double big = 1.0 + std::ldexp(1.0, -52);
  const Vec3 a(0.1, 0.1, 0.1), b(0.3, 0.3, 0.3), c(0.2, 0.7, 0.9);
  // d on the line through a and b up to rounding; its exact side follows from comparing coordinates.
  const Vec3 on(0.5, 0.5, 0.5), off(0.5 * big, 0.5, 0.5);
  EXPECT_EQ(orientation_3d(a, b, c, on), 0);
  EXPECT_NE(orientation_3d(a, b, c, off), 0);
  EXPECT_EQ(orientation_3d(a, b, c, off), -orientation_3d(b, a, c, off));
  EXPECT_EQ(orientation_2d(a, b, on, 2), 0);
  EXPECT_EQ(orientation_2d(a, b, off, 2), -1);
}

TEST(TriangleIntersection, known_cases) {
  const Corners t{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  const auto hits = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    return triangles_intersect(t, {a, b, c}) && triangles_intersect({a, b, c}, t);
  };
  const auto misses = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    return !triangles_intersect(t, {a, b, c}) && !triangles_intersect({a, b, c}, t);
  };
  EXPECT_TRUE(hits({0.2, 0.2, -1}, {0.2, 0.2, 1}, {5, 5, 0}));        // pierced
  EXPECT_TRUE(misses({0.2, 0.2, 1e-300}, {0.2, 0.2, 1}, {5, 5, 1}));  // barely above
  EXPECT_TRUE(hits({0.2, 0.2, 0}, {0.2, 0.2, 1}, {5, 5, 1}));         // touched by a corner
  EXPECT_TRUE(hits({0.5, 0.5, -1}, {0.5, 0.5, 1}, {5, 5, 0}));        // touched on its edge
  EXPECT_TRUE(misses({0.5 + 1e-15, 0.5, -1}, {0.5 + 1e-15, 0.5, 1}, {5, 5, 0}));
  EXPECT_TRUE(hits({0, 0, 0}, {-1, 0, 1}, {-1, 0, -1}));           // corner on corner
  EXPECT_TRUE(hits({0.1, 0.1, 0}, {0.2, 0.1, 0}, {0.1, 0.2, 0}));  // coplanar, inside
  EXPECT_TRUE(hits({-1, -1, 0}, {3, -1, 0}, {-1, 3, 0}));          // coplanar, around
  EXPECT_TRUE(hits({1, 0, 0}, {2, 0, 0}, {2, 1, 0}));              // coplanar, a corner touches
  EXPECT_TRUE(hits({0.25, 0, 0}, {0.75, 0, 0}, {0.5, -1, 0}));     // coplanar, edges overlap
  EXPECT_TRUE(misses({1 + 1e-15, 0, 0}, {2, 0, 0}, {2, 1, 0}));
  EXPECT_TRUE(misses({0, 0, 1}, {1, 0, 1}, {0, 1, 1}));  // parallel
}

TEST(TriangleIntersection, random_pairs_agree_with_integer_arithmetic) {
  std::mt19937 random(11);
  int intersecting = 0, coplanar = 0;
  for (int range : {2, 3, 6, 20, 1000}) {  // small ranges are full of coplanar, touching and overlapping pairs
    std::uniform_int_distribution<std::int64_t> coordinate(-range, range);
    for (int trial = 0; trial < 20000; ++trial) {
      IntegerCorners a, b;
      for (auto* t : {&a, &b}) {
        do {
          for (auto& p : *t) p = {coordinate(random), coordinate(random), coordinate(random)};
        } while (is_degenerate(*t));
      }
      if (trial % 4 == 0) {  // coplanar pairs on purpose
        for (auto* t : {&a, &b}) {
          for (auto& p : *t) p[2] = p[0] - 2 * p[1];
        }
        if (is_degenerate(a) || is_degenerate(b)) continue;
        ++coplanar;
      }
      const bool expected = oracle_intersect(a, b);
      intersecting += expected;
      const double scale = std::ldexp(1.0, -10);
      ASSERT_EQ(triangles_intersect(to_double(a, scale), to_double(b, scale)), expected)
          << "range " << range << " trial " << trial;
    }
  }
  EXPECT_GT(intersecting, 5000);
  EXPECT_GT(coplanar, 10000);
}

/// All pairs, integers, the convention of the header.
std::vector<std::pair<int, int>> oracle_self_intersections(const std::vector<Integer>& points,
                                                           const std::vector<std::array<int, 3>>& triangles) {
  std::vector<std::pair<int, int>> pairs;
  const auto corners = [&](int f) {
    return IntegerCorners{points[triangles[f][0]], points[triangles[f][1]], points[triangles[f][2]]};
  };
  for (int f = 0; f < static_cast<int>(triangles.size()); ++f) {
    if (is_degenerate(corners(f))) {
      pairs.emplace_back(f, f);
      continue;
    }
    for (int g = f + 1; g < static_cast<int>(triangles.size()); ++g) {
      if (is_degenerate(corners(g))) continue;
      std::vector<int> shared, only_f, only_g;
      for (int v : triangles[f]) (std::count(triangles[g].begin(), triangles[g].end(), v) ? shared : only_f).push_back(v);
      for (int v : triangles[g]) {
        if (!std::count(triangles[f].begin(), triangles[f].end(), v)) only_g.push_back(v);
      }
      bool hit = false;
      if (shared.empty()) {
        hit = oracle_intersect(corners(f), corners(g));
      } else if (shared.size() == 2) {
        const Integer e = minus(points[shared[1]], points[shared[0]]);
        const Integer nf = cross(e, minus(points[only_f[0]], points[shared[0]])),
                      ng = cross(e, minus(points[only_g[0]], points[shared[0]]));
        hit = cross(nf, ng) == Integer{0, 0, 0} && dot(nf, ng) > 0;
      } else if (shared.size() == 1) {
        // Triangles that meet in more than their corner: shrink one towards the far side of the corner by moving it by 1/1000
        // into its opposite edge's direction; integers stay exact because all coordinates are scaled by 1000 first.
        const auto shrunk = [&](int h, const std::vector<int>& others) {
          IntegerCorners t;
          const Integer c = points[shared[0]];
          for (int k = 0; k < 3; ++k) t[0][k] = 1000 * c[k] + (points[others[0]][k] - c[k]) + (points[others[1]][k] - c[k]);
          for (int k = 0; k < 3; ++k) t[1][k] = 1000 * points[others[0]][k];
          for (int k = 0; k < 3; ++k) t[2][k] = 1000 * points[others[1]][k];
          (void)h;
          return t;
        };
        const auto scaled = [&](int h) {
          IntegerCorners t = corners(h);
          for (auto& p : t) {
            for (auto& v : p) v *= 1000;
          }
          return t;
        };
        // The opposite edge of one meets the other exactly when the pair meets away from the common corner; shrinking keeps that
        // edge.
        hit = oracle_intersect(shrunk(f, only_f), scaled(g)) || oracle_intersect(scaled(f), shrunk(g, only_g));
      } else {
        hit = true;
      }
      if (hit) pairs.emplace_back(f, g);
    }
  }
  return pairs;
}

TEST(SelfIntersection, random_meshes_agree_with_all_pairs_in_integers) {
  std::mt19937 random(3);
  std::size_t found = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const std::int64_t range = trial % 3 == 0 ? 4 : 40;
    std::uniform_int_distribution<std::int64_t> coordinate(-range, range), step(-range / 4 - 1, range / 4 + 1);
    std::vector<Integer> points;
    std::vector<std::array<int, 3>> triangles;
    for (int k = 0; k < 25; ++k) {  // fans of triangles with common corners and edges
      const Integer c{coordinate(random), coordinate(random), coordinate(random)};
      const int first = static_cast<int>(points.size());
      points.push_back(c);
      for (int j = 0; j < 4; ++j) points.push_back({c[0] + step(random), c[1] + step(random), c[2] + step(random)});
      for (int j = 1; j < 4; ++j) triangles.push_back({first, first + j, first + j + 1});
    }
    std::vector<Vec3> x;
    for (const auto& p : points) x.push_back(to_double(p, std::ldexp(1.0, -14)));
    const auto result = self_intersections(x, triangles);
    const auto expected = oracle_self_intersections(points, triangles);
    EXPECT_EQ(result, expected) << "trial " << trial;
    found += expected.size();
  }
  EXPECT_GT(found, 500u);
}

TEST(SelfIntersection, flat_and_bent_sheets_have_none_and_a_crossing_is_counted) {
  TriangleMesh m;
  m.add_sheet(20, 20, 10e-3, 10e-3, [](const Vec3& p) -> Vec3 { return p; });
  const auto surface = contact_surface_from_triangles(m.x, m.triangles);
  EXPECT_TRUE(self_intersections(surface, m.x).empty());
  auto x = m.x;
  for (std::size_t n = 0; n < x.size() / 3; ++n) {  // a wave, and then a roll that runs through itself
    const double u = x[3 * n];
    x[3 * n + 2] = 1e-3 * std::sin(u / 1e-3);
  }
  EXPECT_TRUE(self_intersections(surface, x).empty());
  for (std::size_t n = 0; n < x.size() / 3; ++n) {
    const double angle = m.x[3 * n] / 1.5e-3;  // 6.67 rad: the ends overlap on the same cylinder
    const double radius = 1.5e-3 + 0.02e-3 * m.x[3 * n + 1] / 10e-3 * (angle - 3);
    x[3 * n] = radius * std::cos(angle);
    x[3 * n + 2] = radius * std::sin(angle);
  }
  const auto crossing = self_intersections(surface, x);
  EXPECT_GT(crossing.size(), 10u);
  set_thread_count(1);
  EXPECT_EQ(self_intersections(surface, x), crossing);
  set_thread_count(2);
}

TEST(SelfIntersection, folded_neighbours_and_degenerate_triangles) {
  const std::vector<std::array<int, 3>> two{{0, 1, 2}, {0, 2, 3}};
  std::vector<Vec3> flat{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 1, 0}};
  EXPECT_TRUE(self_intersections(flat, two).empty());
  auto folded = flat;
  folded[3] = {0.5, 0.5, 0};  // folded flat onto its neighbour
  EXPECT_EQ(self_intersections(folded, two).size(), 1u);
  folded[3] = {0.5, 0.5, 1e-300};
  EXPECT_TRUE(self_intersections(folded, two).empty());
  folded[3] = {0, 0.25, 0};
  EXPECT_EQ(self_intersections(folded, two), (std::vector<std::pair<int, int>>{{1, 1}}));
  folded[3][0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(self_intersections(folded, two), InputError);
}

TEST(SelfIntersection, one_huge_triangle_does_not_hide_pairs) {
  TriangleMesh m;
  m.add_sheet(12, 12, 1, 1, [](const Vec3& p) -> Vec3 { return p; });
  std::vector<Vec3> points;
  for (int n = 0; n < m.node_count(); ++n) points.push_back(m.point(n));
  const int first = static_cast<int>(points.size());
  points.insert(points.end(), {Vec3(0.3, -100, -50), Vec3(0.3, 100, -50), Vec3(0.31, 0, 100)});
  m.triangles.push_back({first, first + 1, first + 2});
  const auto result = self_intersections(points, m.triangles);
  std::size_t expected = 0;
  for (std::size_t f = 0; f + 1 < m.triangles.size(); ++f) {
    const auto& t = m.triangles[f];
    expected +=
        triangles_intersect({points[t[0]], points[t[1]], points[t[2]]}, {points[first], points[first + 1], points[first + 2]});
  }
  EXPECT_GE(expected, 12u);
  EXPECT_EQ(result.size(), expected);
}

}  // namespace
}  // namespace mv::test
