// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// What every patient source (label map, slices, surface, grown leaflets, deck) finds, before it becomes a case: a triangulated
// mid-surface with whatever else the data tell. Lengths mm, frame RAS.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

struct RawLeaflets {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;  // mid-surface; any size and shape; consistently oriented per connected part
  std::vector<int> region;                    // per triangle: Region, or 0 = not known; empty: none known
  std::vector<double> thickness;              // per point, mm; empty: uniform (mesh.thickness)

  std::vector<Vec3> annulus_curve;            // closed, ordered; empty: found from the surface's border
  std::vector<char> annulus_seen;             // per point of annulus_curve: 0 where the source bridged what it did not see; empty: all seen
  std::vector<Vec3> commissures;              // two points near the border, or empty: found from the regions or the outline
  std::vector<Vec3> papillary_points;         // insertion points or muscle tips; empty: none
  std::vector<std::string> papillary_names;   // per point: "anterolateral", "posteromedial" or "" = not known; empty: none known
  std::optional<Vec3> anterior_hint;          // a point on the anterior side (e.g. centre of the aortic valve)
  std::optional<Vec3> ventricle_direction;    // any vector with a positive component from atrium to ventricle

  std::vector<std::string> notes;             // what was repaired, guessed or odd; goes to the log and the report
};

}  // namespace mv
