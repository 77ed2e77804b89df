// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Does the valve seal? A verdict by topology (DESIGN, section 6), the smallest contact threshold at which it seals, and every
// hole with its place and area. Lengths in mm, points in the world frame. Method, limits and measurements: README.md.
//
// Clearance d(x): distance from x to the leaflets' boundary, 0 inside them. A ball of radius r passes the valve when a path
// joins ventricle to atrium inside the tube with d >= r all along. Leaflets grown by threshold / 2 leave no path exactly when
//     bottleneck = max over paths of (min of d along the path) < threshold / 2,
// so the smallest sealing threshold is 2 * bottleneck. A gap of width g between two leaflets closes at threshold g; the rigid
// tube wall is not grown, so a gap g between a leaflet and the wall closes at threshold 2 g.

#include <array>
#include <string>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

struct SealInput {
  std::vector<Vec3> points;                   // deformed
  std::vector<std::array<int, 3>> triangles;  // whole boundary of the solid: closed, consistently oriented (either way)
  std::vector<int> region;                    // Region per point, only for names; may be empty
  std::vector<Vec2> unfolded;                 // (u, v) per point, only for names; may be empty. u of one leaflet is one interval
  std::vector<Vec3> annulus;                  // closed loop at its present place, last point not repeated
  Tube tube;                                  // used: origin, axes, cross_section, z_ventricle, z_atrium
  Vec3 anterolateral = Vec3::Zero();          // direction from the posteromedial to the anterolateral side; zero: not known
};

struct SealOptions {
  double spacing_mm = 0.25;       // voxel size; a leaflet must be at least 2.4 voxels thick where it separates the two sides
  double ring_zone_mm = 1.5;      // within this height of the annulus curve ...
  double ring_growth_mm = 0.75;   // ... the wall is grown inwards by this much, and fills everything outside the curve
  double margin_mm = 1.5;         // voxels reach this far above and below the leaflets; beyond that the tube is open
  int max_cut_iterations = 4000;  // for the area of a hole
  double cut_gap = 0.02;          // relative duality gap at which the area is accepted
};

struct Hole {
  Vec3 place = Vec3::Zero();  // centroid of the smallest surface that closes it
  double area_mm2 = 0;        // area of that surface, counting what a ball as wide as the threshold can touch
  double area_error_mm2 = 0;  // duality gap of the minimum cut (numerical part of the error; voxel part: README)
  double width_mm = 0;        // widest ball that passes through this hole
  std::string location;       // e.g. "between A2 and P2", "anterolateral commissure", "P1"; "unnamed" without a map
  int region = 0;             // Region of the nearest leaflet, 0 when not known
  double u_mm = 0;            // u of the nearest leaflet point (0 without a map)
};

struct SealingThreshold {
  double value_mm = 0;        // seals at every threshold above this; infinity without leaflets
  double lower_mm = 0;        // certain: a path with this clearance (times two) was followed point by point
  Vec3 place = Vec3::Zero();  // where the last passage closes
  std::string location;       // its name, as for a hole
};

struct SealResult {
  bool sealed = false;   // smallest.value_mm < threshold_mm
  bool certain = false;  // false: the threshold lies between smallest.lower_mm and smallest.value_mm
  double threshold_mm = 0;
  SealingThreshold smallest;
  std::vector<Hole> holes;   // empty when sealed; largest first
  double hole_area_mm2 = 0;  // sum
  double spacing_mm = 0;
  long voxels = 0;
  double seconds = 0;
  std::vector<std::string> warnings;
};

/// Verdict at `threshold_mm` (> 0), smallest sealing threshold and holes. Throws InputError for a surface that is not closed,
/// indices out of range, a point that is not finite, an empty cross-section, or an annulus with fewer than three points.
SealResult find_seal(const SealInput& input, double threshold_mm, const SealOptions& options = {});

/// Only the smallest sealing threshold; same errors.
SealingThreshold smallest_sealing_threshold(const SealInput& input, const SealOptions& options = {});

}  // namespace mv
