// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What the finest of three resolutions still lacks: f(h) = f0 + C h^p through three values (Richardson 1911; Roache, J. Fluids Eng. 116, 1994).

#include <array>

namespace mv {

struct Richardson {
  bool is_monotone = false;    // the values approach a limit from one side; only then an order is observed
  double order = 0;            // observed p, NaN without
  double extrapolated = 0;     // f0 with p limited to [0.5, 2]; the finest value when not monotone
  double uncertainty = 0;      // of the finest value, its unit: 1.25 |f3 - f0| (Roache's safety factor), or the range of the three values when they are not monotone
};

/// `spacing` from coarse to fine, strictly decreasing, any ratios; throws std::invalid_argument otherwise. Equal values are monotone and certain.
Richardson richardson(const std::array<double, 3>& spacing, const std::array<double, 3>& value);

}  // namespace mv
