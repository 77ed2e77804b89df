// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Mid-surface and thickness of thick leaflets given as a closed surface (mm). Any pose, any genus: a ring with a hole in the middle, or
// separate thick leaflets. Method in geometry/surface/README.md:
//  1. Two faces. Each surface point looks inwards for the point opposite; "opposite" pairs and smooth neighbours give a signed graph whose
//     lowest eigenvector colours the two faces (+1, -1). Between them, over the rims, the colour s is harmonic on the surface.
//  2. Depth. Laplace's equation inside the solid, 0 and 1 on the faces, no flux through the rims (Jones, Buchbinder, Aharon 2000);
//     the mid-surface is the level 1/2, moved to the middle of its field line. It reaches the rims: nothing is lost at annulus and free edge.
//  3. Thickness: length of the field line through the point; within the rims, where lines end on the rim, continued from the inside.

#include <array>
#include <string>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

struct SolidSurface {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;  // closed, outward; several closed parts are allowed
  std::vector<int> label;                     // per triangle, any value (e.g. Region); empty: none
};

struct SolidMidOptions {
  double spacing = 0;  // mm, wanted edge of the mid-surface; 0: half the median thickness
  double voxel = 0;    // mm, grid on which the depth is solved; 0: a sixth of the median thickness, down to a twelfth when parts are thin;
                       // coarser when the solid would take more than max_voxels (said in a note)
  long max_voxels = 4'000'000;  // inside the solid
};

struct SolidMidSurface {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;  // open; consistently oriented per part: normal towards the face with s = +1
  std::vector<double> thickness;              // per point, mm
  std::vector<int> label;                     // per triangle: majority of the labels of the nearest solid triangles on both faces; empty
                                              // when the solid has none
  std::vector<double> face_colour;            // per point of the SOLID: s in [-1, 1]; |s| = 1 on the faces, in between over the rims
  double thickness_median = 0;                // mm, over the area of the mid-surface
  double voxel = 0;                           // mm, as used
  int parts = 0;                              // connected parts of the mid-surface
  std::vector<std::string> notes;             // what was dropped or is doubtful
};

/// Throws InputError when the surface is not closed, not consistently oriented, not finite, encloses nothing, or is no sheet: two
/// opposite faces are not found (a ball, a bulk thicker than wide).
SolidMidSurface mid_surface_of_solid(const SolidSurface& solid, const SolidMidOptions& options = {});

}  // namespace mv
