// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/commands.h"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "geometry/core/parallel.h"
#include "solver/study/bench.h"

namespace mv {

std::function<void()> add_bench_command(CLI::App& app, const std::string& command_line) {
  auto options = std::make_shared<BenchOptions>();
  auto threads = std::make_shared<int>(0);
  auto has_no_parts = std::make_shared<bool>(false);
  CLI::App* command = app.add_subcommand("bench", "time per step by part, against the memory-bandwidth limit, sizes and threads");
  command->add_option("-o,--output", options->output, "directory for bench.csv, bench.json, scene_parts.csv and bench.html")->required();
  command->add_option("--case", options->case_directory, "time this case instead of the generic valve")->check(CLI::ExistingDirectory);
  command->add_option("--spacings", options->spacings_mm, "fluid spacings of the generic valve, mm (default 3 2 1.5)")->check(CLI::Range(0.2, 10.0));
  command->add_option("--threads", *threads, "largest number of threads (default: all cores); 1, 2, 4 ... up to it are timed")->check(CLI::Range(1, 1024));
  command->add_option("--steps", options->steps, "steps a repeat (default 100)")->check(CLI::Range(1, 100000));
  command->add_option("--repeats", options->repeats, "repeats, of which the median counts (default 3)")->check(CLI::Range(1, 1000));
  command->add_option("--at", options->at, "instant that is timed, s (default 0.06: closed)")->check(CLI::Range(0.0, 1000.0));
  command->add_option("--mvprep", options->mvprep, "the program mvprep (default: beside mvsolve, then PATH)");
  command->add_flag("--no-scene-parts", *has_no_parts, "leave out the table of what a scene leaves out");
  return [=, &command_line] {
    if (*threads > 0) set_thread_count(*threads);
    options->has_scene_parts = !*has_no_parts;
    options->command_line = command_line;
    std::cout << bench_text(run_bench(*options)) << "page = " << (options->output / "bench.html").string() << "\n";
  };
}

}  // namespace mv
