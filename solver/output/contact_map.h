// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The contact map of paper s0, Fig. 7: what the atrial faces carry, drawn on the unfolded (undeformed, flat) valve.

#include <array>
#include <filesystem>
#include <span>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

/// Triangulated atrial faces at (u, v) mm of the flat pattern. All point arrays have one entry per point.
struct ContactMap {
  std::vector<Vec2> points;  // mm
  std::vector<std::array<int, 3>> triangles;
  std::vector<double> contact_pressure;  // kPa
  std::vector<double> contact_force;     // N, magnitude
  std::vector<double> gap;      // mm to the facing leaflet, negative when they overlap; NaN where nothing faces the point
  std::vector<int> region;      // Region
  std::vector<char> in_belt;    // optional: the belt as contact.belt_* of the summary counts it
  std::vector<int> mesh_point;  // index of the point in LeafletMesh; two points of the map may share one at the seam
};

/// Atrial faces of `mesh` on the flat pattern with per-mesh-point data: Pa; N, xyz-interleaved; m (NaN where nothing faces the
/// point); `in_belt` may be empty. Faces that cross the pattern's seam (see unfolded_period) are drawn at its right end with
/// points of their own, so that no triangle spans the map.
ContactMap make_contact_map(const LeafletMesh& mesh, std::span<const double> contact_pressures,
                            std::span<const double> contact_forces, std::span<const double> gaps,
                            std::span<const char> in_belt = {});

/// contact_map.vtp: points (u, v, 0) in mm; point arrays contact_pressure_kPa, contact_force_N, gap_mm (NaN where nothing faces
/// the point), region, mesh_point and, when given, in_belt. Throws IoError.
void write_contact_map(const std::filesystem::path& file, const ContactMap& map);

/// Throws InputError, IoError.
ContactMap read_contact_map(const std::filesystem::path& file);

/// Triangles on the faces of `mesh` whose corners all lie on `side` and that belong to one element only, wound so that the normal
/// points out of the tissue. Quadratic faces give four triangles each.
struct FaceTriangles {
  std::vector<std::array<int, 3>> triangles;  // mesh point indices
  std::vector<int> element;                   // element each belongs to
};
FaceTriangles faces_on_side(const LeafletMesh& mesh, int side);

/// The whole boundary of the tissue, wound outwards.
FaceTriangles boundary_faces(const LeafletMesh& mesh);

}  // namespace mv
