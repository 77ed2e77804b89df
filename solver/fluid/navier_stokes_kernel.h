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

/// Net outflow of q[i] through the two faces of its control volume across axis stride sd, advected by the velocity component `a` of that axis.
/// The advecting velocity at the upper face is the mean of a[i] and a[i + shift] one stride sd up, at the lower face of both as they are; shift is -stride of
/// q's own axis, also where that is sd. Indices instead of choices and moving pointers keep rows of cells fit for vector instructions.
inline double advective_outflow(const double* q, const double* a, std::ptrdiff_t i, std::ptrdiff_t shift, std::ptrdiff_t sd) {
  const double upper = 0.5 * (a[i + sd + shift] + a[i + sd]);
  const double lower = 0.5 * (a[i + shift] + a[i]);
  return upwind_flux(upper, q[i - sd], q[i], q[i + sd], q[i + 2 * sd]) - upwind_flux(lower, q[i - 2 * sd], q[i - sd], q[i], q[i + sd]);
}

}  // namespace mv
