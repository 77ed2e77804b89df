// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// The leaflets' mid-surface: what any geometry source hands to the volume mesher (mm).

#include <array>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

struct MidSurface {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;  // counter-clockwise seen from the atrial face
  std::vector<Vec3> normals;                  // per point, unit, towards the atrial face (the inner side of the cone)
  std::vector<Vec2> unfolded;                 // per point, (u, v) mm; u in [0, perimeter)
  std::vector<char> on_annulus;               // per point
  std::vector<char> on_free_edge;             // per point
  std::vector<int> region;                    // per triangle, Region
  std::vector<double> thickness;              // per point, mm; empty: uniform, as the mesher is told
  double perimeter = 0;                       // period of u, mm; 0 when u is not periodic
  Vec3 axis = -Vec3::UnitZ();                 // annulus normal, atrium to ventricle
};

/// The three unfolded corners of a triangle with the period removed: corners near u = 0 are shifted by the perimeter when the
/// triangle lies at the end of the pattern.
std::array<Vec2, 3> unfolded_triangle(const MidSurface& surface, int triangle);

}  // namespace mv
