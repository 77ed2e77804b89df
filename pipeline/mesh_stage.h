// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "pipeline/source_file.h"
#include "pipeline/stage.h"

namespace mv {

/// Thickens the mid-surface to layers of tetrahedra. Writes leaflets.vtu, with fibres along the annulus until the stage fibers
/// has run.
std::string run_mesh_stage(const StageContext& context);

/// The same without files.
LeafletMesh make_mesh(const Config& config, const SourceGeometry& source);

}  // namespace mv
