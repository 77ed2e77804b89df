// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/tube_stage.h"

#include <fmt/format.h>

#include "geometry/core/case_files.h"
#include "geometry/core/log.h"
#include "geometry/core/motion_table.h"

namespace mv {
namespace {

constexpr double odd_stretch = 0.4;  // of the annulus' length; life's stays below a fifth

double length_of(const std::vector<Vec3>& curve) {
  double length = 0;
  for (std::size_t i = 0; i < curve.size(); ++i) length += (curve[(i + 1) % curve.size()] - curve[i]).norm();
  return length;
}

/// All places of a moving annulus belong into the tube.
void contain_motion(const std::filesystem::path& file, const LeafletMesh& mesh, const Annulus& annulus, TubeOptions& options) {
  const MotionTable motion = MotionTable::read(file);
  const auto places = motion.places_of_annulus(mesh, file.string());
  const double rest = length_of(annulus.points);
  for (const double time : motion.times()) {
    std::size_t k = 0;
    for (std::size_t i = 0; i < mesh.points.size(); ++i)
      if (mesh.on_annulus[i]) options.contained.push_back(mesh.points[i] + motion.displacement(places[k++], time));
    std::vector<Vec3> moved = annulus.points;
    for (Vec3& p : moved) p += motion.displacement(motion.nearest(p), time);
    if (const double stretch = length_of(moved) / rest - 1; std::abs(stretch) > odd_stretch)
      spdlog::warn("tube: {}: at {:.4g} s the annulus is {:.0f} % {} than at rest; in life it changes by 5 to 20 %", file.string(), time, 100 * std::abs(stretch), stretch > 0 ? "longer" : "shorter");
  }
}

}  // namespace

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
  if (config.flag("fluid.enabled") && !config.text("annulus.motion").empty()) contain_motion(config.path("annulus.motion"), mesh, annulus, options);
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
