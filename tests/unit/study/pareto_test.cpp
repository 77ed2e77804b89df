// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/pareto.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace mv {
namespace {

const double unknown = std::nan("");

/// The definition, point by point.
bool is_beaten(const std::vector<CostError>& points, std::size_t i) {
  for (std::size_t j = 0; j < points.size(); ++j) {
    const CostError &a = points[j], &b = points[i];
    if (std::isfinite(a.error) && a.seconds <= b.seconds && a.error <= b.error && (a.seconds < b.seconds || a.error < b.error)) return true;
  }
  return false;
}

TEST(Pareto, front_of_a_small_table) {
  const std::vector<CostError> points{{10, 5}, {20, 2}, {15, 6}, {40, 1}, {40, 2}, {5, unknown}, {1, INFINITY}};
  EXPECT_EQ(pareto_front(points), (std::vector<std::size_t>{0, 1, 3}));
}

TEST(Pareto, unknown_errors_and_empty_tables_give_no_front) {
  EXPECT_TRUE(pareto_front({}).empty());
  EXPECT_TRUE(pareto_front({{1, unknown}, {2, INFINITY}}).empty());
  EXPECT_TRUE(pareto_front({{unknown, 1}}).empty());
}

TEST(Pareto, equal_points_stand_once) { EXPECT_EQ(pareto_front({{3, 2}, {3, 2}, {3, 3}, {4, 2}}), (std::vector<std::size_t>{0})); }

TEST(Pareto, front_is_what_the_definition_says_on_random_points) {
  std::mt19937 random(7);
  // Few different values, so that ties in either coordinate happen often.
  std::uniform_int_distribution<int> value(1, 8);
  for (int round = 0; round < 200; ++round) {
    std::vector<CostError> points;
    for (int i = 0; i < 12; ++i) points.push_back({static_cast<double>(value(random)), static_cast<double>(value(random))});
    const auto front = pareto_front(points);
    for (std::size_t i : front) EXPECT_FALSE(is_beaten(points, i));
    std::size_t distinct = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      bool is_first = true;
      for (std::size_t j = 0; j < i; ++j) is_first &= points[j].seconds != points[i].seconds || points[j].error != points[i].error;
      distinct += is_first && !is_beaten(points, i);
    }
    EXPECT_EQ(front.size(), distinct);
  }
}

TEST(Recommend, takes_the_cheapest_run_that_meets_every_quantity) {
  const std::vector<RunErrors> runs{{"coarse", 10, {9, 30}}, {"middle", 50, {3, 4.5}}, {"fine", 200, {1, 1.5}}, {"slow", 400, {2.5, 4}}};
  const Recommendation at_5 = recommend(runs, 5);
  EXPECT_EQ(at_5.run, 1);
  EXPECT_EQ(at_5.met.size(), 2u);
  EXPECT_TRUE(at_5.not_met.empty());
  EXPECT_EQ(recommend(runs, 2).run, 2);
  EXPECT_EQ(at_5.cheapest, (std::vector<int>{1, 1}));
  EXPECT_EQ(recommend(runs, 10).cheapest, (std::vector<int>{0, 1}));
}

TEST(Recommend, a_quantity_out_of_reach_is_wanted_as_good_as_any_run_has_it) {
  // 1 % of the second quantity is nowhere; the cheap run must not win because of it.
  const std::vector<RunErrors> runs{{"coarse", 10, {0.5, 30}}, {"fine", 200, {0.4, 6}}, {"finer", 900, {0.3, 5}}};
  const Recommendation r = recommend(runs, 1);
  EXPECT_EQ(r.run, 1);  // 6 % is within the slack of 5 %
  EXPECT_EQ(r.met, (std::vector<std::size_t>{0}));
  EXPECT_EQ(r.not_met, (std::vector<std::size_t>{1}));
  EXPECT_DOUBLE_EQ(r.best_error[1], 5);
  EXPECT_EQ(r.cheapest, (std::vector<int>{0, -1}));
}

TEST(Recommend, untrusted_runs_and_missing_quantities_do_not_count) {
  const std::vector<RunErrors> runs{{"failed", 1, {unknown, unknown}}, {"good", 20, {3, unknown}}};
  const Recommendation r = recommend(runs, 5);
  EXPECT_EQ(r.run, 1);
  EXPECT_EQ(r.not_met, (std::vector<std::size_t>{1}));
  EXPECT_TRUE(std::isnan(r.best_error[1]));
  EXPECT_EQ(recommend({{"failed", 1, {unknown}}}, 5).run, -1);
  EXPECT_EQ(recommend({}, 5).run, -1);
}

}  // namespace
}  // namespace mv
