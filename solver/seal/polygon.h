// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Small plane geometry shared by the seal's parts. Internal to solver/seal.

#include <span>

#include "geometry/core/case.h"

namespace mv::seal {

double signed_area(std::span<const Vec2> polygon);
bool polygon_contains(std::span<const Vec2> polygon, const Vec2& p);

/// Nearest point of a closed polygon: distance (not squared), index of the edge's first corner and position along that edge, 0
/// to 1.
struct NearestOnLoop {
  double distance = 0;
  std::size_t edge = 0;
  double along = 0;
};
NearestOnLoop nearest_on_loop(std::span<const Vec2> polygon, const Vec2& p);

}  // namespace mv::seal
