// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/tube_stage.h"

#include <fmt/format.h>

#include "geometry/core/case_files.h"
#include "geometry/core/log.h"

namespace mv {

Tube make_tube(const Config& config, const Annulus& annulus, const LeafletMesh& mesh, const Papillary& papillary,
               TubeReport* report) {
  TubeOptions options;
  options.length_ventricle = config.number_in("tube.length_ventricle", "mm");
  options.length_atrium = config.number_in("tube.length_atrium", "mm");
  options.spacing = config.number_in("tube.spacing", "mm");
  options.margin_cells = static_cast<int>(config.integer("tube.margin_cells"));
  options.clearance = config.number_in("tube.clearance", "mm");
  options.harmonics = static_cast<int>(config.integer("tube.harmonics"));
  options.contained = mesh.points;
  if (config.flag("tube.contain_tips")) options.tips = papillary.tips;
  return build_tube(annulus, options, report);
}

std::string run_tube_stage(const StageContext& context) {
  TubeReport report;
  const Tube tube = make_tube(context.config, read_annulus(context.in("annulus.vtp")), read_leaflets(context.in("leaflets.vtu")),
                              read_papillary(context.in("papillary.vtp")), &report);
  for (const std::string& note : report.notes) spdlog::info("tube: {}", note);
  write_tube(context.out("tube.vtu"), tube);
  const auto& n = tube.grid_cells;
  return fmt::format("{} fluid cells ({} x {} x {}) of {} mm, {} hexahedra, wall {:.2f} to {:.2f} mm from the annulus",
                     static_cast<long>(n[0]) * n[1] * n[2], n[0], n[1], n[2], tube.grid_spacing, tube.hexes.size(),
                     report.gap_min, report.gap_max);
}

}  // namespace mv
