// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// The measured annulus used by the geometry tests: configs/data in the project, else the optional data folder beside it.

#include <filesystem>
#include <optional>

namespace mv::test {

inline std::optional<std::filesystem::path> real_annulus_folder() {
  const std::filesystem::path source = MV_SOURCE_DIR;
  for (const auto& folder : {source / "configs/data/normal_1", source / "../shared/data/normal_1"})
    if (std::filesystem::exists(folder / "normal_1_annulus_mm.csv")) return folder;
  return std::nullopt;
}

}  // namespace mv::test
