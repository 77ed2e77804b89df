// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Settings for an asked error: from a study's front to `mvsolve run --accuracy`.

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "solver/study/study_table.h"

namespace mv {

/// The cheapest settings for one asked error.
struct RecommendedSettings {
  double asked_percent = 0;
  std::string run;                        // of the ladder; empty when no run gives any quantity
  double fluid_mm = 0, solid_mm = 0;      // largest spacings of the case
  int order = 1;
  std::vector<std::string> settings;      // key=value of the run
  double seconds = 0;                     // processor time of that run
  std::vector<std::string> met;           // quantities within the asked error
  std::vector<std::pair<std::string, double>> not_met;  // the others with this run's error (per cent), NaN: it does not give it
};

/// The errors that are asked for.
inline constexpr double asked_errors[] = {5, 2, 1};

std::vector<RecommendedSettings> recommended_settings(const StudyTable& closure);

/// recommended.toml: one table an asked error. `command` goes into a comment.
std::string recommended_toml(const std::vector<RecommendedSettings>& table, const std::string& command);

/// The source file that builds the table into mvsolve (solver/study/recommended_table.cpp).
std::string recommended_source(const std::vector<RecommendedSettings>& table, const std::string& command);

/// The table of the last recorded ladder.
const std::vector<RecommendedSettings>& recommended_table();

/// "2%", "0.5 %" -> 2, 0.5. Throws UsageError for anything else, also for a bare number.
double parse_percent(const std::string& text);

/// The entry for an asked error: that of the largest listed error not above it. Throws ConfigError when the error is below all listed ones, or
/// when the entry has no quantity within it.
const RecommendedSettings& entry_for(const std::vector<RecommendedSettings>& table, double asked_percent);

/// The run's settings for a case; logs what they promise and what they do not. Throws ConfigError, with the settings of mvprep that are
/// needed, when the case's spacings are wider than the entry's.
std::vector<std::string> settings_for_accuracy(const std::filesystem::path& case_directory, double asked_percent, const std::vector<RecommendedSettings>& table = recommended_table());

}  // namespace mv
