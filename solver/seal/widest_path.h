// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The widest way through the valve: the path of face-joined voxels whose smallest clearance is largest. Internal to solver/seal.

#include "solver/seal/voxel_field.h"

namespace mv::seal {

struct Passage {
  double upper = 0;           // bottleneck over the voxels' peaks: no wider ball passes (up to the search inside a voxel)
  double lower = 0;           // smallest clearance met on an explicit path: a ball this wide does pass
  Vec3 place = Vec3::Zero();  // tube frame; where the path is narrowest
};

/// Both values are 0 when the leaflets leave no path at all, infinite when there are no leaflets.
Passage find_widest_passage(const VoxelField& field);

}  // namespace mv::seal
