// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Regularised delta functions. phi(r), r in cells; the three-dimensional kernel is the product of three one-dimensional ones
// divided by h^3. For the composite kernel the one-dimensional factor depends on whether the axis is the component's own.

#include <cmath>
#include <string>

namespace mv {

enum class Kernel {
  ib3,   // Roma, Peskin & Berger 1999: 3 points, zeroth and first moment
  ib4,   // Peskin 2002: 4 points, even-odd condition, first moment
  cbs32  // composite B-splines: quadratic along the component's own axis, linear across (Gruninger & Griffith); divergence-preserving
};

/// Throws std::invalid_argument for an unknown name.
Kernel kernel_from_name(const std::string& name);

/// Largest number of grid values an axis can touch.
inline constexpr int kernel_width_max = 4;

/// One-dimensional weights: writes `width` weights for the grid points first, first+1, ...; s is the point's coordinate in cells
/// relative to grid point 0. Weights sum to one.
struct KernelWeights {
  int first = 0;
  int width = 0;
  double w[kernel_width_max] = {0, 0, 0, 0};
};

inline KernelWeights ib4_weights(double s) {
  KernelWeights k;
  const double below = std::floor(s);
  const double r = s - below;  // in [0, 1)
  k.first = static_cast<int>(below) - 1;
  k.width = 4;
  const double q = std::sqrt(1.0 + 4.0 * r * (1.0 - r));
  k.w[0] = 0.125 * (3.0 - 2.0 * r - q);
  k.w[1] = 0.125 * (3.0 - 2.0 * r + q);
  k.w[2] = 0.125 * (1.0 + 2.0 * r + q);
  k.w[3] = 0.125 * (1.0 + 2.0 * r - q);
  return k;
}

inline KernelWeights ib3_weights(double s) {
  KernelWeights k;
  const double nearest = std::floor(s + 0.5);
  const double r = s - nearest;  // in [-1/2, 1/2)
  k.first = static_cast<int>(nearest) - 1;
  k.width = 3;
  auto outer = [](double a) { return (5.0 - 3.0 * a - std::sqrt(std::max(0.0, 1.0 - 3.0 * (1.0 - a) * (1.0 - a)))) / 6.0; };
  k.w[0] = outer(1.0 + r);
  k.w[1] = (1.0 + std::sqrt(1.0 - 3.0 * r * r)) / 3.0;
  k.w[2] = outer(1.0 - r);
  return k;
}

inline KernelWeights bspline2_weights(double s) {
  KernelWeights k;
  const double below = std::floor(s);
  k.first = static_cast<int>(below);
  k.width = 2;
  k.w[1] = s - below;
  k.w[0] = 1.0 - k.w[1];
  return k;
}

inline KernelWeights bspline3_weights(double s) {
  KernelWeights k;
  const double nearest = std::floor(s + 0.5);
  const double r = s - nearest;
  k.first = static_cast<int>(nearest) - 1;
  k.width = 3;
  k.w[0] = 0.5 * (0.5 - r) * (0.5 - r);
  k.w[1] = 0.75 - r * r;
  k.w[2] = 0.5 * (0.5 + r) * (0.5 + r);
  return k;
}

/// Weights of kernel K along an axis; `is_own_axis` tells whether it is the axis of the velocity component.
template <Kernel K>
inline KernelWeights kernel_weights(double s, bool is_own_axis) {
  if constexpr (K == Kernel::ib4) return ib4_weights(s);
  else if constexpr (K == Kernel::ib3) return ib3_weights(s);
  else return is_own_axis ? bspline3_weights(s) : bspline2_weights(s);
}

}  // namespace mv
