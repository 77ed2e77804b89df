// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "geometry/image/label_map.h"

namespace mv {

struct PapillaryHead {
  Vec3 tip = Vec3::Zero();  // mm
  double prominence = 0;    // mm over the saddle to the next higher head of the same muscle; its whole height for the highest
};

/// Heads of the muscle(s) with the label `part`: each connected group of voxels (small ones left out) is sorted by height towards `valve`; a top
/// is a head when it rises by `prominence` over the saddle where it joins a higher one. The tip is the mean of the voxels of the head that
/// lie no more than `cap` below its top. Highest first.
std::vector<PapillaryHead> papillary_heads(const LabelImage& image, Part part, const Vec3& valve, double prominence, double cap);

}  // namespace mv
