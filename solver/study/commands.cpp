// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/commands.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <iostream>
#include <memory>

#include "geometry/core/parallel.h"
#include "solver/study/accuracy.h"
#include "solver/study/bench.h"

namespace mv {

std::function<void()> add_bench_command(CLI::App& app, const std::string& command_line) {
  auto options = std::make_shared<BenchOptions>();
  auto threads = std::make_shared<int>(0);
  auto has_no_parts = std::make_shared<bool>(false);
  CLI::App* command = app.add_subcommand("bench", "time per step by part, against the memory-bandwidth limit, sizes and threads");
  command->add_option("-o,--output", options->output, "directory for bench.csv, bench.json, scene_parts.csv and bench.html")->required();
  command->add_option("--case", options->case_directory, "time this case instead of the generic valve")->check(CLI::ExistingDirectory);
  command->add_option("--spacings", options->spacings_mm, "fluid spacings of the generic valve, mm (default 3 2 1.5)")->delimiter(',')->check(CLI::Range(0.2, 10.0));
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

std::function<void()> add_accuracy_command(CLI::App& app, const std::string& command_line) {
  auto options = std::make_shared<AccuracyOptions>();
  auto has_no = std::make_shared<std::array<bool, 3>>();
  CLI::App* command = app.add_subcommand("accuracy", "error against run time over ladders of settings, and the settings to use for an asked error");
  LadderOptions& ladder = options->ladder;
  command->add_option("-o,--output", ladder.output, "directory for accuracy.csv, accuracy.html, recommended.toml; runs that are there already are used again")->required();
  command->add_option("--spacings", ladder.spacings_mm, "fluid spacings of the closure, mm, coarse to fine; the finest is the reference (default 2.5 2 1.25 1, which divide the tube's length)")->delimiter(',')->check(CLI::Range(0.2, 10.0));
  command->add_option("--budget", ladder.budget, "seconds for runs that are not there yet; what does not fit is left out (default 1800)")->check(CLI::PositiveNumber);
  command->add_option("--jobs", ladder.jobs, "runs at a time, one thread each (default 1)")->check(CLI::Range(1, 256));
  command->add_option("--end", ladder.end, "simulated time of a closure, s (default 0.15)")->check(CLI::PositiveNumber);
  command->add_option("--window", ladder.window, "seconds at the end over which oscillating quantities are averaged (default 0.03)")->check(CLI::PositiveNumber);
  command->add_option("--table", options->table_file, "where the source of the built-in table goes (default DIR/recommended_table.cpp)");
  command->add_option("--mvprep", ladder.mvprep, "the program mvprep (default: beside mvsolve, then PATH)");
  command->add_flag("--fresh", ladder.is_fresh, "run again what is there");
  command->add_flag("--no-variations", (*has_no)[0], "resolutions only");
  command->add_flag("--no-known-answers", (*has_no)[1], "leave out the problems with a known answer");
  command->add_flag("--no-scene-parts", (*has_no)[2], "leave out the table of what a scene leaves out");
  command->add_flag("--small", options->is_small, "two runs only of each problem with a known answer");
  return [=, &command_line] {
    options->ladder.has_variations = !(*has_no)[0];
    options->has_known_answers = !(*has_no)[1];
    options->has_scene_parts = !(*has_no)[2];
    options->command_line = command_line;
    std::sort(options->ladder.spacings_mm.begin(), options->ladder.spacings_mm.end(), std::greater<>());
    std::cout << accuracy_text(run_accuracy(*options)) << "page = " << (options->ladder.output / "accuracy.html").string() << "\n";
  };
}

}  // namespace mv
