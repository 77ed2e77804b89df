// SPDX-License-Identifier: BSD-3-Clause
#include "geometry/core/pack.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "solver/solid/principal.h"

using namespace mv;
using namespace mv::solid_kernel;

namespace {

double lane(Pack p, int l) { return p[l]; }

TEST(pack, exponential_agrees_with_std_exp) {
  std::mt19937 random(1);
  double worst = 0;
  for (double range : {1e-8, 1e-2, 1.0, 30.0, 690.0}) {
    std::uniform_real_distribution<double> value(-range, range);
    for (int n = 0; n < 4000; ++n) {
      Pack a;
      for (int l = 0; l < lanes; ++l) a[l] = value(random);
      const Pack r = exponential(a);
      for (int l = 0; l < lanes; ++l) worst = std::max(worst, std::abs(lane(r, l) / std::exp(lane(a, l)) - 1));
    }
  }
  EXPECT_LT(worst, 4.5e-16);
  EXPECT_TRUE(std::isfinite(lane(exponential(broadcast<Pack>(1e10)), 0)));
  EXPECT_GE(lane(exponential(broadcast<Pack>(-1e10)), 0), 0.0);
  EXPECT_EQ(lane(exponential(Pack{}), 3), 1.0);
}

TEST(pack, logarithm_agrees_with_std_log) {
  std::mt19937 random(2);
  double worst = 0;
  for (double range : {1e-9, 1e-3, 0.5, 5.0, 600.0}) {
    std::uniform_real_distribution<double> value(-range, range);
    for (int n = 0; n < 4000; ++n) {
      Pack a;
      for (int l = 0; l < lanes; ++l) a[l] = std::exp(value(random));
      const Pack r = logarithm(a);
      for (int l = 0; l < lanes; ++l) {
        const double exact = std::log(lane(a, l));
        if (exact != 0) worst = std::max(worst, std::abs(lane(r, l) / exact - 1));
      }
    }
  }
  EXPECT_LT(worst, 4.5e-16);
  EXPECT_EQ(lane(logarithm(broadcast<Pack>(1.0)), 0), 0.0);
}

TEST(pack, square_root_maximum_select_and_any) {
  const double roots[8] = {0.0, 1.0, 2.0, 4.0, 9.0, 1e-300, 1e300, 0.25};
  const double inverses[8] = {1e-300, 1e-8, 0.3, 0.5, 0.99, 1.0, 123.0, 1e300};
  for (int begin = 0; begin < 8; begin += lanes) {
    const Pack r = square_root(load(roots + begin)), inverse = inverse_square_root(load(inverses + begin));
    for (int l = 0; l < lanes; ++l) {
      EXPECT_EQ(lane(r, l), std::sqrt(roots[begin + l]));
      EXPECT_NEAR(lane(inverse, l) * std::sqrt(inverses[begin + l]), 1.0, 4.5e-16);
    }
  }
  for (int l = 0; l < lanes; ++l) {   // each lane counts, and no other
    Pack a = load(roots);
    a[l] = 1e300;
    EXPECT_TRUE(any(a > broadcast<Pack>(1e299)));
    EXPECT_EQ(any(a < Pack{}), false);
    const Pack chosen = select(a > broadcast<Pack>(1e299), a, -a);
    for (int k = 0; k < lanes; ++k) EXPECT_EQ(lane(chosen, k), k == l || a[k] > 1e299 ? a[k] : -a[k]);
  }
  EXPECT_EQ(lane(absolute(-load(roots)), 3), 4.0);
}

/// A = R diag(values) R^T must come back for values that repeat exactly, nearly, or not.
TEST(principal_values, rebuild_the_tensor_also_for_repeated_values) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const double cases[][3] = {{1, 1, 1},        {2, 2, 1},       {1, 3, 3}, {1, 1 + 1e-13, 1 - 1e-13},
                             {4, 4 + 1e-8, 1}, {1e-12, 1, 1e6}, {0, 0, 5}, {0.2, 1, 7}};
  for (const auto& values : cases)
    for (int n = 0; n < 200; ++n) {
      double q[4], length = 0;
      for (double& c : q) c = normal(random), length += c * c;
      for (double& c : q) c /= std::sqrt(length);
      const double R[3][3] = {
          {1 - 2 * (q[2] * q[2] + q[3] * q[3]), 2 * (q[1] * q[2] - q[3] * q[0]), 2 * (q[1] * q[3] + q[2] * q[0])},
          {2 * (q[1] * q[2] + q[3] * q[0]), 1 - 2 * (q[1] * q[1] + q[3] * q[3]), 2 * (q[2] * q[3] - q[1] * q[0])},
          {2 * (q[1] * q[3] - q[2] * q[0]), 2 * (q[2] * q[3] + q[1] * q[0]), 1 - 2 * (q[1] * q[1] + q[2] * q[2])}};
      Tensor<double> A{};
      Tensor<Pack> Ap{};
      double scale = 0;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          for (int a = 0; a < 3; ++a) A(i, j) += R[i][a] * values[a] * R[j][a];
          Ap(i, j) = broadcast<Pack>(A(i, j));
        }
      for (double v : values) scale = std::max(scale, v);
      const Spectrum<double> s = principal_values(A);
      const Spectrum<Pack> sp = principal_values(Ap);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          double rebuilt = 0, rebuilt8 = 0, orthogonal = 0;
          for (int a = 0; a < 3; ++a) {
            rebuilt += s.value[a] * s.vector[a][i] * s.vector[a][j];
            rebuilt8 += sp.value[a][lanes - 1] * sp.vector[a][i][lanes - 1] * sp.vector[a][j][lanes - 1];
            orthogonal += s.vector[i][a] * s.vector[j][a];
          }
          ASSERT_NEAR(rebuilt, A(i, j), 4e-15 * scale);
          ASSERT_NEAR(rebuilt8, A(i, j), 4e-15 * scale);
          ASSERT_NEAR(orthogonal, i == j ? 1.0 : 0.0, 4e-15);
        }
    }
}

}   // namespace
