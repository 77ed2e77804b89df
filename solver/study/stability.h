// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// `mvsolve stability`: the table of stiff and extreme cases, each in a process of its own, with a verdict a case.

#include <atomic>
#include <filesystem>
#include <string>
#include <vector>

#include "geometry/core/errors.h"
#include "solver/study/stability_outcome.h"

namespace mv {

struct StabilityOptions {
  std::filesystem::path output;
  std::filesystem::path mvprep;       // empty: find_mvprep()
  std::string only;                   // part of a name or axis; empty: all
  int jobs = 2;                       // cases at a time, one thread each
  double case_seconds = 900;          // processor time a case may take; ended after four times as long on the clock
  const std::atomic<bool>* is_interrupted = nullptr;
};

struct StabilityRow {
  StabilityCase stability_case;
  CaseOutcome outcome;
  Judgement judgement;
};

/// Makes and runs `cases`, prints one line a case on stdout as they end, and writes stability.csv and stability.html into the output directory.
/// Rows come back in the order of the table. A case that crashes or hangs ends alone. Throws UsageError, IoError, and Interrupted by
/// returning no rows.
std::vector<StabilityRow> run_stability(const std::vector<StabilityCase>& cases, const StabilityOptions& options);

/// Cases whose name or axis contains `pattern`. Throws UsageError when there is none.
std::vector<StabilityCase> select_cases(const std::vector<StabilityCase>& cases, const std::string& pattern);

/// Number of cases that are neither stable nor refused, or not as declared.
long bad_count(const std::vector<StabilityRow>& rows);

/// done, or not_trustworthy when bad_count() is not zero.
ExitCode exit_code_of(const std::vector<StabilityRow>& rows);

std::string stability_csv(const std::vector<StabilityRow>& rows);

}  // namespace mv
