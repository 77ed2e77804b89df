// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/commands.h"

#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "geometry/core/log.h"
#include "pipeline/case_directory.h"
#include "pipeline/deck_settings.h"
#include "pipeline/export_case.h"
#include "pipeline/prediction.h"
#include "pipeline/runner.h"
#include "pipeline/stage_table.h"
#include "pipeline/valve_metrics.h"

namespace mv {
namespace {

/// Throws IoError when stdout is gone or full, so that a result that nobody got is no success.
void print(const std::string& text) {
  if (std::fputs(text.c_str(), stdout) < 0 || std::fflush(stdout) != 0) throw IoError("cannot write to the standard output");
}

void print_stage(const StageReport& report) {
  print(report.skipped ? fmt::format("{:<8} {:>9}   {}\n", report.stage, "skipped", report.result)
                       : fmt::format("{:<8} {:>7.2f} s   {}\n", report.stage, report.seconds, report.result));
}

Config configured(const RunOptions& options) {
  Config config = Config::from_file(options.config);
  for (const std::string& setting : options.settings) config.set(setting);
  return config;
}

/// Says which parts of the case no longer belong to what has just been made.
void warn_out_of_date(const std::vector<std::string>& later, const std::filesystem::path& case_directory) {
  std::string names;
  for (const std::string& name : later) {
    if (std::filesystem::exists(case_directory / find_stage(name).outputs.front())) names += (names.empty() ? "" : ", ") + name;
  }
  if (names.empty()) return;
  spdlog::warn("now out of date: {}; bring the case up to date with `mvprep run -c {} -o {}`", names,
               (case_directory / "case.toml").string(), case_directory.string());
}

void print_gates(const std::filesystem::path& case_directory) {
  const auto json = nlohmann::json::parse(read_file(case_directory / "quality.json"));
  for (const auto& gate : json.at("gates")) {
    print(fmt::format("{:<5} {:<32} {:>12.6g} {} {:<8.6g} {:<4} {}\n", gate.at("verdict").get<std::string>(),
                      gate.at("name").get<std::string>(), gate.at("value").is_number() ? gate.at("value").get<double>() : 0.0,
                      gate.at("relation").get<std::string>(), gate.at("limit").is_number() ? gate.at("limit").get<double>() : 0.0,
                      gate.at("unit").get<std::string>(), gate.at("message").get<std::string>()));
  }
}

void dry_run(const Config& config) {
  const CaseSize size = measure_case(config);
  const Prediction p = predict_run(config, size);
  print(fmt::format("solid points     {}\ntetrahedra       {}{}\nfluid cells      {}\n", size.points, size.tets,
                    size.order == 2 ? " (quadratic)" : "", size.fluid_cells));
  print(fmt::format(
      "memory           {:.0f} MB\nstable step      {:.2g} s (set by {})\nsteps            {:.0f}\ntime per step    {:.1f} ms\n"
      "run time         {:.1f} min on two cores (a prediction, see pipeline/README.md)\n",
      p.memory_mb, p.step_s, p.limiter, p.steps, 1e3 * p.seconds_per_step, p.run_s / 60));
}

}  // namespace

void run_command(const RunOptions& options) {
  const Config config = configured(options);
  const std::optional<std::string> from = options.from.empty() ? std::nullopt : std::optional(options.from);
  if (from) find_stage(*from);
  const DeckSettings deck = deck_settings(config);
  if (options.dry_run) {
    dry_run(deck.config);
    return;
  }
  Manifest manifest = read_manifest(options.case_directory);
  const Config resolved = set_up_case(deck.config, options.config, options.case_directory, manifest.inputs, deck.made);
  run_all_stages(resolved, options.case_directory, manifest, from, print_stage);
  print("case             " + options.case_directory.string() + "\n");
}

void source_command(const std::string& kind, const RunOptions& options) {
  Config config = configured(options);
  if (config.was_given("source.kind") && config.text("source.kind") != kind) {
    throw UsageError("the configuration asks for source.kind = \"" + config.text("source.kind") + "\": use `mvprep " +
                     config.text("source.kind") + "`, or `mvprep run` for all stages");
  }
  config.set("source.kind=" + kind);
  Manifest manifest = read_manifest(options.case_directory);
  const DeckSettings deck = deck_settings(config);
  const Config resolved = set_up_case(deck.config, options.config, options.case_directory, manifest.inputs, deck.made);
  write_manifest(options.case_directory, manifest, resolved);
  warn_out_of_date(run_one_stage("source", resolved, options.case_directory, print_stage), options.case_directory);
}

void stage_command(const std::string& stage, const std::filesystem::path& case_directory,
                   const std::vector<std::string>& settings) {
  Config config = read_case_config(case_directory);
  if (!settings.empty()) {
    for (const std::string& setting : settings) config.set(setting);
    Manifest manifest = read_manifest(case_directory);
    config = set_up_case(config, case_directory / "case.toml", case_directory, manifest.inputs);
  }
  warn_out_of_date(run_one_stage(stage, config, case_directory, print_stage), case_directory);
}

void check_command(const std::filesystem::path& case_directory) {
  const Config config = read_case_config(case_directory);
  std::string stale;
  const Manifest manifest = read_manifest(case_directory);
  for (const Stage& stage : stage_table())
    if (stage.name != "gates" && !is_up_to_date(stage, config, manifest, case_directory)) stale += (stale.empty() ? "" : ", ") + stage.name;
  if (!stale.empty())
    spdlog::warn("not what mvprep would make of {} now: {}; the gates judge the files as they are", (case_directory / "case.toml").string(), stale);
  try {
    run_one_stage("gates", config, case_directory, [](const StageReport&) {});
  } catch (const GateError&) {
    print_gates(case_directory);
    throw;
  }
  print_gates(case_directory);
}

void metrics_command(const std::vector<std::filesystem::path>& cases, const std::string& phase,
                     const std::filesystem::path& output) {
  std::vector<ValveMetrics> valves;
  for (const auto& directory : cases) {
    read_case_config(directory);
    const std::string name = std::filesystem::weakly_canonical(directory).filename().string();
    for (const ValveMetrics& other : valves) {
      if (other.filename == name) throw UsageError("two cases are called '" + name + "': their rows could not be told apart");
    }
    valves.push_back({name, phase, measure_case_metrics(directory)});
  }
  if (!output.empty()) write_metrics(output, valves);
  for (const ValveMetrics& valve : valves) {
    print(valve.filename + (valve.phase.empty() ? "" : "  " + valve.phase) + "\n");
    for (const Metric& metric : valve.metrics)
      print(fmt::format("  {:<48} {:>10.2f} {}\n", metric.name, metric.value, metric.unit));
  }
}

void export_command(const std::filesystem::path& case_directory, const std::filesystem::path& directory,
                    const std::string& space) {
  for (const auto& file : export_case(case_directory, directory, space)) print(fmt::format("{}  {} mm\n", file.string(), space));
}

void config_command(bool only_defaults) { print(Config().to_toml(!only_defaults)); }

}  // namespace mv
