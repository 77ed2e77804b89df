// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// One function a file format. Internal to read_surface: coordinates as in the file; each throws InputError naming file and place.

#include <filesystem>
#include <string>
#include <string_view>

#include "geometry/surface/read_surface.h"

namespace mv {

RawSurface parse_stl(const std::string& file, std::string_view text);  // equal corners become one point
RawSurface parse_obj(const std::string& file, std::string_view text);
RawSurface parse_ply(const std::string& file, std::string_view text);
/// Polygons, strips, and the triangles and quads of unstructured grids. `unit`: of the coordinates as this program records it, or empty.
RawSurface parse_vtk(const std::filesystem::path& file, bool is_xml, std::string& unit);

/// Cuts a polygon whose corners exist into triangles; group < 0: none.
void add_polygon(RawSurface& surface, const std::vector<int>& corners, int group);

}  // namespace mv
