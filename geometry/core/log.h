// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <spdlog/spdlog.h>

namespace mv {

/// How much goes to the log.
enum class LogLevel { quiet, normal, verbose };

/// Sends the log of spdlog (spdlog::info and friends) to stderr, so that stdout carries results only. Colours appear on a
/// terminal. `quiet` keeps warnings and errors, `verbose` adds debug lines. Call once, at the start of main; before that nothing
/// is set up.
void set_up_log(LogLevel level = LogLevel::normal);

}  // namespace mv
