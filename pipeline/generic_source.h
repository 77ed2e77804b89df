// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/core/config.h"
#include "pipeline/source_file.h"

namespace mv {

/// The generic valve (papers/s0) on an ellipse or on a measured annulus, with its papillary tips. Reads the CSV files that
/// generic.annulus and generic.papillary name. Throws ConfigError, IoError, InputError, GateError.
SourceGeometry make_generic_source(const Config& config);

}  // namespace mv
