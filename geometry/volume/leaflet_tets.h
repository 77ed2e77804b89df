// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Mid-surface plus thickness to layered tetrahedra (mm).

#include "geometry/core/case.h"
#include "geometry/generic/mid_surface.h"

namespace mv {

struct ThickenOptions {
  double thickness = 1;  // mm, where the surface has none of its own
  int layers = 2;        // >= 1
  int order = 1;         // 1: 4-node, 2: 10-node (C3D10) with straight edges
};

/// Level l = 0..layers of point i lies at x_i + (1/2 - l/layers) thickness_i n_i, with the surface's thickness or the options': level 0 is the atrial face. Each triangle and
/// layer is a prism, split into three tetrahedra by a total order of the mid-surface points, so neighbouring prisms share their
/// diagonals; the split of the ventricular half mirrors that of the atrial half. Point index of level l = l *
/// surface.points.size() + i for linear elements; mid-edge points follow. Fills every field of LeafletMesh; fibre is the tangent
/// parallel to the annulus plane, normalize(axis x sheet_normal) (direction of increasing u), for a fibre stage to replace. Point
/// flags of mid-edge points hold when they hold at both ends. Throws InputError for inconsistent sizes, ConfigError for
/// thickness, layers or order out of range. Volumes are not checked here: see gates.h.
LeafletMesh thicken(const MidSurface& surface, const ThickenOptions& options);

/// The same linear mesh with a point in the middle of every edge (VTK order).
LeafletMesh to_quadratic(const LeafletMesh& linear, double perimeter);

}  // namespace mv
