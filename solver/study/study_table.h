// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Runs of one problem at several settings, their errors and their seconds.

#include <string>
#include <vector>

#include "solver/study/closure_case.h"
#include "solver/study/pareto.h"

namespace mv {

struct StudyRow {
  std::string run;                     // short and unique in its table
  std::string axis;                    // what differs from the baseline: "resolution", "kernel", ...
  std::string what;                    // in words
  ClosureMesh mesh;                    // 0 mm where the problem has no such spacing
  std::vector<std::string> settings;   // key=value besides the mesh
  double seconds = 0;                  // processor time with one thread
  std::vector<double> values;          // per quantity, NaN: none
  std::vector<double> errors;          // per cent, the reference's uncertainty included (put_errors)
  std::string failure;                 // why it has no values, or why they are not to be trusted
  bool has_values = false;
  std::string revision;                // of the program that ran it
  bool is_usable() const { return has_values && failure.empty(); }
};

struct StudyQuantity {
  std::string name, unit, title, how;
  double reference = 0;
  double uncertainty_percent = 0;      // of the reference
  double order = 0;                    // observed, NaN without
  bool is_leak = false;                // right value near zero: measured against leak_scale
  double leak_scale = 1;
};

struct StudyTable {
  std::string id, title, explanation;  // explanation is HTML
  std::vector<StudyQuantity> quantities;
  std::vector<StudyRow> rows;
};

/// Fills the rows' errors: 100 |value - reference| / scale + the reference's uncertainty, scale the reference's size (leak_scale for a leak).
void put_errors(StudyTable& table);

/// Points of one quantity for the front; rows that are not usable have NaN errors.
std::vector<CostError> cost_errors(const StudyTable& table, std::size_t quantity);

/// The table's usable rows for recommend(); the others get NaN errors so that indices stay those of the rows.
std::vector<RunErrors> run_errors(const StudyTable& table);

/// Head line and rows of accuracy.csv, one row a run and quantity.
std::string study_csv_head();
std::string study_csv_rows(const StudyTable& table);

}  // namespace mv
