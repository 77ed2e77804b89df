// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "geometry/core/case.h"
#include "geometry/core/config.h"

namespace mv {

/// A case as read from CASE/, mm and RAS as in the files. Parts that the scene leaves out stay empty.
struct Scene {
  std::filesystem::path directory;
  Config config;
  LeafletMesh mesh;
  Chordae chordae;
  Tube tube;
  Annulus annulus;
  Papillary papillary;

  bool has_fluid() const { return config.flag("fluid.enabled"); }
  bool has_contact() const { return config.flag("contact.enabled"); }
  bool has_chordae() const { return !chordae.segments.empty(); }
};

/// Reads and cross-checks a case; `settings` are "key=value" strings that override case.toml. Throws IoError (missing file), InputError
/// (damaged or inconsistent file), ConfigError.
Scene load_scene(const std::filesystem::path& directory, const std::vector<std::string>& settings = {});

}  // namespace mv
