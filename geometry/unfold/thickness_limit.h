// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Thickness that the mid-surface can carry without folding or meeting itself. Internal to mv_unfold.

#include <string>
#include <vector>

#include "geometry/generic/mid_surface.h"

namespace mv {

/// Share of the radius of curvature that half the thickness may use.
inline constexpr double fold_share = 0.7;

/// Lowers surface.thickness (per point, must be filled) where an offset by half of it would fold or where the two sides or two leaflets would meet:
///  - curvature: kappa thickness / 2 <= fold_share, kappa the largest normal curvature along the edges of a point;
///  - meeting: triangles of the thick shell that intersect thin out their surroundings by steps of a fifth, as long as they are above `least` (mm);
///  - slender tetrahedra: where the leaflet in `layers` layers has dihedral angles below `dihedral_min` (degrees) its thickness is lowered by steps of a tenth, as long
///    as that makes them fewer; undone when more than a quarter is left. What is left is for the gate to report;
///  - slope: neighbours differ by at most half their distance, so that no step is left.
/// Returns what was done, one note per reason with share of the area and smallest value. Throws GateError when the shell still meets itself at
/// `least`, with the place.
std::vector<std::string> limit_thickness(MidSurface& surface, double least, int layers, double dihedral_min);

}  // namespace mv
