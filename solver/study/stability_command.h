// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>

#include "geometry/core/errors.h"
#include "solver/study/stability.h"

namespace mv {

/// The command line of `mvsolve stability`.
class StabilityCommand {
 public:
  StabilityCommand(CLI::App& app, const std::atomic<bool>* is_interrupted);

  bool is_asked() const { return command_->parsed(); }

  /// Prints results on stdout. done, not_trustworthy (a case is neither stable nor refused), or interrupted. Throws UsageError, IoError.
  ExitCode run();

 private:
  CLI::App* command_;
  StabilityOptions options_;
  bool is_list_only_ = false;
};

}  // namespace mv
