// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/image/label_image.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace mv {

double LabelImage::voxel_volume() const { return std::abs(axes.determinant()); }

LabelImage cropped(const LabelImage& image, const std::array<int, 3>& low, const std::array<int, 3>& high) {
  LabelImage part;
  part.axes = image.axes;
  part.origin = image.world(low[0], low[1], low[2]);
  for (std::size_t a = 0; a < 3; ++a) part.size[a] = high[a] - low[a] + 1;
  part.values.assign(static_cast<std::size_t>(part.size[0]) * static_cast<std::size_t>(part.size[1]) *
                         static_cast<std::size_t>(part.size[2]), 0);
  const int first = std::max(low[0], 0), last = std::min(high[0], image.size[0] - 1);
  if (first > last) return part;
  for (int k = std::max(low[2], 0); k <= std::min(high[2], image.size[2] - 1); ++k)
    for (int j = std::max(low[1], 0); j <= std::min(high[1], image.size[1] - 1); ++j)
      std::copy_n(image.values.begin() + static_cast<std::ptrdiff_t>(image.index(first, j, k)), last - first + 1,
                  part.values.begin() + static_cast<std::ptrdiff_t>(part.index(first - low[0], j - low[1], k - low[2])));
  return part;
}

}  // namespace mv
