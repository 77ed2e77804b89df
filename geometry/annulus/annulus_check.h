// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Whether measured points can be an annulus: what goes wrong between a segmentation tool and a file.

#include <string>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

/// `curve`: closed, mm, cleaned (closed_curve.h). Checked in the plane of its principal axes: its size (1 to 300 mm across), that it goes round its middle once and in
/// one sense (points in order, listed once), that no third of it is missing, and that it does not cross itself after smoothing by `harmonics` (0: as it is); loops shorter than a
/// twentieth of it are noise.
/// Returns what is odd, for a warning: a size no human annulus has, a long stretch without points. Throws InputError that begins with `name`.
std::vector<std::string> check_annulus_curve(const std::vector<Vec3>& curve, const std::string& name, int harmonics = 8);

/// Papillary points of the annulus `curve`: throws InputError when one lies more than 200 mm from its middle, returns a warning beyond 80 mm: another unit or space.
std::vector<std::string> check_papillary_points(const std::vector<Vec3>& points, const std::vector<Vec3>& curve, const std::string& name);

}  // namespace mv
