// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Other programs, run on files.

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace mv {

/// Full path of a program in PATH; empty when there is none.
std::filesystem::path find_program(const std::string& name);

/// Starts a program without a shell; its standard output and error go to `log`, its standard input is empty. The caller waits for the process. Throws IoError when it cannot be started.
pid_t start_program(const std::filesystem::path& program, const std::vector<std::string>& arguments, const std::filesystem::path& log);

/// Runs a program without a shell, waits for it and returns its exit code, or 128 plus the signal that ended it. Its standard output and error go to `log`, its standard input is
/// empty. After `seconds` (0: never) it is killed and the result is `timed_out`. Throws IoError when it cannot be started,
/// Error (interrupted) after end_running_programs.
int run_program(const std::filesystem::path& program, const std::vector<std::string>& arguments, const std::filesystem::path& log, double seconds = 0);
inline constexpr int timed_out = -1;

/// Sends SIGTERM to what run_program is waiting for, from any thread; from then on it starts nothing.
void end_running_programs();

}  // namespace mv
