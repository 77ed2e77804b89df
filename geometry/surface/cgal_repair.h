// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Repairs that CGAL's Polygon Mesh Processing does (kept inside the .cpp). Internal to repair_surface.

#include "geometry/surface/soup_repair.h"

namespace mv {

/// Fills the hole along the rim (point indices, surface on the left); false and unchanged when that fails.
bool fill_hole(Soup& soup, const std::vector<int>& rim);

/// Replaces the surroundings of intersecting triangles by patches without intersections as far as CGAL manages; the surface has to be
/// an oriented manifold. Returns false when something was left or nothing could be done; groups are carried over from the nearest triangle.
bool remove_self_intersections(Soup& soup);

}  // namespace mv
