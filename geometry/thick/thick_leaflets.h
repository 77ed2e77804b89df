// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// The thick path: leaflets as they were measured, faces included, filled with tetrahedra without layers. The mid-surface still tells what is what: annulus, free edge, faces, pattern, leaflets.

#include <filesystem>
#include <string>
#include <vector>

#include "geometry/thick/tet_mesher.h"
#include "geometry/thick/thick_faces.h"

namespace mv {

/// One mesher's best mesh.
struct TetTrial {
  TetMesher mesher = TetMesher::gmsh;
  std::size_t points = 0, tets = 0;
  double dihedral_min = 0, dihedral_max = 0;  // degrees
  long below_limit = 0;                       // tetrahedra with an angle below the limit
  long too_long = 0;                          // tetrahedra whose corners are joined by a step longer than 1.25 spacings (gate_spacing_unlayered)
  std::string failure;                        // why there is no mesh
};

struct ThickReport {
  FaceFit fit;
  std::vector<TetTrial> trials;
  TetMesher kept = TetMesher::gmsh;
};

struct ThickOptions {
  double spacing = 0.5;        // mm, wanted edge
  double thickness = 1;        // mm, where the mid-surface has none of its own
  int layers = 2;              // triangles across the rims at least; `layer` of an element counts its depth in so many shares
  double dihedral_limit = 10;  // degrees
  double seconds = 180;        // for each mesher
  std::vector<TetMesher> meshers{TetMesher::tetgen, TetMesher::gmsh};
  std::filesystem::path directory = std::filesystem::temp_directory_path();  // for the meshers' files, which are removed
};

/// The boundary of thicken(surface) is moved on to `measured` (move_to_faces) and filled by each mesher; with tetrahedra of several sizes until no angle is below the limit and no step too long,
/// inner points relocated for it; kept is the mesh with the fewest angles below the limit, of equal ones one with steps too long in no more than
/// 0.05 % of its tetrahedra, then the one with the largest smallest angle. Linear tetrahedra. Fields as thicken() sets them: points on the boundary as in the layers, inner points `between`, unfolded position of the nearest point of the
/// mid-surface, fibre parallel to the annulus plane. Throws InputError, or IoError, when no mesher gives a mesh (with the reason of each).
LeafletMesh fill_leaflets(const MidSurface& surface, const SolidSurface& measured, const ThickOptions& options, ThickReport* report = nullptr);

}  // namespace mv
