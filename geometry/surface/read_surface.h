// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Surfaces from files as they come: STL (ascii, binary), OBJ, PLY (ascii, binary), VTP, legacy VTK. Nothing is repaired here.

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

struct RawSurface {
  std::vector<Vec3> points;                   // mm
  std::vector<std::array<int, 3>> triangles;  // polygons are cut into triangles
  std::vector<int> group;                     // per triangle: index into group_names; empty: the file has none
  std::vector<std::string> group_names;       // OBJ groups, objects or materials; labels of a VTK or PLY cell array as text
  std::vector<std::string> notes;             // polygons cut, lines ignored, units that disagree
};

/// The format is taken from the ending (.stl .obj .ply .vtp .vtk, any case); binary or ascii from the content. `unit`: unit of the
/// coordinates, "auto" (VTK files: their own record of it, else mm), or a length unit that the configuration knows.
/// Groups of VTK and PLY files: the first integer cell array named region, label, labels, leaflet, ModelFaceID, GroupIds or material.
/// Throws IoError when unreadable; InputError naming file, line or byte, what was found and expected: unknown ending, empty, truncated,
/// a count that the file is too small to hold, an index out of range, a coordinate that is not a finite number, no triangle.
RawSurface read_surface(const std::filesystem::path& file, const std::string& unit = "auto");

/// Throws InputError when the triangles' box is no size of a valve (diagonal from 5 to 300 mm), naming the units that would make it one.
/// `unit`: as given to read_surface.
void expect_valve_size(const RawSurface& surface, const std::string& name, const std::string& unit = "auto");

}  // namespace mv
