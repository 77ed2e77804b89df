// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Signs of orientation determinants of points with double coordinates, exact unless a product under- or overflows (coordinates
// between about 1e-90 and 1e90 in magnitude, or zero, are safe). A floating-point filter with a proven bound answers almost
// always; the rest is computed with expansions, sums of doubles that do not overlap (Shewchuk 1997, "Adaptive precision
// floating-point arithmetic").

#include <Eigen/Core>

namespace mv {

/// Sign of det[a - d, b - d, c - d]: +1, 0 or -1. Positive when d lies below the plane of a, b, c (counter-clockwise seen from
/// above).
int orientation_3d(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, const Eigen::Vector3d& d);

/// Sign of the area of the triangle (a, b, c) projected along coordinate axis `drop` (0, 1, 2).
int orientation_2d(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, int drop);

}  // namespace mv
