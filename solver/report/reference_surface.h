// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A closed valve computed by another program, to compare with: legacy VTK (text or binary, also .gz), poly data or unstructured grid of triangles and quads.

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

struct ReferenceSurface {
  std::vector<Vec3> points;                                  // mm
  std::vector<std::array<int, 3>> triangles;                 // quads split from their first corner
  std::map<std::string, std::vector<double>> point_scalars;  // one value per point

  /// Points that triangles use, as flags.
  std::vector<char> is_on_surface() const;
};

/// Cells other than triangles and quads (types 5, 9 of an unstructured grid, POLYGONS of poly data) are left out, arrays of more than one component
/// skipped. Throws IoError when unreadable; InputError naming file, keyword and what was expected.
ReferenceSurface read_reference_surface(const std::filesystem::path& file);

}  // namespace mv
