// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Closed surfaces filled with tetrahedra by TetGen and by gmsh. Both run as programs on files: their libraries export the same symbols, and TetGen's licence asks for that distance.

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

/// TetGen: constrained Delaunay with quality bound (Si 2015), surface kept (-pqYa). gmsh: HXT (Marot, Pellerin & Remacle 2019) with optimisation.
enum class TetMesher { tetgen, gmsh };
std::string_view to_string(TetMesher mesher);

struct TetFill {
  std::vector<Vec3> points;               // the surface's first, unchanged and in their order
  std::vector<std::array<int, 4>> tets;   // positive volume
};

/// Fills a closed, oriented surface (mm) without moving or adding a point on it. `volume`: largest of a tetrahedron (mm3), asked for. Works in a directory of its own below `directory`. Throws IoError when the program is not installed (with the name of its package), InputError when it fails, takes longer than `seconds`, or changes the surface.
TetFill fill_surface(TetMesher mesher, const std::vector<Vec3>& points, const std::vector<std::array<int, 3>>& triangles, double volume, double seconds,
                     const std::filesystem::path& directory = std::filesystem::temp_directory_path());

}  // namespace mv
