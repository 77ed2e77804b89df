// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// The commands of mvprep. Results go to stdout, log and progress to stderr.

#include <filesystem>
#include <string>
#include <vector>

namespace mv {

struct RunOptions {
  std::filesystem::path config;
  std::filesystem::path case_directory;
  std::vector<std::string> settings;  // --set key=value
  bool dry_run = false;
  std::string from;  // --from STAGE, empty for none
};

/// `mvprep run`: all stages.
void run_command(const RunOptions& options);

/// `mvprep generic`, `mvprep labels` and so on: starts a case with its geometry source only. Throws UsageError when the
/// configuration asks for another kind.
void source_command(const std::string& kind, const RunOptions& options);

/// `mvprep annulus|mesh|chordae|fibers|tube CASE`: one stage again, on what is there.
void stage_command(const std::string& stage, const std::filesystem::path& case_directory,
                   const std::vector<std::string>& settings);

/// `mvprep check CASE`: the gates again; throws GateError when one fails.
void check_command(const std::filesystem::path& case_directory);

/// `mvprep metrics CASE...`: measures as SlicerHeart names them, printed and, with `output`, as its three tables
/// (valve_metrics.h). Throws UsageError when two cases have the same name.
void metrics_command(const std::vector<std::filesystem::path>& cases, const std::string& phase,
                     const std::filesystem::path& output);

/// `mvprep export CASE -o DIR --space RAS|LPS`: copies of the VTK files for other programs (export_case.h); prints their names.
void export_command(const std::filesystem::path& case_directory, const std::filesystem::path& directory,
                    const std::string& space);

/// `mvprep config`: every key, with documentation unless `only_defaults`.
void config_command(bool only_defaults);

}  // namespace mv
