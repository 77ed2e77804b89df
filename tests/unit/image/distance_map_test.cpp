// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/image/distance_map.h"

#include <gtest/gtest.h>

#include <random>

using namespace mv;

TEST(DistanceMap, equals_brute_force_on_anisotropic_grids) {
  std::mt19937 random(7);
  for (const auto& [size, spacing, seeds] : std::vector<std::tuple<std::array<int, 3>, Vec3, int>>{
           {{9, 7, 8}, {1, 1, 1}, 3}, {{12, 5, 9}, {0.7, 0.7, 3}, 1}, {{8, 8, 8}, {0.5, 2, 1}, 40}, {{1, 1, 20}, {1, 1, 0.3}, 2}}) {
    std::vector<char> is_seed(static_cast<std::size_t>(size[0] * size[1] * size[2]), 0);
    for (int s = 0; s < seeds; ++s) is_seed[random() % is_seed.size()] = 1;
    const auto d = distance_map(size, spacing, [&](std::size_t v) { return is_seed[v] != 0; });
    const auto place = [&](std::size_t v) {
      const auto nx = static_cast<std::size_t>(size[0]), ny = static_cast<std::size_t>(size[1]);
      return Vec3(static_cast<double>(v % nx), static_cast<double>(v / nx % ny), static_cast<double>(v / nx / ny)).cwiseProduct(spacing).eval();
    };
    double worst = 0;
    for (std::size_t v = 0; v < is_seed.size(); ++v) {
      double nearest = 1e300;
      for (std::size_t u = 0; u < is_seed.size(); ++u)
        if (is_seed[u]) nearest = std::min(nearest, (place(u) - place(v)).norm());
      worst = std::max(worst, std::abs(nearest - d[v]));
    }
    EXPECT_LT(worst, 1e-5);
  }
}

TEST(DistanceMap, is_infinite_without_seeds) {
  const auto d = distance_map({3, 3, 3}, Vec3::Ones(), [](std::size_t) { return false; });
  for (const float x : d) EXPECT_TRUE(std::isinf(x));
}
