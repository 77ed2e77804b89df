// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// From a surface as a file holds it to an oriented manifold, with a report of each repair; and what kind of leaflets it shows.

#include <string>
#include <string_view>
#include <vector>

#include "geometry/surface/read_surface.h"

namespace mv {

enum class SurfaceKind {
  automatic,
  thick,        // closed surface of thick leaflets
  double_wall,  // both faces, open along the annulus: closed with a strip there, then like thick
  mid           // mid-surface
};
std::string_view to_string(SurfaceKind kind);

struct RepairOptions {
  SurfaceKind kind = SurfaceKind::automatic;
  double weld = 0;             // mm, points closer than this become one; 0: 1e-6 of the size
  double smallest_part = 0.02; // parts with a smaller share of the area are dropped as specks
  double largest_hole = 0.25;  // holes whose rim is shorter than this share of the size (diagonal of the box) are filled
};

struct RepairedSurface {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;  // manifold, oriented; closed and outward unless kind is mid
  std::vector<int> group;                     // as in the file; -1 for what was added
  SurfaceKind kind = SurfaceKind::thick;      // never automatic
  int parts = 0;
  long self_intersections = 0;                // pairs left
  std::vector<std::string> report;            // one line for each kind of repair: what, how many, where the first
};

/// Throws InputError: not orientable (Klein or Moebius-like), nothing left, a given kind that the surface does not have (open where
/// closed is asked for and no strip closes it), holes larger than allowed in a thick surface.
RepairedSurface repair_surface(const RawSurface& surface, const RepairOptions& options = {});

}  // namespace mv
