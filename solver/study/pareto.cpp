// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/pareto.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace mv {

std::vector<std::size_t> pareto_front(const std::vector<CostError>& points) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (std::isfinite(points[i].error) && std::isfinite(points[i].seconds)) order.push_back(i);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return points[a].seconds != points[b].seconds ? points[a].seconds < points[b].seconds : points[a].error < points[b].error;
  });
  std::vector<std::size_t> front;
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t i : order)
    if (points[i].error < best) {
      best = points[i].error;
      front.push_back(i);
    }
  return front;
}

Recommendation recommend(const std::vector<RunErrors>& runs, double asked) {
  Recommendation out;
  out.asked = asked;
  const std::size_t quantities = runs.empty() ? 0 : runs.front().errors.size();
  std::vector<double> target;
  for (std::size_t q = 0; q < quantities; ++q) {
    double best = std::numeric_limits<double>::quiet_NaN();
    int cheapest = -1;
    for (std::size_t r = 0; r < runs.size(); ++r) {
      const double error = runs[r].errors[q];
      if (std::isfinite(error) && !(error >= best)) best = error;
      if (error <= asked && (cheapest < 0 || runs[r].seconds < runs[static_cast<std::size_t>(cheapest)].seconds)) cheapest = static_cast<int>(r);
    }
    out.best_error.push_back(best);
    out.cheapest.push_back(cheapest);
    target.push_back(std::isfinite(best) ? std::max(asked, recommendation_slack * best) : asked);
  }
  std::size_t most = 0;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    std::size_t count = 0;
    for (std::size_t q = 0; q < quantities; ++q) count += runs[r].errors[q] <= target[q];  // false for NaN
    const bool is_better = count > most || (count == most && count > 0 && runs[r].seconds < runs[static_cast<std::size_t>(out.run)].seconds);
    if (!is_better) continue;
    most = count;
    out.run = static_cast<int>(r);
  }
  for (std::size_t q = 0; q < quantities; ++q) (out.run >= 0 && runs[static_cast<std::size_t>(out.run)].errors[q] <= asked ? out.met : out.not_met).push_back(q);
  return out;
}

}  // namespace mv
