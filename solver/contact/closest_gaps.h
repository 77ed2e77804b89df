// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// How far every surface node is from the surface that faces it, in contact or not.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "solver/contact/candidates.h"
#include "solver/contact/surface.h"

namespace mv {

/// Gap of every surface node to the nearest triangle that faces it, however far up to the distance asked for.
struct ClosestGaps {
  std::vector<double> gap;             // m, signed distance (negative: behind the triangle); infinity when none
  std::vector<Eigen::Vector3d> point;  // closest point on the opposing surface
  std::vector<int> triangle;           // -1 when none
};

struct GapQuery {
  double max_distance = 0;       // m
  double penetration_limit = 0;  // m, triangles seen from deeper behind do not count
  bool atrial_only = false;      // atrial nodes against atrial triangles only
};

/// Nearest facing triangle (normals more than 102 degrees apart) that `rule` does not exclude. `guesses`: a triangle per node to
/// start from, or -1, or empty; good ones, and those of the last call left in `out`, save time, the answer does not depend on them. Reuses the vectors in `out`. Throws
/// TrustError when x is not finite. Same bytes for every thread count.
void closest_gaps(const ContactSurface& surface, const CandidateSearch& rule, std::span<const double> x, const GapQuery& query,
                  std::span<const int> guesses, ClosestGaps& out);

}  // namespace mv
