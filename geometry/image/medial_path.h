// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Paths through a mask on a fine square grid. Plain arrays; distances by OpenCV inside the .cpp.

#include <cstdint>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

/// A mask with its depth map: distance of each inside cell from the border, in cells (0 outside).
class MaskPaths {
 public:
  MaskPaths(int width, int height, std::vector<std::uint8_t> inside);

  int width() const { return width_; }
  int height() const { return height_; }
  bool is_inside(int cell) const { return inside_[static_cast<std::size_t>(cell)] != 0; }
  double depth(int cell) const { return depth_[static_cast<std::size_t>(cell)]; }
  Vec2 position(int cell) const { return {cell % width_, cell / width_}; }
  int nearest_inside(const Vec2& x) const;  // -1 when empty

  /// Geodesic distance in cells from the starts, 8 neighbours; infinity where it cannot be reached.
  std::vector<double> distances(const std::vector<int>& starts) const;
  /// Cheapest path from a to b for a cost of 1/depth^2 per cell: along the middle. Empty when there is none.
  std::vector<int> middle_path(int a, int b) const;
  /// From the middle of a path that runs into a corner at its end: cut where the rest is shorter than the depth there, and drawn on straight to the
  /// border. Positions, last one on the border.
  std::vector<Vec2> extended_end(const std::vector<Vec2>& path) const;

 private:
  std::vector<double> search(const std::vector<int>& starts, bool along_middle, std::vector<int>* previous, int target) const;

  int width_, height_;
  std::vector<std::uint8_t> inside_;
  std::vector<float> depth_;
};

}  // namespace mv
