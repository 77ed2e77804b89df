// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>

#include "geometry/core/config.h"
#include "geometry/surface/mid_surface_of_solid.h"
#include "geometry/surface/raw_leaflets.h"
#include "pipeline/source_file.h"

namespace mv {

/// Label map (labels.file) to mid-surface, thickness, annulus, commissures and papillary tips as found; labels with their counts go to the
/// log, numbers to `measures`. Throws ConfigError, IoError, InputError, GateError naming file, label and key.
RawLeaflets read_label_leaflets(const Config& config, nlohmann::ordered_json& measures);

/// The closed surface of the leaflets alone, with a region per triangle. Throws as read_label_leaflets.
SolidSurface read_label_surface(const Config& config);

/// read_label_leaflets made into what the later stages read.
SourceGeometry make_labels_source(const Config& config);

}  // namespace mv
