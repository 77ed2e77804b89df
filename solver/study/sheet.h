// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "solver/time/scene.h"

namespace mv {

/// A flat sheet across a rectangular tube, all four sides held, as a scene in memory: the ventricle's side below.
struct SheetShape {
  double width_mm = 24, depth_mm = 20, thickness_mm = 1;  // along x and y
  double solid_mm = 1;                                    // edge of the cells that are cut into six tetrahedra
  int order = 1, layers = 2;
  double fluid_mm = 2;
  double length_mm = 24;                                  // of the tube on either side
};

/// The mesh alone: tetrahedra of a structured grid, fibres along x, the sides' points on the annulus.
LeafletMesh sheet_mesh(const SheetShape& shape);

/// With tube and annulus; neo-Hookean, no chordae, no contact. `settings` are key=value.
Scene sheet_scene(const SheetShape& shape, const std::vector<std::string>& settings);

}  // namespace mv
