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
  auto meets = [&](std::size_t r, std::size_t q) { return runs[r].errors[q] <= asked; };  // false for NaN
  std::size_t most = 0;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    std::size_t count = 0;
    for (std::size_t q = 0; q < quantities; ++q) count += meets(r, q);
    const bool is_better = count > most || (count == most && count > 0 && runs[r].seconds < runs[static_cast<std::size_t>(out.run)].seconds);
    if (!is_better) continue;
    most = count;
    out.run = static_cast<int>(r);
  }
  for (std::size_t q = 0; q < quantities; ++q) {
    int cheapest = -1;
    double best = std::numeric_limits<double>::quiet_NaN();
    for (std::size_t r = 0; r < runs.size(); ++r) {
      if (std::isfinite(runs[r].errors[q]) && !(runs[r].errors[q] >= best)) best = runs[r].errors[q];
      if (meets(r, q) && (cheapest < 0 || runs[r].seconds < runs[static_cast<std::size_t>(cheapest)].seconds)) cheapest = static_cast<int>(r);
    }
    out.cheapest.push_back(cheapest);
    if (out.run >= 0 && meets(static_cast<std::size_t>(out.run), q)) {
      out.met.push_back(q);
    } else {
      out.not_met.push_back(q);
      out.best_error.push_back(best);
    }
  }
  return out;
}

}  // namespace mv
