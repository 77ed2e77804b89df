// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/chordae_stage.h"

#include <fmt/format.h>

#include "geometry/chordae/generic_chordae.h"
#include "geometry/core/case_files.h"
#include "pipeline/deck_source.h"
#include "pipeline/source_file.h"

namespace mv {
namespace {

ChordaeOptions options_of(const Config& config, double scale) {
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

}  // namespace

std::string run_chordae_stage(const StageContext& context) {
  Chordae chordae;
  if (context.config.text("chordae.model") == "deck") {
    chordae = make_deck_chordae(context.config, read_leaflets(context.in("leaflets.vtu")));
  } else if (context.config.text("chordae.model") != "none") {
    const SourceGeometry source = read_source(context.in("mid_surface.vtp"));
    chordae = generic_chordae(read_leaflets(context.in("leaflets.vtu")), read_annulus(context.in("annulus.vtp")),
                              read_papillary(context.in("papillary.vtp")), options_of(context.config, source.scale));
  }
  write_chordae(context.out("chordae.vtp"), chordae);
  return fmt::format("{} segments, {} insertion weights", chordae.segments.size(), chordae.insertions.size());
}

}  // namespace mv
