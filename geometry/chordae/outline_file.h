// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Curves drawn by hand on the leaflets (fibre arcs).

#include <filesystem>
#include <vector>

#include "geometry/chordae/chordae_file.h"

namespace mv {

/// One list of points (mm, RAS) a curve. .csv: x_mm,y_mm,z_mm and, for several curves, a column `curve` (any text; a new value starts a new
/// curve); .vtp, .vtk: lines and polylines; .mrk.json: markups of 3D Slicer (curves, lines and point lists; its own coordinateSystem
/// counts, `space` does not). Throws IoError, InputError (file, line or array; fewer than two points in a curve, not finite).
std::vector<std::vector<Vec3>> read_outlines(const std::filesystem::path& file, ChordaeSpace space);

}  // namespace mv
