// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>

#include "geometry/core/config.h"
#include "geometry/surface/mid_surface_of_solid.h"
#include "geometry/surface/raw_leaflets.h"
#include "geometry/surface/read_surface.h"
#include "pipeline/source_file.h"

namespace mv {

/// Tips of papillary muscles given as surfaces, one a connected part of at least a twentieth of the area: mean of the surface within 2 mm of the
/// part's top, heights taken from its centre towards `valve`. Throws InputError for a part whose centre is the valve's.
std::vector<Vec3> muscle_tips(const RawSurface& muscles, const Vec3& valve, const std::string& name);

/// Surface of leaflets (surface.file), repaired, to mid-surface, thickness and papillary tips (surface.papillary); every repair becomes a
/// note, numbers go to `measures`. Triangles in groups whose name holds "anterior" or "posterior" get that region.
/// Throws ConfigError, IoError, InputError naming file and key.
RawLeaflets read_surface_leaflets(const Config& config, nlohmann::ordered_json& measures);

/// The repaired closed surface alone, with a region per triangle where groups name it. Throws ConfigError when the surface is a mid-surface, and what read_surface_leaflets throws.
SolidSurface read_thick_surface(const Config& config);

/// read_surface_leaflets made into what the later stages read.
SourceGeometry make_surface_source(const Config& config);

}  // namespace mv
