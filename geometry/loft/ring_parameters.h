// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// First guess of where curve points lie on the ring: u around, v from annulus to free edge.

#include "geometry/loft/hinge_annulus.h"
#include "geometry/loft/leaflet_curve.h"
#include "geometry/loft/spline_surface.h"

namespace mv {

/// The two eccentric angles at which the leaflets meet on the annulus, and which of them starts the anterior leaflet (counter-clockwise).
struct RingSplit {
  double to_anterior = 0, to_posterior = 0;  // angles at which the leaflet changes, going up
  double misplaced = 0;                      // share of the hinge points in the other leaflet's sector
};

bool is_in_anterior_sector(const RingSplit& split, double angle);

/// Best split of the hinge points by region. Throws InputError when only one leaflet is there, or more than a fifth of the points lie in
/// the other leaflet's sector (leaflets swapped in some curves).
RingSplit split_ring(const CurveSet& set, const HingeAnnulus& annulus);

/// One curve's data in order, with u in mm = angle * radius.
struct CurveData {
  std::vector<SurfaceDatum> data;
  std::vector<double> thickness;  // empty: not known
  std::vector<int> region;        // per datum
};

/// Curves resampled every `spacing`. A curve from annulus to free edge runs from its hinge's angle to the angle of its end, the ends of a leaflet being laid
/// out between the commissures by the length of the free edge; an arch from hinge to hinge, v from its distance to the annulus over
/// the height of the curves next to it. The first guess needs no star-shaped valve: closed leaflets keep their order around.
std::vector<CurveData> ring_parameters(const CurveSet& set, const std::vector<std::vector<int>>& regions, const HingeAnnulus& annulus,
                                       const RingSplit& split, double radius, double spacing);

}  // namespace mv
