// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/richardson.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace mv {
namespace {

/// f0 + C h^p at three spacings.
std::array<double, 3> manufactured(double f0, double c, double p, const std::array<double, 3>& h) {
  return {f0 + c * std::pow(h[0], p), f0 + c * std::pow(h[1], p), f0 + c * std::pow(h[2], p)};
}

TEST(Richardson, finds_order_and_limit_of_manufactured_values_at_any_ratios) {
  for (const std::array<double, 3>& h : {std::array<double, 3>{4, 2, 1}, {3, 2, 1.5}, {2, 1.5, 1}})
    for (double p : {0.5, 1.0, 1.5, 2.0})
      for (double c : {0.3, -0.3}) {
        const Richardson r = richardson(h, manufactured(10, c, p, h));
        std::printf("h %g %g %g: order computed %.6f, reference %g, difference %.2g; limit %.9f, reference 10\n", h[0], h[1], h[2], r.order, p, r.order - p, r.extrapolated);
        EXPECT_TRUE(r.is_monotone);
        EXPECT_NEAR(r.order, p, 1e-6);
        EXPECT_NEAR(r.extrapolated, 10, 1e-6);
        EXPECT_NEAR(r.uncertainty, 1.25 * std::abs(c) * std::pow(h[2], p), 1e-6);
      }
}

TEST(Richardson, orders_that_no_scheme_claims_are_not_used_to_shrink_the_uncertainty) {
  const std::array<double, 3> h{4, 2, 1};
  const auto values = manufactured(10, 0.3, 6, h);
  const Richardson fast = richardson(h, values);
  EXPECT_NEAR(fast.order, 6, 1e-6);
  EXPECT_NEAR(fast.uncertainty, 1.25 * std::abs(values[1] - values[2]) / 3, 1e-9);  // as second order
  // Values that hardly converge: the order counts as a half, and the uncertainty exceeds the last difference.
  const Richardson slow = richardson(h, {1.0, 2.0, 2.99});
  EXPECT_GT(slow.uncertainty, 0.99);
}

TEST(Richardson, values_without_a_trend_have_their_range_as_uncertainty) {
  const Richardson r = richardson({4, 2, 1}, {5, 7, 6.5});
  EXPECT_FALSE(r.is_monotone);
  EXPECT_TRUE(std::isnan(r.order));
  EXPECT_DOUBLE_EQ(r.extrapolated, 6.5);
  EXPECT_DOUBLE_EQ(r.uncertainty, 2);
}

TEST(Richardson, equal_values_are_certain_and_spacings_must_decrease) {
  EXPECT_DOUBLE_EQ(richardson({4, 2, 1}, {5, 5, 5}).uncertainty, 0);
  EXPECT_THROW(richardson({1, 2, 4}, {1, 2, 3}), std::invalid_argument);
  EXPECT_THROW(richardson({2, 2, 1}, {1, 2, 3}), std::invalid_argument);
}

}  // namespace
}  // namespace mv
