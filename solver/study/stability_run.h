// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "solver/study/stability_outcome.h"

namespace mv {

/// Runs one case on what mvprep made in `case_directory`, in this process: loads, alters, advances to the case's end or `seconds` of processor time. An
/// error of the scene is an outcome (refused), as is a run that stops; only our own bugs are thrown.
CaseOutcome run_stability_case(const StabilityCase& stability_case, const std::filesystem::path& case_directory, double seconds);

}  // namespace mv
