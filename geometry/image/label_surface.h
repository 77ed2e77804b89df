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
  double smoothing = 3;             // voxels, lambda of mesh_smoothing.h
  double reach = 0.6;               // voxels by which smoothing may move a point
  double hole_radius = 2.5;         // voxels: holes through the leaflets up to about twice as wide are filled
  double volume_tolerance = 0.02;   // of the labels' volume
};

struct LabelSurface {
  std::vector<Vec3> points;                   // mm, RAS
  std::vector<std::array<int, 3>> triangles;  // closed, outward
  std::vector<int> region;                    // per triangle: Region of the nearest leaflet voxel
  double voxel_volume = 0;                    // mm3, of the leaflets' voxels
  double volume = 0;                          // mm3, enclosed
  double area = 0;                            // mm2
  double offset = 0;                          // mm by which the smooth surface was moved along its normals to keep the volume
  long joined = 0;                            // voxels set to join sheets that hung together by edges or corners
  int parts = 0;
  int handles = 0;                            // genus summed over the parts; a ring has 1
  int iterations = 0;
  std::vector<std::string> notes;
};

/// Union of the leaflets' voxels, diagonals joined, zero level of the mask field by flying edges, smoothed along the surface, then moved along its
/// normals until it encloses the volume of the voxels. Throws GateError when the volume is not kept within the tolerance, InputError when
/// nothing is left.
LabelSurface label_surface(const LabelledParts& parts, const LabelSurfaceOptions& options, const std::string& name);

}  // namespace mv
