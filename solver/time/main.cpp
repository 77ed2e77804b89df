// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <atomic>
#include <filesystem>
#include <csignal>
#include <iostream>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "geometry/core/log.h"
#include "geometry/core/parallel.h"
#include "geometry/core/version.h"
#include "solver/output/summary.h"
#include "solver/report/compare.h"
#include "solver/report/compare_reference.h"
#include "solver/report/report.h"
#include "solver/study/commands.h"
#include "solver/study/recommended.h"
#include "solver/study/stability_command.h"
#include "solver/time/run.h"

namespace {

std::atomic<bool> is_interrupted{false};

extern "C" void on_interrupt(int signal) {
  is_interrupted = true;
  // A second one ends the program the usual way.
  std::signal(signal, SIG_DFL);
}

void print_summary(const std::filesystem::path& results) {
  const mv::Json summary = mv::read_json(results / "summary.json");
  auto print = [&](const char* name) {
    const mv::Json& value = mv::json_at(summary, name);
    if (!value.is_null()) std::cout << name << " = " << value.dump() << "\n";
  };
  for (const char* name : {"seal.sealed", "seal.threshold_mm", "seal.smallest_sealing_threshold_mm", "seal.hole_area_mm2", "contact.belt_continuous", "contact.force_N",
                           "contact.self_intersections", "flow.closing_volume_ml", "flow.leak_rate_ml_s", "papillary.force_total_N", "mass.solid_volume_drift",
                           "energy.residual_relative", "run.wall_s"})
    print(name);
  std::cout << "report = " << (results / "report.html").string() << "\n";
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"mvsolve: closes a mitral valve in blood and says whether it seals"};
  app.require_subcommand(1);
  app.set_version_flag("--version", mv::version());
  bool is_quiet = false, is_verbose = false;
  app.add_flag("-q,--quiet", is_quiet, "warnings and errors only");
  app.add_flag("-v,--verbose", is_verbose, "debug lines too");

  mv::RunOptions run;
  int threads = 0;
  CLI::App* run_command = app.add_subcommand("run", "run a case to the end and write RESULTS (summary.json, report.html, frames, series)");
  run_command->add_option("CASE", run.case_directory, "case directory made by mvprep")->required();
  run_command->add_option("-o,--output", run.results, "results directory")->required();
  run_command->add_option("--threads", threads, "number of threads (default: all cores)")->check(CLI::Range(1, 1024));
  run_command->add_option("--set", run.settings, "override a setting of case.toml, key=value (repeatable)")->take_all();
  std::string asked;
  run_command->add_option("--accuracy", asked, "choose the settings for an error such as 2% (mvsolve accuracy); --set comes after them");
  run_command->add_flag("--resume", run.is_resumed, "go on from RESULTS/checkpoint");

  std::filesystem::path report_results;
  CLI::App* report_command = app.add_subcommand("report", "write RESULTS/report.html again from RESULTS alone");
  report_command->add_option("RESULTS", report_results, "results directory")->required();

  mv::CompareOptions compare;
  CLI::App* compare_command = app.add_subcommand("compare", "named scalars of several results in a table, their closed valves side by side");
  compare_command->add_option("RESULTS", compare.results, "results directories")->required();
  compare_command->add_option("-o,--output", compare.output, "directory for compare.csv, compare.md, compare.png")->required();
  compare_command->add_option("--names", compare.names, "one label a result (default: the directories' names)")->delimiter(',');
  compare_command->add_option("--quantities", compare.quantities, "names of summary.json, e.g. bulging.volume_ml,seal.hole_area_mm2")->delimiter(',');
  std::filesystem::path reference_results, reference_output, reference;
  mv::ReferenceOptions reference_options;
  CLI::App* reference_command = app.add_subcommand("compare-reference", "compare a closed valve with another program's answer: distances, contact, CSV, JSON and a figure");
  reference_command->add_option("RESULTS", reference_results, "results directory")->required();
  reference_command->add_option("--reference", reference, "closed leaflets as legacy VTK (.vtk, .vtk.gz), mm")->required();
  reference_command->add_option("--reference-rest", reference_options.rest, "the same at rest, to match nodes by their places (default: by order, checked by displacements)");
  reference_command->add_option("--contact-array", reference_options.contact_array, "point array of the reference that is above zero in contact (default: the first with 'contact' in its name)");
  reference_command->add_option("-o,--output", reference_output, "directory of comparison.json, .csv and .png (default: RESULTS)");

  std::string command_line = "mvsolve";
  for (int i = 1; i < argc; ++i) command_line += " " + std::string(argv[i]);
  const auto accuracy = mv::add_accuracy_command(app, command_line);
  const auto bench = mv::add_bench_command(app, command_line);
  mv::StabilityCommand stability(app, &is_interrupted);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return code == 0 ? 0 : static_cast<int>(mv::ExitCode::usage);
  }
  mv::set_up_log(is_quiet ? mv::LogLevel::quiet : is_verbose ? mv::LogLevel::verbose : mv::LogLevel::normal);
  try {
    if (*run_command) {
      if (threads > 0) mv::set_thread_count(threads);
      std::signal(SIGINT, on_interrupt);
      std::signal(SIGTERM, on_interrupt);
      run.command_line = command_line;
      run.is_interrupted = &is_interrupted;
      if (!asked.empty()) {
        const std::vector<std::string> chosen = mv::settings_for_accuracy(run.case_directory, mv::parse_percent(asked));
        run.settings.insert(run.settings.begin(), chosen.begin(), chosen.end());
      }
      if (mv::run_case(run) == mv::RunEnd::interrupted) return static_cast<int>(mv::ExitCode::interrupted);
      print_summary(run.results);
    } else if (stability.is_asked()) {
      std::signal(SIGINT, on_interrupt);
      std::signal(SIGTERM, on_interrupt);
      return static_cast<int>(stability.run());
    } else if (*reference_command) {
      if (reference_output.empty()) reference_output = reference_results;
      mv::compare_results_with_reference(reference_results, reference, reference_output, reference_options);
      std::cout << mv::read_file(reference_output / "comparison.json");
      std::cout << "figure = " << (reference_output / "comparison.png").string() << "\n";
    } else if (*report_command) {
      std::cout << mv::write_report(report_results).string() << "\n";
    } else if (*compare_command) {
      std::cout << mv::compare_results(compare);
    } else if (app.got_subcommand("accuracy")) {
      accuracy();
    } else if (app.got_subcommand("bench")) {
      bench();
    }
    return 0;
  } catch (const mv::Error& error) {
    spdlog::error("{}", error.what());
    return static_cast<int>(error.code());
  } catch (const std::bad_alloc&) {
    spdlog::error("out of memory; a coarser tube.spacing or mesh.spacing needs less");
    return static_cast<int>(mv::ExitCode::io);
  } catch (const std::filesystem::filesystem_error& error) {
    constexpr std::size_t longest_path = 200;  // characters of it in a message
    spdlog::error("{}: {}", error.path1().string().substr(0, longest_path), error.code().message());
    return static_cast<int>(mv::ExitCode::io);
  } catch (const std::exception& error) {
    spdlog::error("internal error: {}; please report it with the command and the case", error.what());
    return static_cast<int>(mv::ExitCode::bug);
  }
}
