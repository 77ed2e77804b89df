// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// The boundary of layered leaflets moved on to the faces that they were measured on.

#include <array>
#include <vector>

#include "geometry/surface/mid_surface_of_solid.h"
#include "geometry/volume/leaflet_tets.h"

namespace mv {

/// Boundary of layered leaflets: what tells annulus, free edge, faces and pattern apart goes with its points.
struct LeafletBoundary {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;  // closed, outward
  std::vector<int> region;                    // per triangle
  std::vector<char> on_annulus, on_free_edge;
  std::vector<int> side;
  std::vector<Vec2> unfolded;
};
LeafletBoundary boundary_of(const LeafletMesh& layers);

struct FaceFit {
  double before_mean = 0, before_max = 0;  // mm, distance of the faces' points from the measured surface
  double after_mean = 0, after_max = 0;
  long held_back = 0;                      // points that could not go all the way without folding a triangle
};

/// Moves the points to the nearest of the measured surface that looks the same way (within 60 degrees, no further than `reach`, mm), smoothed over the surface; points on the annulus stay.
/// Where a triangle would turn by more than 60 degrees or become slender (below 15 degrees, or less than half of what it had) its points stay behind.
FaceFit move_to_faces(LeafletBoundary& boundary, const SolidSurface& measured, double reach);

}  // namespace mv
