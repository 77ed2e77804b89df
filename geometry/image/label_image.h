// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// A label map: whole numbers on a grid of voxels with its place in the world (RAS, mm).

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

/// Voxel (i, j, k) has its centre at axes * (i, j, k) + origin. The columns of `axes` are the steps along i, j, k in mm: any lengths,
/// oblique, left-handed allowed, never singular.
struct LabelImage {
  std::array<int, 3> size{0, 0, 0};
  Mat3 axes = Mat3::Identity();
  Vec3 origin = Vec3::Zero();
  std::vector<std::int32_t> values;  // i fastest, then j, then k

  std::size_t index(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * static_cast<std::size_t>(size[1]) + static_cast<std::size_t>(j)) *
               static_cast<std::size_t>(size[0]) + static_cast<std::size_t>(i);
  }
  std::int32_t at(int i, int j, int k) const { return values[index(i, j, k)]; }
  Vec3 world(const Vec3& voxel) const { return axes * voxel + origin; }
  Vec3 world(int i, int j, int k) const { return world(Vec3(i, j, k)); }
  Vec3 spacing() const { return axes.colwise().norm(); }  // mm
  double voxel_volume() const;                            // mm3
};

/// The part of the image from voxel `low` to `high` (both included), which may reach beyond it: there the value is 0.
LabelImage cropped(const LabelImage& image, const std::array<int, 3>& low, const std::array<int, 3>& high);

}  // namespace mv
