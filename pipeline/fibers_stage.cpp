// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/fibers_stage.h"

#include <fmt/format.h>

#include "geometry/chordae/outline_file.h"
#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "pipeline/deck_source.h"

namespace mv {

FiberOptions fiber_options(const Config& config, const Chordae& chordae) {
  FiberOptions options;
  options.model = fiber_model_from_name(config.text("fibers.model"));
  options.guide_from_chordae = options.model == FiberModel::arc && config.text("fibers.guide") == "chordae";
  options.chordae = &chordae;
  options.outline_reach = config.number_in("fibers.outline_reach", "mm");
  if (options.model != FiberModel::outline) return options;
  if (config.text("fibers.outline").empty())
    throw ConfigError("key 'fibers.outline' is empty: fibers.model = \"outline\" needs the drawn curves (.csv, .vtp, .mrk.json); or choose fibers.model = \"arc\"");
  options.outlines = read_outlines(config.path("fibers.outline"), config.text("fibers.outline_space") == "lps" ? ChordaeSpace::lps : ChordaeSpace::ras);
  return options;
}

std::string run_fibers_stage(const StageContext& context) {
  LeafletMesh mesh = read_leaflets(context.in("leaflets.vtu"));
  if (context.config.text("fibers.model") == "source") {
    take_deck_fibres(context.config, mesh);
    write_leaflets(context.out("leaflets.vtu"), mesh);
    return "from the deck's orientations";
  }
  const Chordae chordae = read_chordae(context.in("chordae.vtp"));
  assign_fibers(mesh, read_annulus(context.in("annulus.vtp")), fiber_options(context.config, chordae));
  write_leaflets(context.out("leaflets.vtu"), mesh);
  return "model " + context.config.text("fibers.model");
}

}  // namespace mv
