// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Names of the leaflets. A mitral valve has the two of Region; a tricuspid valve has a third one.

#include <array>
#include <string>

#include "geometry/core/case.h"

namespace mv {

inline constexpr int septal = 3;       // besides Region::posterior and Region::anterior
inline constexpr int last_region = septal;

struct NamedRegion {
  int region;
  const char* name;  // as in the keys leaflet.NAME.*
};
inline constexpr std::array<NamedRegion, 3> leaflet_names{{{anterior, "anterior"}, {posterior, "posterior"}, {septal, "septal"}}};

/// "anterior", "posterior", "septal", or "" for another number.
inline std::string leaflet_name(int region) {
  for (const NamedRegion& leaflet : leaflet_names)
    if (leaflet.region == region) return leaflet.name;
  return "";
}

/// Leaflets other than the mitral valve's two: names by place (A2, P1), stress areas and generic chordae do not fit such a valve.
inline bool has_other_leaflets(const LeafletMesh& mesh) {
  for (const int region : mesh.region)
    if (region != posterior && region != anterior) return true;
  return false;
}

}  // namespace mv
