// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// A smooth closed surface around the leaflets of a label map.

#include <array>
#include <string>
#include <vector>

#include "geometry/core/case.h"
#include "geometry/image/label_map.h"

namespace mv {

struct LabelSurfaceOptions {
  double smoothing = 3;             // voxels, lambda of smooth_field.h
  int refine = 1;                   // nodes per voxel step of the grid on which the surface is drawn
  double volume_tolerance = 0.02;   // of the labels' volume
};

struct LabelSurface {
  std::vector<Vec3> points;                   // mm, RAS
  std::vector<std::array<int, 3>> triangles;  // closed, outward
  std::vector<int> region;                    // per triangle: Region of the nearest leaflet voxel
  double voxel_volume = 0;                    // mm3, of the leaflets' voxels
  double volume = 0;                          // mm3, enclosed
  double area = 0;                            // mm2
  double level = 0;                           // mm by which the surface was moved outwards to keep the volume
  double changed_share = 0;                   // of the leaflets' voxels whose centres ended outside, and of centres outside that ended inside
  int parts = 0;
  int handles = 0;                            // genus summed over the parts; a ring has 1
  int iterations = 0;
  std::vector<std::string> notes;
};

/// Smooth field, then the level of it that encloses the volume of the voxels, drawn by flying edges. Throws GateError when the volume cannot
/// be kept within the tolerance, InputError when nothing is left.
LabelSurface label_surface(const LabelledParts& parts, const LabelSurfaceOptions& options, const std::string& name);

}  // namespace mv
