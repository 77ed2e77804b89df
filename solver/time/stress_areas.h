// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Fibre stress where users quote it: in the belly of the anterior leaflet and at the two trigones.

#include <array>
#include <span>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

/// Elements of the three areas. On the flat pattern, w the anterior leaflet's width along u and H its largest v:
///   belly     |u - middle| < w/6 and 0.25 H < v < 0.6 H: the clear part between annulus and contact belt;
///   trigones  0.05 w to 0.20 w from either end of the leaflet and 0.08 H < v < 0.30 H: beside the annulus at the leaflet's ends, clear
///             of the clamped row itself, whose stress grows without bound as the mesh gets finer.
/// An element belongs to the area its centre lies in. Through the whole thickness.
struct StressAreas {
  std::vector<int> belly;
  std::array<std::vector<int>, 2> trigone;  // nearer to papillary tip 0 (anterolateral), the other
};

/// Empty areas when the mesh has no anterior leaflet. `tips` (mm) order the trigones; without two of them they stay in the order of u.
StressAreas find_stress_areas(const LeafletMesh& rest, const std::vector<Vec3>& tips);

/// Mean over the elements, weighted with reference volume; NaN when there are none.
double mean_over(const LeafletMesh& rest, const std::vector<int>& elements, std::span<const double> element_values);

}  // namespace mv
