// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What the report reads from RESULTS/.

#include <filesystem>
#include <optional>
#include <string>

#include "solver/output/contact_map.h"
#include "solver/output/series.h"
#include "solver/output/summary.h"
#include "solver/report/pictures.h"

namespace mv {

/// Parts whose file is not there are empty or null.
struct ResultsData {
  Json summary, run, quality, manifest;
  std::string case_toml;
  std::optional<SeriesTable> series, chordae;
  ValveFrames frames;
  std::optional<ContactMap> map;
};

/// Throws IoError when `results` or its summary.json is missing, InputError for a damaged file.
ResultsData read_results(const std::filesystem::path& results);

}  // namespace mv
