// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// The pixels of one leaflet in one slice, cleaned: one mask per piece of leaflet that the slice cuts. OpenCV stays inside the .cpp.

#include <cstdint>
#include <string>
#include <vector>

#include "geometry/image/slice.h"
#include "geometry/image/slice_curves.h"

namespace mv {

/// Pixel-wise mask of a slice, row by row, 0 or 1.
using PixelMask = std::vector<std::uint8_t>;

PixelMask mask_of(const Slice& slice, SlicePart part);
/// Distance of each pixel's centre to the nearest pixel of the mask, in pixels; large where the mask is empty.
std::vector<float> distance_to_mask(const Slice& slice, const PixelMask& mask);

/// Connected groups of the mask after bridging and filling; largest first. `is_contact`: pixels that touch the wall.
std::vector<PixelMask> leaflet_groups(const Slice& slice, const PixelMask& mask, const PixelMask& is_contact, const SliceCurveOptions& options,
                                      const std::string& name, std::vector<std::string>& notes);

/// Connected clusters of contact pixels (gaps of one pixel closed), largest first, as pixel indices.
std::vector<std::vector<int>> contact_clusters(const Slice& slice, const PixelMask& contact);

}  // namespace mv
