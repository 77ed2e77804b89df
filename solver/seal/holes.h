// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Separate holes at a threshold: where the water shed from the two ends of the tube meets, and the least area that closes each.
// Internal to solver/seal.

#include <vector>

#include "solver/seal/voxel_field.h"

namespace mv::seal {

struct Opening {
  Vec3 place = Vec3::Zero();  // tube frame
  double area = 0;            // mm2, primal value of the minimum cut
  double area_error = 0;      // mm2, duality gap
  double width = 0;           // mm, widest ball that passes here
};

/// Openings through which a ball of diameter `threshold` passes; largest area first. Empty when none does.
std::vector<Opening> find_openings(const VoxelField& field, double threshold, const SealOptions& options);

}  // namespace mv::seal
