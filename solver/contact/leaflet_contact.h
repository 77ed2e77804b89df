// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "solver/contact/self_contact.h"

namespace mv {

/// Contact of leaflets of that thickness (m) under a largest pressure (Pa): faces push each other from a gap of `range` (m) on; the penalty carries the pressure at
/// a gap of a quarter of it and some seventeen times as much at touching, more than leaflets bear where they fold on each other. `factor` scales the stiffness.
inline ContactOptions leaflet_contact_options(double range, double thickness, double largest_pressure, double factor = 1.0) {
  constexpr double carrying_share = 0.75;  // overlap over range at which the pressure is carried
  constexpr double hardening = 20;
  // Wide enough that borders which cross at an angle see each other between their nodes.
  constexpr double averaging_ratio = 0.6;
  // Borders are sharp: they stay this share of the range further away than faces, so that they do not cut into them between nodes.
  constexpr double border_share = 0.4;
  ContactOptions o;
  o.threshold = range;
  o.thickness = thickness;
  o.hardening = hardening;
  o.averaging_ratio = averaging_ratio;
  o.border_offset = border_share * range;
  double hardened = 1;
  for (int power = 0; power < 12; ++power) hardened *= carrying_share;
  o.stiffness = factor * largest_pressure / (carrying_share * (1 + hardening * hardened) * range);
  return o;
}

}  // namespace mv
