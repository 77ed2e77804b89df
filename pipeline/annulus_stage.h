// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "pipeline/source_file.h"
#include "pipeline/stage.h"

namespace mv {

/// Fits the plane of the annulus curve; the normal points away from the atrium, on the side of the papillary tips. Writes
/// annulus.vtp.
std::string run_annulus_stage(const StageContext& context);

/// The same without files.
Annulus make_annulus(const SourceGeometry& source, const Papillary& papillary);

}  // namespace mv
