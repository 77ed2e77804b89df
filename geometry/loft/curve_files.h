// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Leaflet curves drawn in another program: CSV, VTK poly data, 3D Slicer markups.

#include <filesystem>

#include "geometry/loft/leaflet_curve.h"

namespace mv {

/// Adds the curves of a file to `set`, by its extension. Points in order from annulus to free edge, mm.
/// .csv       columns leaflet, curve, x_mm, y_mm, z_mm, optionally thickness_mm, in any order; leaflet: anterior, posterior, annulus (closed curve), papillary,
///            papillary_anterolateral, papillary_posteromedial; rows of one leaflet and curve form a curve.
/// .vtp       polylines; cell array `leaflet` or `region` (1 posterior, 2 anterior); without it the file's name tells the leaflet.
/// .mrk.json  Slicer markups: Curve, Line = leaflet curve; ClosedCurve = annulus; Fiducial = papillary points. The leaflet is found in the markup's
///            name, or the file's ("anterior", "posterior"). Coordinates: its own coordinateSystem, LPS or RAS.
/// `is_lps`: coordinates of files that do not say (CSV, and VTP without field data SPACE) are LPS; the set is RAS in any case.
/// Throws IoError when unreadable, InputError naming file, line or element and what was expected.
void read_curves(const std::filesystem::path& file, bool is_lps, CurveSet& set);

/// Region by a name: "anterior", "AML", ... ; 0 when it tells neither or both.
int region_of_name(const std::string& name);

}  // namespace mv
