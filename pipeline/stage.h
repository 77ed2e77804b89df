// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// What every stage has in common.

#include <filesystem>
#include <string>
#include <vector>

#include "geometry/core/config.h"

namespace mv {

/// What a stage is given. It reads parts of the case through in() and writes new ones to out(), a directory that becomes part of
/// the case only when the stage succeeds.
struct StageContext {
  const Config& config;
  std::filesystem::path case_directory;
  std::filesystem::path output_directory;

  std::filesystem::path in(const std::string& name) const { return case_directory / name; }
  std::filesystem::path out(const std::string& name) const { return output_directory / name; }
};

struct Stage {
  std::string name;
  std::string help;
  std::vector<std::string> config_keys;     // prefixes of the keys that decide the result
  std::vector<std::string> needs;           // stages whose outputs are read
  std::vector<std::string> outputs;         // files in the case; a file named by two stages is completed by the later one
  std::string (*run)(const StageContext&);  // returns one line on what came out
};

}  // namespace mv
