// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstddef>

namespace mv {

/// Upwind-biased third-order flux (Leonard 1979) through a face between b and c, with a and d one further out: fourth-order central
/// flux minus |ua| times a third difference.
inline double upwind_flux(double ua, double a, double b, double c, double d) {
  constexpr double twelfth = 1.0 / 12.0;
  return twelfth * (ua * (7.0 * (b + c) - (a + d)) + std::abs(ua) * ((d - a) - 3.0 * (c - b)));
}

/// Net outflow of quantity q (component with stride sc) through the two faces of its control volume across axis stride sd, advected
/// by velocity component `a` of that axis.
inline double advective_outflow(const double* q, const double* a, std::ptrdiff_t sc, std::ptrdiff_t sd) {
  // For sd == sc both expressions are the mean of neighbouring faces of the same component.
  const double upper = sd == sc ? 0.5 * (a[0] + a[sd]) : 0.5 * (a[sd - sc] + a[sd]);
  const double lower = sd == sc ? 0.5 * (a[-sd] + a[0]) : 0.5 * (a[-sc] + a[0]);
  return upwind_flux(upper, q[-sd], q[0], q[sd], q[2 * sd]) - upwind_flux(lower, q[-2 * sd], q[-sd], q[0], q[sd]);
}

}  // namespace mv
