// SPDX-License-Identifier: BSD-3-Clause
#include "solver/coupling/wall_limit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "geometry/core/errors.h"
#include "solver/fluid/tube_wall.h"

namespace {

using mv::WallLimit;
using Vec2 = Eigen::Vector2d;

std::vector<Vec2> ellipse(double a, double b, int corners) {
  std::vector<Vec2> section;
  for (int q = 0; q < corners; ++q) section.emplace_back(a * std::cos(2 * M_PI * q / corners), b * std::sin(2 * M_PI * q / corners));
  return section;
}

/// A tube with a dent: not convex.
std::vector<Vec2> dented() {
  std::vector<Vec2> section;
  for (int q = 0; q < 120; ++q) {
    const double angle = 2 * M_PI * q / 120, r = 15e-3 - 5e-3 * std::exp(-8 * std::pow(angle - 1.5, 2));
    section.emplace_back(r * std::cos(angle), r * std::sin(angle));
  }
  return section;
}

Vec2 nearest_by_search(const Vec2& p, const std::vector<Vec2>& section) {
  Vec2 best = section[0];
  for (std::size_t e = 0; e < section.size(); ++e) {
    const Vec2 a = section[e], d = section[(e + 1) % section.size()] - a;
    const Vec2 q = a + std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0) * d;
    if ((q - p).norm() < (best - p).norm()) best = q;
  }
  return best;
}

TEST(WallLimit, nodes_outside_come_back_to_the_nearest_wall_and_others_stay) {
  for (const auto& section : {ellipse(19e-3, 15e-3, 90), dented(), ellipse(19e-3, 15e-3, 3)}) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> u(-60e-3, 60e-3);   // far outside, too
    std::vector<double> rest, x;
    for (int n = 0; n < 4000; ++n) {
      rest.insert(rest.end(), {0.0, 0.0, 0.0});
      const double scale = n % 2 ? 1.0 : 0.35;
      x.insert(x.end(), {scale * u(random), scale * u(random), u(random)});
    }
    WallLimit limit(section, rest, std::vector<char>(rest.size() / 3, 0));
    const std::vector<double> before = x;
    limit.apply(x);
    std::size_t moved = 0;
    for (std::size_t i = 0; i < x.size() / 3; ++i) {
      const Vec2 p(before[3 * i], before[3 * i + 1]), now(x[3 * i], x[3 * i + 1]);
      EXPECT_EQ(x[3 * i + 2], before[3 * i + 2]);
      if (mv::is_inside_polygon(p, section)) {
        EXPECT_EQ(now, p);
        continue;
      }
      EXPECT_LT((now - nearest_by_search(p, section)).norm(), 1e-12);
      ASSERT_LT(moved, limit.moved().size());
      EXPECT_EQ(limit.moved()[moved], static_cast<int>(i));
      EXPECT_LT((limit.shifts()[moved].head<2>() - (now - p)).norm(), 1e-15);
      ++moved;
    }
    EXPECT_EQ(moved, limit.moved().size());
    EXPECT_GT(moved, 500u);
  }
}

TEST(WallLimit, what_lies_outside_at_rest_may_stay_as_far_outside) {
  const auto section = ellipse(19e-3, 15e-3, 400);
  const std::vector<double> rest{19.5e-3, 0, 0, 19.5e-3, 0, 0, 18e-3, 0, 0};
  WallLimit limit(section, rest, std::vector<char>{0, 1, 0});
  std::vector<double> x{19.4e-3, 0, 1e-3, 25e-3, 0, 0, 19e-3, 0, 0};
  const std::vector<double> before = x;
  limit.apply(x);
  EXPECT_EQ(x, before);   // within its 0.5 mm; held; on the wall
  x = {-22e-3, 0, 0, 25e-3, 0, 0, 0, 19e-3, 0};
  limit.apply(x);
  EXPECT_NEAR(x[0], -19.5e-3, 1e-8);
  EXPECT_EQ(x[3], 25e-3);
  EXPECT_NEAR(x[7], 15e-3, 1e-5);   // of the polygon
  EXPECT_EQ(limit.moved().size(), 2u);
}

TEST(WallLimit, sizes_that_do_not_match_are_refused) {
  const std::vector<double> rest(6, 0.0);
  EXPECT_THROW(WallLimit(ellipse(1, 1, 2), rest, std::vector<char>(2, 0)), mv::InputError);
  EXPECT_THROW(WallLimit(ellipse(1, 1, 8), rest, std::vector<char>(3, 0)), mv::InputError);
}

}  // namespace
