// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "solver/report/raster.h"

namespace mv {

/// The picture as the bytes of a PNG file (8-bit RGB, zlib; ISO/IEC 15948). `pixels_per_mm` sets the printed size.
std::string encode_png(const Image& image, double pixels_per_mm = 8);

/// RFC 4648 base64.
std::string base64(const std::string& bytes);

}  // namespace mv
