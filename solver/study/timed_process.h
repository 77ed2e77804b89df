// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace mv {

struct ProcessOutcome {
  int exit_code = 0;             // 128 + signal when it was killed
  double processor_seconds = 0;  // user and system time; with one thread what it takes on an idle core
  double wall_seconds = 0;
};

/// Runs a program to its end, its output in `log`. Throws IoError when it cannot be started.
ProcessOutcome run_timed(const std::filesystem::path& program, const std::vector<std::string>& arguments, const std::filesystem::path& log);

/// The running program's own file.
std::filesystem::path own_program();

}  // namespace mv
