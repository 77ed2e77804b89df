// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>

namespace CLI {
class App;
}

namespace mv {

/// A study's command on the command line of mvsolve: adds its options to `app` and returns what runs it once the line is parsed. `command_line` is
/// read when it runs.
std::function<void()> add_bench_command(CLI::App& app, const std::string& command_line);
std::function<void()> add_accuracy_command(CLI::App& app, const std::string& command_line);

}  // namespace mv
