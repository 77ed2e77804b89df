// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

/// Lettering for drawings: the text as polylines, starting at `origin` (left end of the baseline), capitals `height` tall. Knows
/// letters, digits and . , : ; - + / ( ) % = < > ; anything else leaves a gap.
std::vector<std::vector<Vec2>> text_strokes(std::string_view text, const Vec2& origin, double height);

/// Width of the text as drawn.
double text_width(std::string_view text, double height);

}  // namespace mv
