// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/annulus_stage.h"

#include <fmt/format.h>

#include "geometry/annulus/annulus_fit.h"
#include "geometry/core/case_files.h"

namespace mv {

Annulus make_annulus(const SourceGeometry& source, const Papillary& papillary) {
  NormalHints hints;
  hints.papillary_points = papillary.tips;
  return fit_annulus(source.annulus_curve, hints);
}

std::string run_annulus_stage(const StageContext& context) {
  const SourceGeometry source = read_source(context.in("mid_surface.vtp"));
  const Annulus annulus = make_annulus(source, read_papillary(context.in("papillary.vtp")));
  write_annulus(context.out("annulus.vtp"), annulus);
  const AnnulusMetrics m = measure_annulus(annulus, source.anterior_direction);
  return fmt::format(
      "perimeter {:.1f} mm, AP {:.1f} mm, AL-PM {:.1f} mm, height {:.1f} mm, plane residual {:.2f} mm, normal by {}", m.perimeter,
      m.ap_diameter, m.al_pm_diameter, m.height, annulus.residual_rms, annulus.sign_rule);
}

}  // namespace mv
