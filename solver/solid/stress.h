// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Stress and strain for output. Total elastic stress: law, volumetric term and distortion control; fluid pressure is not in it.

#include <span>
#include <vector>

#include "solver/solid/leaflet_solid.h"

namespace mv {

/// One entry per element; quadratic elements average their quadrature points by reference volume.
struct ElementStress {
  std::vector<double> von_mises;      // Pa, of the Cauchy stress P F^T / J
  std::vector<double> fibre_stress;   // Pa, f.sigma f with the current fibre direction f = F f0 / |F f0|
  std::vector<double> fibre_strain;   // |F f0| - 1, nominal strain along the fibre
  std::vector<double> J;
};

/// x: 3 n current positions (m).
ElementStress element_stress(const LeafletSolid& solid, std::span<const double> x);

/// Mean of an element quantity over the elements around each node, weighted with reference volume. Nodes without element get 0.
std::vector<double> average_to_nodes(const LeafletSolid& solid, std::span<const double> element_values);

}   // namespace mv
