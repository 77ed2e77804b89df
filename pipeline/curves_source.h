// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// source.kind = "curves": segmented slices, or curves drawn in another program.

#include <nlohmann/json.hpp>

#include "geometry/core/config.h"
#include "geometry/loft/leaflet_curve.h"
#include "geometry/surface/raw_leaflets.h"
#include "pipeline/source_file.h"

namespace mv {

/// What curves.slices (NIfTI stack or PNG folder; labels by labels.preset and labels.*) and curves.files hold. Throws ConfigError, IoError, InputError naming
/// file, key or slice.
CurveSet read_curve_set(const Config& config);

/// The annulus and the B-spline surface through them; numbers go to `measures`.
RawLeaflets read_curve_leaflets(const Config& config, nlohmann::ordered_json& measures);

/// The same made into what the later stages read.
SourceGeometry make_curves_source(const Config& config);

}  // namespace mv
