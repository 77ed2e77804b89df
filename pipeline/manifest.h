// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// CASE/manifest.json: what made the case. It holds no times, so that the same input gives the same bytes.

#include <filesystem>
#include <map>
#include <string>

#include "pipeline/stage.h"

namespace mv {

struct StageRecord {
  std::string key;                             // see stage_key
  std::map<std::string, std::string> outputs;  // file in the case -> SHA-256 when the stage had finished
};

struct Manifest {
  std::map<std::string, StageRecord> stages;
  std::map<std::string, std::string> inputs;  // file in the case's inputs/ -> SHA-256
};

/// Empty when there is none or it is of another version; InputError when it is damaged.
Manifest read_manifest(const std::filesystem::path& case_directory);

/// Writes stages, inputs, the resolved options and the versions of program and libraries. Throws IoError.
void write_manifest(const std::filesystem::path& case_directory, const Manifest& manifest, const Config& config);

/// Hash of all that decides a stage's result: its name, the program's build, the values of its configuration keys, the files
/// these name, and what the stages it needs have written. Empty when one of those has not run.
std::string stage_key(const Stage& stage, const Config& config, const Manifest& manifest);

/// Whether the recorded key is the present one and every output is on disk as the last stage that writes it has left it.
bool is_up_to_date(const Stage& stage, const Config& config, const Manifest& manifest,
                   const std::filesystem::path& case_directory);

/// Outputs of the stage that exist but differ from what was recorded: edited by hand, or damaged.
std::vector<std::string> changed_outputs(const Stage& stage, const Manifest& manifest,
                                         const std::filesystem::path& case_directory);

}  // namespace mv
