// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// From a mask of voxels to a field whose zero level is a first, still stepped, surface of it.

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

/// Sheets one voxel thick hang together by edges and corners of their voxels only, which an isosurface cuts into a ladder. Sets further voxels
/// so that any two inside voxels that share an edge or corner are joined by faces within their common block (a well-composed mask, Latecki,
/// Eckhardt, Rosenfeld 1995): of the candidates the one with the most neighbours inside. Returns how many were set.
long join_diagonals(Mask& mask);

/// Fills small holes through sheets, those in which no ball of `radius` voxels (at most margin_voxels - 1) passes, with patches one voxel thick. A patch stays
/// only when it makes the Euler characteristic of the mask larger, i.e. a tunnel less and no bridge more: gaps between two sheets stay
/// open. Returns the number of holes; `set` counts the voxels.
int fill_holes(Mask& mask, double radius, long* set = nullptr);

struct MaskField {
  std::array<int, 3> refined{1, 1, 1};  // nodes per voxel along each axis
  std::array<int, 3> size{};            // nodes; node n lies at voxel n / refined
  std::vector<float> phi;               // mm, positive inside
};

/// phi = (d_out - d_in) / 2 with the distances to the nearest centre outside and inside. Of any surface that the voxels sample at their centres
/// -d_in <= signed distance <= d_out is known; phi is the middle of what is possible. The grid is refined along long axes of the voxels
/// until its steps are about equal.
MaskField mask_field(const Mask& mask);

}  // namespace mv
