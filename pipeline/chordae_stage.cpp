// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/chordae_stage.h"

#include <fmt/format.h>

#include <set>

#include "geometry/annulus/annulus_fit.h"
#include "geometry/chordae/density_chordae.h"
#include "geometry/chordae/generic_chordae.h"
#include "geometry/chordae/segmented_chordae.h"
#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "geometry/core/log.h"
#include "pipeline/deck_source.h"
#include "pipeline/source_file.h"

namespace mv {
namespace {

constexpr double head_reach = 30;   // mm, of points of a papillary muscle from its tip
constexpr double unheld_edge = 18;  // mm of free edge to the next chorda

constexpr double cm_per_mm = 0.1;
constexpr double degrees = 57.29577951308232;

ChordaeOptions generic_options(const Config& config, double scale) {
  ChordaeOptions o;
  o.primary = static_cast<int>(config.integer("chordae.primary"));
  o.secondary = static_cast<int>(config.integer("chordae.secondary"));
  o.slack = config.number("chordae.slack");
  o.coaptation_depth = scale * config.number_in("chordae.coaptation_depth", "mm");
  o.area_primary = config.number_in("chordae.area_primary", "mm2");
  o.area_secondary = config.number_in("chordae.area_secondary", "mm2");
  o.bifurcated = config.flag("chordae.bifurcated");
  if (!config.is_auto("chordae.influence_radius")) o.radius = config.number_in("chordae.influence_radius", "mm");
  for (const double index : config.numbers("chordae.removed")) o.removed.push_back(static_cast<int>(index));
  return o;
}

SegmentedOptions file_options(const Config& config) {
  SegmentedOptions o;
  o.slack = config.number("chordae.slack");
  if (!config.is_auto("chordae.influence_radius")) o.radius = config.number_in("chordae.influence_radius", "mm");
  o.area_primary = config.number_in("chordae.area_primary", "mm2");
  o.area_secondary = config.number_in("chordae.area_secondary", "mm2");
  o.end_reach = config.number_in("chordae.end_reach", "mm");
  o.root_reach = config.number_in("chordae.root_reach", "mm");
  o.gap = config.number_in("chordae.gap", "mm");
  o.merge_runs = config.flag("chordae.merge_runs");
  o.defects = config.text("chordae.file_defects") == "drop" ? NetworkDefects::drop : NetworkDefects::refuse;
  o.refuse_loops = config.text("chordae.file_loops") == "refuse";
  return o;
}

DensityOptions density_options(const Config& config, double scale) {
  DensityOptions o;
  o.seed = static_cast<unsigned>(config.integer("chordae.seed"));
  o.border_density = config.number("chordae.border_density") * cm_per_mm;
  o.area_density = config.number("chordae.area_density") * cm_per_mm * cm_per_mm;
  o.area_from = config.number("chordae.area_from");
  o.area_to = config.number("chordae.area_to");
  o.struts = static_cast<int>(config.integer("chordae.struts"));
  o.branch_levels = static_cast<int>(config.integer("chordae.branch_levels"));
  o.branch_share = config.number("chordae.branch_share");
  o.branch_angle = config.number("chordae.branch_angle") * degrees;
  if (!config.is_auto("chordae.min_distance")) o.min_distance = config.number_in("chordae.min_distance", "mm");
  o.slack = config.number("chordae.slack");
  o.coaptation_depth = scale * config.number_in("chordae.coaptation_depth", "mm");
  o.area_primary = config.number_in("chordae.area_primary", "mm2");
  o.area_secondary = config.number_in("chordae.area_secondary", "mm2");
  if (!config.is_auto("chordae.influence_radius")) o.radius = config.number_in("chordae.influence_radius", "mm");
  for (const double index : config.numbers("chordae.removed")) o.removed.push_back(static_cast<int>(index));
  return o;
}

std::vector<Vec3> heads_of(const Config& config, const Papillary& papillary) {
  if (config.text("chordae.heads").empty()) return {};
  const auto file = config.path("chordae.heads");
  const std::vector<Vec3> heads = read_points_csv(file);
  for (const Vec3& head : heads) {
    double nearest = 1e300;
    for (const Vec3& tip : papillary.tips) nearest = std::min(nearest, (head - tip).norm());
    if (nearest > head_reach)
      throw InputError(fmt::format("{}: the point ({:.1f}, {:.1f}, {:.1f}) mm lies {:.0f} mm from the nearest papillary tip, more than {:.0f} mm: another unit or space, or of another valve?", file.string(), head.x(),
                                   head.y(), head.z(), nearest, head_reach));
  }
  return heads;
}

/// A free edge that no chorda holds flails into the atrium.
void warn_of_unheld_edge(const LeafletMesh& mesh, const Chordae& chordae) {
  std::set<std::size_t> ends;
  for (const Insertion& insertion : chordae.insertions) ends.insert(static_cast<std::size_t>(insertion.point));
  double longest = 0;
  Vec3 where = Vec3::Zero();
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    if (!mesh.on_free_edge[i]) continue;
    double nearest = 1e300;
    for (const std::size_t end : ends) nearest = std::min(nearest, (chordae.points[end] - mesh.points[i]).norm());
    if (nearest > longest) longest = nearest, where = mesh.points[i];
  }
  if (longest > unheld_edge)
    spdlog::warn("chordae: the free edge near ({:.1f}, {:.1f}, {:.1f}) mm is {:.0f} mm from the nearest chorda's end: what nothing holds flails; expected ends every 5 to 15 mm", where.x(), where.y(), where.z(), longest);
}

Chordae from_file(const StageContext& context, const LeafletMesh& mesh, const Papillary& papillary, std::string& summary) {
  const Config& config = context.config;
  if (config.text("chordae.file").empty())
    throw ConfigError("key 'chordae.file' is empty: chordae.model = \"file\" needs the network (.vtp, .vtk, .swc, .csv); or choose chordae.model = \"density\"");
  ChordaeFileOptions reading;
  reading.unit = config.text("chordae.file_unit");
  reading.space = config.text("chordae.file_space") == "lps" ? ChordaeSpace::lps : ChordaeSpace::ras;
  SegmentedReport report;
  Chordae chordae = attach_chordae(mesh, papillary, heads_of(config, papillary), read_chordae_file(config.path("chordae.file"), reading), file_options(config), &report);
  for (const std::string& note : report.notes) spdlog::warn("chordae: {}", note);
  summary = fmt::format("{} trees with {} branch points, {} roots, {} leaflet ends moved {:.2f} mm on average ({:.2f} at most); ", report.trees, report.branch_points, report.roots,
                        report.ends, report.end_moved_mean, report.end_moved_max);
  return chordae;
}

Chordae by_density(const StageContext& context, const LeafletMesh& mesh, const Annulus& annulus, const Papillary& papillary, double scale, std::string& summary) {
  DensityReport report;
  Chordae chordae = density_chordae(mesh, annulus, papillary, heads_of(context.config, papillary), density_options(context.config, scale), &report);
  for (const std::string& note : report.notes) spdlog::warn("chordae: {}", note);
  summary = fmt::format("{} border and {} inner ends, {} of them on branches, belt {:.1f} mm on average; ", report.border_ends, report.inner_ends, report.branched_ends, report.belt_mean);
  return chordae;
}

}  // namespace

std::string run_chordae_stage(const StageContext& context) {
  const std::string& model = context.config.text("chordae.model");
  Chordae chordae;
  std::string summary;
  if (model == "deck") {
    chordae = make_deck_chordae(context.config, read_leaflets(context.in("leaflets.vtu")));
  } else if (model != "none") {
    const SourceGeometry source = read_source(context.in("mid_surface.vtp"));
    const LeafletMesh mesh = read_leaflets(context.in("leaflets.vtu"));
    const Annulus annulus = read_annulus(context.in("annulus.vtp"));
    const Papillary papillary = read_papillary(context.in("papillary.vtp"));
    if (model == "file")
      chordae = from_file(context, mesh, papillary, summary);
    else if (model == "density")
      chordae = by_density(context, mesh, annulus, papillary, source.scale, summary);
    else
      chordae = generic_chordae(mesh, annulus, papillary, generic_options(context.config, source.scale));
  }
  if (!chordae.insertions.empty()) warn_of_unheld_edge(read_leaflets(context.in("leaflets.vtu")), chordae);
  write_chordae(context.out("chordae.vtp"), chordae);
  return summary + fmt::format("{} segments, {} insertion weights", chordae.segments.size(), chordae.insertions.size());
}

}  // namespace mv
