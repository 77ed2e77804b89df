// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Blood tube: the annulus' own outline extruded along its normal, body-fitted hexahedra, and the fluid grid around it (mm).

#include <string>
#include <vector>

#include "geometry/core/case.h"
#include "geometry/volume/gates.h"

namespace mv {

struct TubeOptions {
  double length_ventricle = 40;  // mm below the annulus plane
  double length_atrium = 20;     // mm above it
  double spacing = 1;            // mm, fluid grid
  int margin_cells = 3;          // cells around the tube's outline in e1 and e2
  double clearance = 0.25;       // mm between the wall and the outermost leaflet point at the annulus
  int harmonics = 12;            // smoothing of the outline
  double hex_size = 0;           // mm, size of the hexahedra across; 0: twice the spacing
  std::vector<Vec3> contained;   // points that must lie inside with the clearance: leaflet points
  std::vector<Vec3> tips;        // papillary tips: at least two fluid cells from the ventricular end
  bool widen_for_tips =
      false;  // real tips can lie outside the annulus' outline; a tube widened for them lets blood pass beside the annulus
};

/// What was changed so that everything fits.
struct TubeReport {
  double smoothing_max = 0;         // mm, largest distance of the outline from the projected annulus before widening
  double widened = 0;               // mm, largest outward shift of the outline
  double gap_min = 0, gap_max = 0;  // mm, wall to annulus points, in the plane
  double tips_outside = 0;          // mm, how far the outermost tip lies outside the wall (0 inside)
  double lengthened_ventricle = 0;  // mm beyond length_ventricle (rounding to whole cells included)
  double jacobian_min = 0;          // smallest scaled Jacobian at the corners of the hexahedra (1 = cube)
  std::vector<std::string> notes;   // sentences for the log
  std::vector<std::string> warnings;  // what is odd about the case that the tube is made for
};

/// Frame: origin of the annulus plane, e3 = -normal, e1 = axis_major. Outline in polar form r(angle) about the origin: smoothed
/// annulus, then widened smoothly until every annulus and contained point (with widen_for_tips every tip) is inside by the
/// clearance; a tip outside the wall is noted: the wall holds blood, not chordae. z_ventricle and z_atrium are whole cells; the
/// grid covers the outline's bounding box plus the margin in e1, e2 and exactly [z_ventricle, z_atrium]. Hexahedra: O-grid (a
/// central block and a ring), all corners with positive Jacobian. Throws ConfigError (lengths), InputError (annulus not
/// star-shaped), GateError (Jacobian).
Tube build_tube(const Annulus& annulus, const TubeOptions& options, TubeReport* report = nullptr);

/// Smallest scaled Jacobian over the corners of all hexahedra: det of the three unit edge vectors.
double smallest_scaled_jacobian(const Tube& tube);
/// Sum of the volumes of the hexahedra, mm3.
double hex_volume(const Tube& tube);
/// Gates "tube.jacobian_min" (at least 0.1), "tube.annulus_outside" (points outside the wall, 0) and "tube.tips_outside"
/// (papillary tips outside the fluid grid's box, 0).
std::vector<Gate> check_tube(const Tube& tube, const Annulus& annulus, const std::vector<Vec3>& tips);
/// Point inside the outline, cross-section coordinates.
bool inside_outline(const std::vector<Vec2>& outline, const Vec2& p);

}  // namespace mv
