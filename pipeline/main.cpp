// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>

#include "geometry/core/errors.h"
#include "geometry/core/log.h"
#include "geometry/core/version.h"
#include "pipeline/commands.h"
#include "pipeline/compare_cases.h"
#include "pipeline/exit_status.h"
#include "pipeline/interrupt.h"
#include "pipeline/layout.h"
#include "pipeline/source_stage.h"
#include "pipeline/stage_table.h"

namespace {

constexpr const char* exit_codes =
    "Exit codes: 0 done, 2 usage, 3 config, 4 input data, 5 geometry or mesh gate, 7 input/output, 70 our bug, 130 interrupted.";

const CLI::Validator not_empty([](const std::string& text) { return text.empty() ? std::string("is empty; expected the name of a directory") : std::string(); }, "DIR");

void add_settings(CLI::App& command, std::vector<std::string>& settings) {
  command.add_option("--set", settings, "Override one key, e.g. --set mesh.spacing=\"0.7 mm\"; may be repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
}

void add_config_and_case(CLI::App& command, mv::RunOptions& options) {
  command.add_option("-c,--config", options.config, "Configuration (TOML); `mvprep config` prints one with every key")
      ->required();
  command.add_option("-o,--output", options.case_directory, "Case directory to write")->required()->check(not_empty);
  add_settings(command, options.settings);
}

/// Builds the command line, runs the chosen command.
void run(int argc, char** argv) {
  CLI::App app{"mvprep: from a description of a mitral valve to a simulation-ready case", "mvprep"};
  app.footer(exit_codes);
  app.require_subcommand(1);
  app.set_version_flag("--version", "mvprep " + mv::version() + " (" + mv::git_revision() + ")");
  bool is_verbose = false, is_quiet = false;
  app.add_flag("-v,--verbose", is_verbose, "More log on stderr");
  app.add_flag("-q,--quiet", is_quiet, "Only warnings and errors on stderr");
  app.fallthrough();
  const auto start_log = [&] {
    mv::set_up_log(is_quiet ? mv::LogLevel::quiet : is_verbose ? mv::LogLevel::verbose : mv::LogLevel::normal);
  };

  mv::RunOptions options;
  CLI::App* all = app.add_subcommand("run", "All stages; unchanged ones are skipped");
  add_config_and_case(*all, options);
  all->add_flag("--dry-run", options.dry_run, "Print counts, memory, predicted step and run time; write nothing");
  all->add_option("--from", options.from, "Run this stage and all later ones even if unchanged")->type_name("STAGE");
  all->callback([&] { start_log(), mv::run_command(options); });

  for (const mv::SourceKind& kind : mv::source_kinds()) {
    CLI::App* source = app.add_subcommand(kind.name, "Stage source, begins a case: " + kind.help);
    add_config_and_case(*source, options);
    source->callback([&] { start_log(), mv::source_command(kind.name, options); });
  }

  for (const char* name : {"annulus", "mesh", "chordae", "fibers", "tube"}) {
    CLI::App* stage = app.add_subcommand(name, "Stage, again on what is there: " + mv::find_stage(name).help);
    stage->add_option("CASE", options.case_directory, "Case directory")->required();
    add_settings(*stage, options.settings);
    stage->callback([&, name] { start_log(), mv::stage_command(name, options.case_directory, options.settings); });
  }

  CLI::App* check = app.add_subcommand("check", "Run the gates again and print them");
  check->add_option("CASE", options.case_directory, "Case directory")->required();
  check->callback([&] { start_log(), mv::check_command(options.case_directory); });

  std::vector<std::filesystem::path> cases;
  std::string phase;
  std::filesystem::path tables;
  CLI::App* metrics =
      app.add_subcommand("metrics", "Measures of annulus and leaflets as SlicerHeart names them, for one or many cases");
  metrics->add_option("CASE", cases, "Case directories")->required();
  metrics->add_option("-o,--output", tables,
                      "Directory for QuantificationResults_wide.csv, _long.csv and QuantificationUnits.csv");
  metrics->add_option("--phase", phase, "Phase of the heart cycle, for the column of that name, e.g. MS");
  metrics->callback([&] { start_log(), mv::metrics_command(cases, phase, tables); });

  std::filesystem::path exported;
  std::string space = "RAS";
  CLI::App* copy = app.add_subcommand("export", "Copies of a case's VTK files for other programs, in the space they expect");
  copy->add_option("CASE", options.case_directory, "Case directory")->required();
  copy->add_option("-o,--output", exported, "Directory to write")->required();
  copy->add_option("--space", space, "RAS (as in the case) or LPS (as Slicer and ITK write)")
      ->check(CLI::IsMember({"RAS", "LPS"}));
  copy->callback([&] { start_log(), mv::export_command(options.case_directory, exported, space); });

  mv::LayoutOptions layout;
  CLI::App* search = app.add_subcommand("layout", "Find chordae with which the valve seals: close it again and again in coarse blood and change the chordae near what is left open");
  search->alias("calibrate");
  search->add_option("-c,--config", layout.config, "Configuration (TOML) whose chordae are the start")->required();
  search->add_option("-o,--output", layout.directory, "Directory for the trials, layout.csv, layout.toml and trials.csv")->required();
  add_settings(*search, layout.settings);
  search->add_option("--target", layout.target_area, "Stop when the holes are no larger together, mm2")->check(CLI::NonNegativeNumber)->capture_default_str();
  search->add_option("--trials", layout.trials, "Closures at most")->check(CLI::Range(1, 1000))->capture_default_str();
  search->add_option("--fluid", layout.fluid_spacing, "Fluid spacing of the trials; solid points lie half of it apart")->capture_default_str();
  search->add_option("--time", layout.time_end, "Simulated time of a trial, at most time.end")->capture_default_str();
  search->add_option("--threads", layout.threads, "Threads of mvsolve")->check(CLI::Range(1, 1024))->capture_default_str();
  search->add_option("--mvsolve", layout.mvsolve, "Program to close the valve with; default: mvsolve beside mvprep");
  search->callback([&] { start_log(), mv::layout_command(layout); });
  std::vector<std::filesystem::path> compared;
  std::filesystem::path comparison_csv;
  CLI::App* compare = app.add_subcommand("compare", "How far the mid-surfaces, annulus planes and areas of cases differ");
  compare->add_option("CASE", compared, "Case directories, two or more")->required();
  compare->add_option("--csv", comparison_csv, "Write the table of pairs to this file")->type_name("FILE");
  compare->callback([&] { start_log(), mv::compare_command(compared, comparison_csv); });

  bool only_defaults = false;
  CLI::App* keys = app.add_subcommand("config", "Print every key with unit, default and documentation, as a configuration");
  keys->add_flag("--defaults", only_defaults, "Without the documentation");
  keys->callback([&] { mv::config_command(only_defaults); });

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    const int code = app.exit(e);
    if (code != 0) throw mv::UsageError("");
  }
}

}  // namespace

int main(int argc, char** argv) {
  mv::set_up_log();
  mv::catch_interrupts();
  return mv::exit_status([&] { run(argc, argv); });
}
