// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Which of its two faces each point of a thick sheet's closed surface belongs to. Internal to mid_surface_of_solid and the thick path.

#include <string>
#include <vector>

#include "geometry/surface/mid_surface_of_solid.h"

namespace mv {

struct SolidFaces {
  // The solid's surface with long edges halved until none is longer than a quarter of the thickness; the first points are the solid's own.
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;
  std::vector<int> parent;        // per triangle: the solid's triangle it lies in
  std::vector<Vec3> normals;      // per point, unit, outward, averaged over a quarter of the thickness
  std::vector<double> thickness;  // per point: diameter of the largest inner ball touching there where it touches the opposite face; else 0
  std::vector<double> colour;     // per point: s in [-1, 1]
  double thickness_median = 0;    // mm, over the area
  double thickness_thin = 0;      // mm, a tenth of the area is thinner
  double paired_share = 0;        // share of the area that found an opposite
  double frustrated_share = 0;    // share of the pairs that ended on the same face
};

/// Throws InputError (not closed, not oriented, not finite, no opposite faces) as mid_surface_of_solid says.
SolidFaces colour_solid_faces(const SolidSurface& solid);

/// What middles of (about 3000) triangles of an oriented surface, open or closed, see across: share of their area that finds an
/// opposite face, and its median distance (mm). inwards: against the normals.
struct OppositeFaces {
  double share = 0, thickness = 0;
};
OppositeFaces opposite_faces(const std::vector<Vec3>& points, const std::vector<std::array<int, 3>>& triangles, bool inwards);

/// Throws InputError naming the defect: index out of range, not finite, an edge without or with more than one opposite, no volume.
/// Returns the enclosed volume (mm3).
double check_closed_surface(const std::vector<Vec3>& points, const std::vector<std::array<int, 3>>& triangles);

/// Same surface, no edge longer than `longest` (edges are halved, neighbours conform) as long as there are fewer than max_points.
/// parent: per new triangle, index of the old one.
void halve_long_edges(std::vector<Vec3>& points, std::vector<std::array<int, 3>>& triangles, std::vector<int>& parent, double longest,
                      std::size_t max_points);

}  // namespace mv
