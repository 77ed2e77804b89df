// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Uniform cubic B-splines on an interval or a circle.

#include <Eigen/Core>
#include <array>

namespace mv {

/// Four basis functions that do not vanish at a point, with derivatives.
struct SplineValues {
  std::array<int, 4> index{};
  std::array<double, 4> value{};
};

/// Cubic B-splines with `segments` equal intervals on [0, length]; periodic ones have `segments` coefficients, others segments + 3.
/// Beyond the ends an open basis goes on as its outermost polynomial.
class SplineBasis {
 public:
  SplineBasis(int segments, double length, bool is_periodic) : segments_(segments), length_(length), is_periodic_(is_periodic) {}
  int size() const { return is_periodic_ ? segments_ : segments_ + 3; }
  int segments() const { return segments_; }
  double length() const { return length_; }
  bool is_periodic() const { return is_periodic_; }
  /// `derivative`: 0 to 3.
  SplineValues at(double x, int derivative = 0) const;
  /// Gram matrix of an operator: integral of (sum_d c_d N_i^(d)) (sum_d c_d N_j^(d)) over the interval, d = 0..3, by Gauss quadrature
  /// that is exact for cubics.
  Eigen::MatrixXd gram(const std::array<double, 4>& coefficients) const;

 private:
  int segments_;
  double length_;
  bool is_periodic_;
};

}  // namespace mv
