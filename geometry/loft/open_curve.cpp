// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/loft/open_curve.h"

#include <algorithm>
#include <cmath>

#include "geometry/loft/penalized_fit.h"
#include "geometry/loft/spline_basis.h"

namespace mv {
namespace {

constexpr double end_weight = 9;      // three times the accuracy
constexpr double knot_distance = 1.5;  // mm; leaflets bend no faster

}  // namespace

std::vector<Vec3> smooth_open_curve(const std::vector<Vec3>& points, double noise, double spacing) {
  if (points.size() < 4) return points;
  std::vector<double> s = {0};
  for (std::size_t i = 1; i < points.size(); ++i) s.push_back(s.back() + (points[i] - points[i - 1]).norm());
  const double length = s.back();
  if (!(length > 0)) return points;
  const SplineBasis basis(std::clamp(static_cast<int>(std::lround(length / knot_distance)), 2, 60), length, false);
  const auto n = static_cast<Eigen::Index>(points.size());
  Eigen::MatrixXd B = Eigen::MatrixXd::Zero(n, basis.size()), Y(n, 3);
  Eigen::VectorXd w = Eigen::VectorXd::Ones(n);
  w(0) = w(n - 1) = end_weight;
  const Vec3 base = points.front();
  for (Eigen::Index i = 0; i < n; ++i) {
    const SplineValues values = basis.at(s[static_cast<std::size_t>(i)]);
    for (std::size_t k = 0; k < 4; ++k) B(i, values.index[k]) += values.value[k];
    Y.row(i) = (points[static_cast<std::size_t>(i)] - base).transpose();
  }
  const Eigen::MatrixXd c = penalized_fit(B, w, Y, basis.gram({0, 0, 1, 0}), {SmoothingRule::discrepancy, noise, 0});
  const int steps = std::max(3, static_cast<int>(std::lround(length / spacing)));
  std::vector<Vec3> smooth;
  for (int i = 0; i <= steps; ++i) {
    const SplineValues values = basis.at(length * i / steps);
    Vec3 x = base;
    for (std::size_t k = 0; k < 4; ++k) x += values.value[k] * c.row(values.index[k]).transpose();
    smooth.push_back(x);
  }
  return smooth;
}

}  // namespace mv
