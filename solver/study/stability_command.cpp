// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/stability_command.h"

#include <fmt/format.h>

#include <iostream>

namespace mv {

StabilityCommand::StabilityCommand(CLI::App& app, const std::atomic<bool>* is_interrupted)
    : command_(app.add_subcommand("stability", "run the table of stiff and extreme cases: each must be stable or refused (stability.csv, stability.html; exit 6 otherwise)")) {
  options_.is_interrupted = is_interrupted;
  command_->add_option("-o,--output", options_.output, "directory for the cases, logs, table and page");
  command_->add_flag("--list", is_list_only_, "print the cases and run nothing");
  command_->add_option("--only", options_.only, "run the cases with this in their name or axis");
  command_->add_option("--jobs", options_.jobs, "cases at a time, one thread each (default 2)")->check(CLI::Range(1, 256));
  command_->add_option("--case-seconds", options_.case_seconds, "processor time that a case may take (default 900)")->check(CLI::Range(1.0, 1e6));
  command_->add_option("--mvprep", options_.mvprep, "the program mvprep (default: beside mvsolve, or in PATH)");
}

ExitCode StabilityCommand::run() {
  const std::vector<StabilityCase> cases = select_cases(stability_cases(), options_.only);
  if (is_list_only_) {
    for (const StabilityCase& c : cases)
      std::cout << fmt::format("{:<34} {:<44} {:<8} {}\n", c.name, c.axis, c.expected == Expected::refused ? "refused" : "stable", c.note);
    return ExitCode::done;
  }
  if (options_.output.empty()) throw UsageError("stability: -o DIR is needed");
  const std::vector<StabilityRow> rows = run_stability(cases, options_);
  if (rows.empty()) return ExitCode::interrupted;
  const long bad = bad_count(rows);
  long refused = 0;
  for (const StabilityRow& row : rows) refused += row.judgement.verdict == Verdict::refused;
  std::cout << fmt::format("{} cases: {} stable, {} refused, {} neither\n", rows.size(), static_cast<long>(rows.size()) - refused - bad, refused, bad);
  std::cout << "table = " << (options_.output / "stability.csv").string() << "\npage = " << (options_.output / "stability.html").string() << "\n";
  return exit_code_of(rows);
}

}  // namespace mv
