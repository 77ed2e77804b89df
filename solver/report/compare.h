// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// `mvsolve compare`: named scalars of several results in one table and their closed valves side by side, drawn to one scale from one place. What lies
// above the annulus plane is red (papers/s2, figure 3).

#include <filesystem>
#include <string>
#include <vector>

namespace mv {

struct CompareOptions {
  std::vector<std::filesystem::path> results;
  std::filesystem::path output;         // directory for compare.csv, compare.md, compare.png
  std::vector<std::string> names;       // one label a result; empty: the directories' names
  std::vector<std::string> quantities;  // dotted names of summary.json; empty: seal, bulging, contact, chordae and flow
};

/// Returns the table as text (Markdown). A quantity that a result lacks is left empty; one that no result has is an error. Throws UsageError (labels, quantities),
/// IoError, InputError.
std::string compare_results(const CompareOptions& options);

}  // namespace mv
