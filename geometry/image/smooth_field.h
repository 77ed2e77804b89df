// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// The smoothest signed distance that agrees with a mask: no stair steps, nothing lost of sheets one voxel thick.
//
// Of a surface that the voxels sample at their centres it is known that its signed distance phi (mm, positive inside) obeys, everywhere,
//     -d_in(x) <= phi(x) <= d_out(x),
// d_in and d_out being the distances to the nearest centre inside and outside the mask (phi has slope 1, phi >= 0 at centres inside, <= 0
// outside). Within these bounds we take the minimum of
//     sum (L phi)^2 + lambda^-4 (phi - (d_out - d_in) / 2)^2,      L = Laplacian with the voxel as unit of length along each axis,
// a convex problem (V. Lempitsky, CVPR 2010, with exact bounds and a term that holds the surface in the middle of what it may be). Waves
// shorter than 2 pi lambda voxels are smoothed away; distances to planes, and to spheres of any size, are left as they are by L L.

#include <array>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

/// A mask on voxels with perpendicular axes; the surface may not touch the border: leave margin_voxels of background.
struct Mask {
  std::array<int, 3> size{};
  Vec3 spacing = Vec3::Ones();  // mm
  std::vector<char> inside;     // per voxel, i fastest
  static constexpr int margin_voxels = 4;
};

struct SmoothField {
  std::array<int, 3> refined{1, 1, 1};  // nodes per voxel along each axis
  std::array<int, 3> size{};            // nodes; node n lies at voxel n / refined
  std::vector<float> phi;               // mm, positive inside
  int iterations = 0;
  double last_change = 0;               // mm
};

/// `lambda` in voxels, 0 gives (d_out - d_in) / 2. The grid is refined along long axes of the voxels until its steps are about equal, and
/// along all of them `refine` times.
SmoothField smooth_field(const Mask& mask, double lambda, int refine = 1);

}  // namespace mv
