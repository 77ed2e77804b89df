// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <filesystem>
#include <string>
#include <vector>

namespace mv {

struct RunOptions {
  std::filesystem::path case_directory;
  std::filesystem::path results;
  bool is_resumed = false;
  std::vector<std::string> settings;              // key=value, override case.toml
  std::string command_line;                       // for run.json
  const std::atomic<bool>* is_interrupted = nullptr;  // set by Ctrl-C: checkpoint and stop after the step
};

enum class RunEnd { finished, interrupted };

/// `mvsolve run`: reads the case, advances to time.end, writes RESULTS/ (DESIGN, section 2) with summary.json and report.html at the end.
/// On an interrupt it writes a checkpoint and returns. Throws TrustError (diverged, self-intersections, energy residual) after writing
/// the last readable frame and the summary, InputError, ConfigError, IoError.
RunEnd run_case(const RunOptions& options);

}  // namespace mv
