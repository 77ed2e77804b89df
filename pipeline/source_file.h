// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// mid_surface.vtp: what a geometry source hands to the later stages.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "geometry/generic/mid_surface.h"

namespace mv {

struct SourceGeometry {
  MidSurface surface;
  std::vector<Vec3> annulus_curve;          // closed, ordered, smooth, mm
  Vec3 anterior_direction = Vec3::UnitY();  // unit, in the annulus plane
  double scale = 1;                         // lengths of the pattern over those of the configuration
  Papillary papillary;                      // written to papillary.vtp
  std::string summary;                      // one line for the user
  std::vector<std::string> notes;           // what was repaired, guessed or odd, for the log and the reader of source.json
  nlohmann::ordered_json measures = nlohmann::ordered_json::object();  // named numbers with units in their names: source.json
};

/// Everything but papillary, summary, notes and measures. Throws IoError.
void write_source(const std::filesystem::path& file, const SourceGeometry& source);
/// Throws IoError, InputError naming file and array.
SourceGeometry read_source(const std::filesystem::path& file);

}  // namespace mv
