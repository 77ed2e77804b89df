// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/stage_table.h"

#include <algorithm>

#include "geometry/core/errors.h"
#include "pipeline/annulus_stage.h"
#include "pipeline/chordae_stage.h"
#include "pipeline/fibers_stage.h"
#include "pipeline/gates_stage.h"
#include "pipeline/mesh_stage.h"
#include "pipeline/source_stage.h"
#include "pipeline/tube_stage.h"

namespace mv {

const std::vector<Stage>& stage_table() {
  // clang-format off
  static const std::vector<Stage> table = {
      {"source", "mid-surface of the leaflets and papillary tips, from what source.kind names",
       {"source", "generic", "labels", "curves", "surface", "deck", "patient", "mesh.spacing", "mesh.thickness", "mesh.layers", "gates.min_dihedral"}, {}, {"mid_surface.vtp", "papillary.vtp", "source.json"}, run_source_stage},
      {"annulus", "annulus plane and its direction",
       {}, {"source"}, {"annulus.vtp"}, run_annulus_stage},
      {"mesh", "tetrahedra, in layers or (mesh.path) by TetGen and gmsh",
       {"mesh", "source.kind", "labels", "surface"}, {"source"}, {"leaflets.vtu"}, run_mesh_stage},
      {"chordae", "chordae with their insertions",
       {"chordae", "deck"}, {"source", "annulus", "mesh"}, {"chordae.vtp"}, run_chordae_stage},
      {"fibers", "collagen directions",
       {"fibers", "deck", "source.kind"}, {"annulus", "mesh", "chordae"}, {"leaflets.vtu"}, run_fibers_stage},
      {"tube", "blood tube and fluid grid",
       {"tube", "annulus.motion", "papillary.motion", "fluid.enabled"}, {"source", "annulus", "mesh"}, {"tube.vtu"}, run_tube_stage},
      {"gates", "checks of everything",
       {"gates", "mesh.layers", "mesh.path", "fibers", "fluid.enabled", "tube.spacing", "tube.contain_tips"}, {"source", "annulus", "mesh", "chordae", "fibers", "tube"},
       {"quality.json"}, run_gates_stage},
  };
  // clang-format on
  return table;
}

const Stage& find_stage(const std::string& name) {
  std::vector<std::string> names;
  for (const Stage& stage : stage_table()) {
    if (stage.name == name) return stage;
    names.push_back(stage.name);
  }
  throw UsageError("unknown stage '" + name + "'; did you mean '" + nearest_name(name, names) + "'?");
}

std::vector<std::string> stages_after(const std::string& name) {
  std::vector<std::string> later = {name};
  for (const Stage& stage : stage_table()) {
    const bool reads = std::any_of(stage.needs.begin(), stage.needs.end(), [&](const std::string& need) {
      return std::find(later.begin(), later.end(), need) != later.end();
    });
    if (reads) later.push_back(stage.name);
  }
  later.erase(later.begin());
  return later;
}

}  // namespace mv
