// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/mesh_stage.h"

#include <fmt/format.h>

#include "geometry/core/case_files.h"
#include "geometry/volume/leaflet_tets.h"

namespace mv {

LeafletMesh make_mesh(const Config& config, const SourceGeometry& source) {
  ThickenOptions options;
  options.thickness = config.number_in("mesh.thickness", "mm");
  options.layers = static_cast<int>(config.integer("mesh.layers"));
  options.order = static_cast<int>(config.integer("mesh.order"));
  return thicken(source.surface, options);
}

std::string run_mesh_stage(const StageContext& context) {
  const LeafletMesh mesh = make_mesh(context.config, read_source(context.in("mid_surface.vtp")));
  write_leaflets(context.out("leaflets.vtu"), mesh);
  return fmt::format("{} points, {} {} tetrahedra", mesh.points.size(), mesh.tets.size(),
                     mesh.order == 2 ? "quadratic" : "linear");
}

}  // namespace mv
