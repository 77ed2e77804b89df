// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Chordae by density, for any valve with a flat pattern: ends per length of the free border and per area of the leaflets, dividing on
// their way as real ones do, from every head of both muscles.
//
// Border ends: one at every commissure and notch; the others share the arcs between them by length, evenly up to a random quarter of
// their spacing. Inner ends: of 24 random places the one farthest from all others (Mitchell 1991), never nearer than min_distance; two
// struts in the belly of the anterior leaflet.
// Branched: neighbouring border ends of one leaflet and muscle join in pairs, pairs of pairs, ... where the two branches meet under
// branch_angle in the closed shape.
// Rest lengths: along the tree in the closed shape (coapted_shape.h) x slack; in the open valve the branch points lie on the
// way from head to ends in the ratio of these lengths, and no segment starts stretched.
// A chorda that would pass through a leaflet on its way takes another head; an inner place without a free way is not used, a
// border one is moved along the border.

#include <optional>
#include <string>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

struct DensityOptions {
  unsigned seed = 1;
  double border_density = 0.2;         // ends per mm of free border
  double area_density = 0.006;         // inner ends per mm2 between area_from and area_to
  double area_from = 0.35, area_to = 0.8;  // share of the way from annulus to border
  int struts = 2;
  int branch_levels = 1;               // 2^levels ends to a branched chorda
  double branch_share = 0.6;           // of the border ends
  double branch_angle = 40;            // degrees
  std::optional<double> min_distance;  // mm, straight; default half of what the density gives
  double slack = 1.0;
  double coaptation_depth = 5.0;       // mm
  double area_primary = 0.4;           // mm2, of a border chorda where it leaves its muscle; branches share it
  double area_secondary = 0.8;         // mm2
  std::optional<double> radius;        // mm, influence radius R (R/2 on branches); default influence_radius()
  double end_inset = 0.2;              // a border end lies this share of R inside the border
  std::vector<int> removed;            // chordae to leave out: border ones along the border from the first commissure, struts, inner ones
};

struct DensityReport {
  int chordae = 0;        // trunks
  int border_ends = 0, inner_ends = 0;  // inner: with struts
  int branched_ends = 0;
  double border_spacing_min = 0;  // mm, along the border
  double inner_distance_min = 0;  // mm
  double inner_area = 0;          // mm2 between area_from and area_to
  int other_head = 0, moved = 0, left_out = 0;  // because of a leaflet in the way
  int crossings = 0;              // junction chordae kept although they pass through a leaflet
  int radius_enlarged = 0;
  double belt_mean = 0;           // mm, of the closed shape
  double belt_share = 0;          // of the meridians where both leaflets reach the belt
  std::vector<std::string> notes;
};

/// `heads`: points of the muscles (mm), each belonging to the nearest tip; a muscle without heads uses its tip. At least two tips on different
/// sides. Throws ConfigError (options, removed out of range), InputError (mesh, tips).
Chordae density_chordae(const LeafletMesh& mesh, const Annulus& annulus, const Papillary& papillary, const std::vector<Vec3>& heads, const DensityOptions& options,
                        DensityReport* report = nullptr);

}  // namespace mv
