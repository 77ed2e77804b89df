// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "pipeline/source_file.h"
#include "pipeline/stage.h"

namespace mv {

/// Reads the configuration (and the CSV files it names), builds the mid-surface and the papillary tips. Writes mid_surface.vtp,
/// papillary.vtp.
std::string run_generic_stage(const StageContext& context);

/// The same without files.
SourceGeometry make_generic_source(const Config& config);

}  // namespace mv
