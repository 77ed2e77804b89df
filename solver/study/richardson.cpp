// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/richardson.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace mv {
namespace {

// Orders beyond these are not believed: the scheme claims no more than two, and less than a half says that the values hardly converge.
constexpr double lowest_order = 0.5, highest_order = 2.0;
constexpr double largest_observed = 12.0;
constexpr double safety = 1.25;

/// (h1^p - h2^p) / (h2^p - h3^p), increasing in p.
double ratio_of(const std::array<double, 3>& h, double p) {
  return (std::pow(h[0] / h[1], p) - 1) / (1 - std::pow(h[2] / h[1], p));
}

double observed_order(const std::array<double, 3>& h, double ratio) {
  double low = 1e-3, high = largest_observed;
  if (ratio <= ratio_of(h, low)) return low;
  if (ratio >= ratio_of(h, high)) return high;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (ratio_of(h, middle) < ratio ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

Richardson richardson(const std::array<double, 3>& spacing, const std::array<double, 3>& value) {
  if (!(spacing[0] > spacing[1] && spacing[1] > spacing[2] && spacing[2] > 0)) throw std::invalid_argument("richardson: spacings must decrease and be positive");
  Richardson out;
  out.extrapolated = value[2];
  out.order = std::numeric_limits<double>::quiet_NaN();
  const double coarse = value[0] - value[1], fine = value[1] - value[2];
  if (fine == 0 && coarse == 0) {
    out.is_monotone = true;
    return out;
  }
  out.is_monotone = coarse * fine > 0;
  if (!out.is_monotone) {
    const auto [low, high] = std::minmax_element(value.begin(), value.end());
    out.uncertainty = *high - *low;
    return out;
  }
  out.order = observed_order(spacing, coarse / fine);
  const double p = std::clamp(out.order, lowest_order, highest_order);
  out.extrapolated = value[2] - fine / (std::pow(spacing[1] / spacing[2], p) - 1);
  out.uncertainty = safety * std::abs(out.extrapolated - value[2]);
  return out;
}

}  // namespace mv
