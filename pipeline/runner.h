// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Runs stages, skipping those whose inputs and outputs are unchanged.

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "pipeline/manifest.h"

namespace mv {

struct StageReport {
  std::string stage;
  bool skipped = false;
  double seconds = 0;
  std::string result;  // one line from the stage
};
using OnStage = std::function<void(const StageReport&)>;

/// All stages in order. Those from `from` on run in any case. When one fails, its outputs and those of the stages that depend on
/// it are removed, so that no case remains whose parts do not belong together; quality.json of failed gates stays.
void run_all_stages(const Config& config, const std::filesystem::path& case_directory, Manifest manifest,
                    const std::optional<std::string>& from, const OnStage& on_stage);

/// One stage on what is there, also on files changed by hand. What depends on it is left as it is and counts as out of date; the
/// names of those stages are returned.
std::vector<std::string> run_one_stage(const std::string& name, const Config& config, const std::filesystem::path& case_directory,
                                       const OnStage& on_stage);

}  // namespace mv
