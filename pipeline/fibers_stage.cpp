// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/fibers_stage.h"

#include "fibers/fiber_field.h"
#include "geometry/core/case_files.h"
#include "pipeline/deck_source.h"

namespace mv {

std::string run_fibers_stage(const StageContext& context) {
  LeafletMesh mesh = read_leaflets(context.in("leaflets.vtu"));
  if (context.config.text("fibers.model") == "source") {
    take_deck_fibres(context.config, mesh);
    write_leaflets(context.out("leaflets.vtu"), mesh);
    return "from the deck's orientations";
  }
  FiberOptions options;
  options.model = fiber_model_from_name(context.config.text("fibers.model"));
  assign_fibers(mesh, read_annulus(context.in("annulus.vtp")), options);
  write_leaflets(context.out("leaflets.vtu"), mesh);
  return "model " + context.config.text("fibers.model");
}

}  // namespace mv
