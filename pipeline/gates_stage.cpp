// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/gates_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "fibers/fiber_field.h"
#include "fibers/guides.h"
#include "geometry/annulus/annulus_fit.h"
#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "geometry/surface/self_intersection.h"
#include "geometry/tube/tube.h"
#include "geometry/volume/gates.h"
#include "pipeline/fibers_stage.h"
#include "pipeline/source_file.h"

namespace mv {
namespace {

GateLimits limits_of(const Config& config) {
  GateLimits limits;
  limits.dihedral_min = config.number_in("gates.min_dihedral", "deg");
  limits.dihedral_max = config.number_in("gates.max_dihedral", "deg");
  limits.layers = config.text("mesh.path") == "thick" ? 0 : static_cast<int>(config.integer("mesh.layers"));
  limits.fluid_spacing = config.flag("fluid.enabled") ? config.number_in("tube.spacing", "mm") : 0;
  limits.spacing_tolerance = 2 * config.number("gates.max_spacing_ratio");
  return limits;
}

/// With fibers.model = "none" every fibre must be zero instead of unit.
Gate gate_no_fibres(const LeafletMesh& mesh) {
  const FiberReport report = check_fibers(mesh, FiberModel::none);
  Gate gate{"leaflets.fibre_defect",  report.passed, report.passed ? 0.0 : 1.0, 0, "==", "",
            report.first_bad_element, report.message};
  if (gate.passed) gate.message = "no fibres, as asked for by fibers.model = \"none\"";
  return gate;
}

nlohmann::ordered_json measures(const LeafletMesh& mesh, const Annulus& annulus, const Tube& tube, const Chordae& chordae,
                                const Vec3& anterior_direction) {
  const AnnulusMetrics m = measure_annulus(annulus, anterior_direction);
  nlohmann::ordered_json json;
  json["leaflets.points"] = mesh.points.size();
  json["leaflets.tets"] = mesh.tets.size();
  json["leaflets.order"] = mesh.order;
  json["chordae.segments"] = chordae.segments.size();
  json["fluid.cells"] = static_cast<long>(tube.grid_cells[0]) * tube.grid_cells[1] * tube.grid_cells[2];
  json["fluid.spacing_mm"] = tube.grid_spacing;
  json["annulus.perimeter_mm"] = m.perimeter;
  json["annulus.ap_diameter_mm"] = m.ap_diameter;
  json["annulus.al_pm_diameter_mm"] = m.al_pm_diameter;
  json["annulus.height_mm"] = m.height;
  json["annulus.sphericity"] = m.sphericity;
  json["annulus.area_2d_mm2"] = m.area_2d;
  json["annulus.area_3d_mm2"] = m.area_3d;
  json["annulus.residual_rms_mm"] = annulus.residual_rms;
  json["annulus.sign_rule"] = annulus.sign_rule;
  return json;
}

const char* leaflet_name(int region) { return region == anterior ? "anterior" : "posterior"; }

/// Angles recomputed from the field as it is on disk, against the rule that made it.
nlohmann::ordered_json fibre_angles(const LeafletMesh& mesh, const Annulus& annulus, const FiberOptions& options) {
  nlohmann::ordered_json json;
  if (options.model == FiberModel::none) return json;
  for (int region : {static_cast<int>(anterior), static_cast<int>(posterior)})
    json["mean_angle_to_annulus_deg"][leaflet_name(region)] = mean_angle_to_annulus(mesh, annulus, region);
  json["rules"] = nlohmann::ordered_json::array();
  for (const RuleDeviation& r : deviation_from_rules(mesh, all_guide_points(mesh, annulus, options)))
    json["rules"].push_back({{"rule", r.rule}, {"leaflet", leaflet_name(r.region)}, {"points", r.points}, {"mean_deviation_deg", r.mean_deg}, {"max_deviation_deg", r.max_deg}});
  return json;
}

}  // namespace

std::string run_gates_stage(const StageContext& context) {
  const SourceGeometry source = read_source(context.in("mid_surface.vtp"));
  const LeafletMesh mesh = read_leaflets(context.in("leaflets.vtu"));
  const Chordae chordae = read_chordae(context.in("chordae.vtp"));
  const Tube tube = read_tube(context.in("tube.vtu"));
  const Annulus annulus = read_annulus(context.in("annulus.vtp"));
  const Papillary papillary = read_papillary(context.in("papillary.vtp"));

  GateReport report = check_leaflets(mesh, limits_of(context.config));
  if (context.config.text("fibers.model") == "none") {
    for (Gate& gate : report.gates) {
      if (gate.name == "leaflets.fibre_defect") gate = gate_no_fibres(mesh);
    }
  }
  report.gates.push_back(gate_self_intersection(mesh));
  if (!chordae.segments.empty()) {
    for (const Gate& gate : gate_insertions(mesh, chordae)) report.gates.push_back(gate);
  }
  const bool has_tips_inside = context.config.flag("tube.contain_tips");
  for (const Gate& gate : check_tube(tube, annulus, papillary.tips)) {
    if (has_tips_inside || gate.name != "tube.tips_outside") report.gates.push_back(gate);
  }

  nlohmann::ordered_json json = to_json(report);
  json["measures"] = measures(mesh, annulus, tube, chordae, source.anterior_direction);
  const std::string& model = context.config.text("fibers.model");
  const bool follows_rule = model != "source";  // a deck's own directions follow none
  if (follows_rule && check_fibers(mesh, fiber_model_from_name(model)).passed)
    json["fibers"] = fibre_angles(mesh, annulus, fiber_options(context.config, chordae));
  write_text_atomically(context.out("quality.json"), json.dump(2) + "\n");
  if (!report.passed()) throw GateError("gates not passed, see quality.json:\n" + report.failures());
  return fmt::format("{} gates passed", report.gates.size());
}

}  // namespace mv
