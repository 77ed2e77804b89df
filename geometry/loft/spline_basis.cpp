// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/loft/spline_basis.h"

#include <algorithm>
#include <cmath>

namespace mv {
namespace {

/// Cubic cardinal B-spline pieces on t in [0, 1] and their derivatives by t.
std::array<double, 4> cardinal(double t, int derivative) {
  const double s = 1 - t;
  switch (derivative) {
    case 0: return {s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6, (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6, t * t * t / 6};
    case 1: return {-s * s / 2, (9 * t * t - 12 * t) / 6, (-9 * t * t + 6 * t + 3) / 6, t * t / 2};
    case 2: return {s, 3 * t - 2, -3 * t + 1, t};
    default: return {-1, 3, -3, 1};
  }
}

}  // namespace

SplineValues SplineBasis::at(double x, int derivative) const {
  const double h = length_ / segments_;
  double position = x / h;
  if (is_periodic_) position -= std::floor(position / segments_) * segments_;
  const int cell = std::clamp(static_cast<int>(std::floor(position)), 0, segments_ - 1);
  const auto pieces = cardinal(position - cell, derivative);
  const double scale = std::pow(h, -derivative);
  SplineValues values;
  for (int k = 0; k < 4; ++k) {
    values.index[static_cast<std::size_t>(k)] = is_periodic_ ? (cell + k) % segments_ : cell + k;
    values.value[static_cast<std::size_t>(k)] = scale * pieces[static_cast<std::size_t>(k)];
  }
  return values;
}

Eigen::MatrixXd SplineBasis::gram(const std::array<double, 4>& coefficients) const {
  constexpr std::array<double, 4> node = {-0.8611363115940526, -0.3399810435848563, 0.3399810435848563, 0.8611363115940526};
  constexpr std::array<double, 4> weight = {0.3478548451374538, 0.6521451548625461, 0.6521451548625461, 0.3478548451374538};
  const double h = length_ / segments_;
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(size(), size());
  for (int cell = 0; cell < segments_; ++cell)
    for (std::size_t g = 0; g < 4; ++g) {
      const double x = h * (cell + 0.5 * (1 + node[g]));
      SplineValues sum = at(x);
      for (double& v : sum.value) v *= coefficients[0];
      for (int d = 1; d < 4; ++d) {
        if (coefficients[static_cast<std::size_t>(d)] == 0) continue;
        const SplineValues term = at(x, d);
        for (std::size_t k = 0; k < 4; ++k) sum.value[k] += coefficients[static_cast<std::size_t>(d)] * term.value[k];
      }
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < 4; ++j)
          matrix(sum.index[i], sum.index[j]) += 0.5 * h * weight[g] * sum.value[i] * sum.value[j];
    }
  return matrix;
}

}  // namespace mv
