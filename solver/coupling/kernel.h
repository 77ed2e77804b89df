// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Regularised delta functions. phi(r), r in cells; the three-dimensional kernel is the product of three one-dimensional ones
// divided by h^3. For the composite kernel the one-dimensional factor depends on whether the axis is the component's own.

#include <algorithm>
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

/// Four neighbours along an axis in one vector register.
using Quad = double __attribute__((vector_size(8 * kernel_width_max)));

/// One-dimensional weights for the grid points first, first+1, ... (zero from `width` on); s is the point's coordinate in cells
/// relative to grid point 0. Weights sum to one.
struct KernelWeights {
  int first;
  int width;
  Quad w;
};

inline KernelWeights ib4_weights(double s) {
  const double below = std::floor(s);
  const double r = s - below;  // in [0, 1)
  const double q = std::sqrt(1.0 + 4.0 * r * (1.0 - r));
  return {static_cast<int>(below) - 1, 4, 0.125 * (Quad{3, 3, 1, 1} + r * Quad{-2, -2, 2, 2} + q * Quad{-1, 1, 1, -1})};
}

inline KernelWeights ib3_weights(double s) {
  const double nearest = std::floor(s + 0.5);
  const double r = s - nearest;  // in [-1/2, 1/2)
  auto outer = [](double a) { return (5.0 - 3.0 * a - std::sqrt(std::max(0.0, 1.0 - 3.0 * (1.0 - a) * (1.0 - a)))) / 6.0; };
  return {static_cast<int>(nearest) - 1, 3, Quad{outer(1.0 + r), (1.0 + std::sqrt(1.0 - 3.0 * r * r)) / 3.0, outer(1.0 - r), 0.0}};
}

inline KernelWeights bspline2_weights(double s) {
  const double below = std::floor(s);
  return {static_cast<int>(below), 2, Quad{1.0 - (s - below), s - below, 0.0, 0.0}};
}

inline KernelWeights bspline3_weights(double s) {
  const double nearest = std::floor(s + 0.5);
  const double r = s - nearest;
  return {static_cast<int>(nearest) - 1, 3, Quad{0.5 * (0.5 - r) * (0.5 - r), 0.75 - r * r, 0.5 * (0.5 + r) * (0.5 + r), 0.0}};
}

/// Weights of kernel K along an axis; `is_own_axis` tells whether it is the axis of the velocity component.
template <Kernel K>
inline KernelWeights kernel_weights(double s, bool is_own_axis) {
  if constexpr (K == Kernel::ib4) return ib4_weights(s);
  else if constexpr (K == Kernel::ib3) return ib3_weights(s);
  else return is_own_axis ? bspline3_weights(s) : bspline2_weights(s);
}

/// Width of kernel K along an axis.
template <Kernel K>
constexpr int kernel_width(bool is_own_axis) {
  return K == Kernel::ib4 ? 4 : K == Kernel::ib3 || is_own_axis ? 3 : 2;
}

}  // namespace mv
