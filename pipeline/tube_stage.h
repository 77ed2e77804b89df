// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "geometry/tube/tube.h"
#include "pipeline/stage.h"

namespace mv {

/// Extrudes the annulus' outline to the blood tube and lays the fluid grid. Writes tube.vtu.
std::string run_tube_stage(const StageContext& context);

/// The same without files.
Tube make_tube(const Config& config, const Annulus& annulus, const LeafletMesh& mesh, const Papillary& papillary,
               TubeReport* report);

}  // namespace mv
