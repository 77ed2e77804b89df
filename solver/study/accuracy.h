// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// mvsolve accuracy: error against run time, and the settings to use.

#include <string>

#include "solver/output/summary.h"
#include "solver/study/closure_ladder.h"
#include "solver/study/recommended.h"
#include "solver/study/scene_parts.h"

namespace mv {

struct AccuracyOptions {
  LadderOptions ladder;
  bool has_known_answers = true;
  bool has_scene_parts = true;
  bool is_small = false;                 // two rungs of every known answer, for tests
  std::filesystem::path table_file;      // where the built-in table's source goes; empty: DIR/recommended_table.cpp
  std::string command_line;
};

struct AccuracyResult {
  StudyTable closure;
  std::vector<StudyTable> known;
  std::vector<ScenePart> parts;
  std::string parts_scene;
  std::vector<RecommendedSettings> recommended;
};

/// Runs the ladders and writes DIR/accuracy.csv, accuracy.json, closure_front.svg, scene_parts.csv, recommended.toml, the table's source and accuracy.html.
AccuracyResult run_accuracy(const AccuracyOptions& options);

Json accuracy_json(const AccuracyResult& result);
std::string accuracy_page(const AccuracyResult& result, const AccuracyOptions& options);
/// Log-log charts of error against seconds, one a quantity, fronts marked.
std::string front_figure(const StudyTable& table);
/// What goes to stdout.
std::string accuracy_text(const AccuracyResult& result);

}  // namespace mv
