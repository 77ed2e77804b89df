// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/accuracy.h"

#include <fmt/format.h>

#include <cmath>
#include <sstream>
#include <string>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "geometry/core/log.h"
#include "geometry/core/parallel.h"
#include "solver/output/summary.h"
#include "solver/study/known_answers.h"
#include "solver/study/study_page.h"

namespace mv {
namespace {

/// Known answers and scene parts are kept between calls: they depend on the program only.
void put_known(const AccuracyOptions& options, AccuracyResult& result) {
  const int before = thread_count();
  set_thread_count(1);
  if (options.has_known_answers) {
    result.known.push_back(tube_start_table(options.is_small));
    result.known.push_back(sheet_table(options.is_small));
  }
  if (options.has_scene_parts && !options.ladder.spacings_mm.empty()) {
    const auto& levels = options.ladder.spacings_mm;
    const double h = levels.size() > 1 ? levels[1] : levels[0];
    result.parts = time_generic_scene_parts(options.ladder.output, options.ladder.mvprep, h, std::min(0.06, options.ladder.end), 100, 3);
    result.parts_scene = fmt::format("generic valve, {:g} mm", h);
  }
  set_thread_count(before);
}

Json number_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json table_json(const StudyTable& table) {
  Json out;
  out["study"] = table.id;
  out["quantities"] = Json::array();
  for (std::size_t q = 0; q < table.quantities.size(); ++q) {
    const StudyQuantity& quantity = table.quantities[q];
    Json front = Json::array();
    for (std::size_t r : pareto_front(cost_errors(table, q))) front.push_back(table.rows[r].run);
    out["quantities"].push_back({{"name", quantity.name},
                                 {"unit", quantity.unit},
                                 {"reference", number_or_null(quantity.reference)},
                                 {"reference_uncertainty_percent", number_or_null(quantity.uncertainty_percent)},
                                 {"observed_order", number_or_null(quantity.order)},
                                 {"front", front}});
  }
  out["runs"] = Json::array();
  for (const StudyRow& row : table.rows) {
    Json json{{"run", row.run}, {"axis", row.axis}, {"what", row.what}, {"processor_s", row.seconds}, {"usable", row.is_usable()}, {"failure", row.failure}, {"revision", row.revision}};
    for (std::size_t q = 0; q < table.quantities.size() && row.has_values; ++q) {
      json["values"][table.quantities[q].name] = number_or_null(row.values[q]);
      json["error_percent"][table.quantities[q].name] = number_or_null(row.errors[q]);
    }
    out["runs"].push_back(json);
  }
  return out;
}

}  // namespace

Json accuracy_json(const AccuracyResult& result) {
  Json out;
  out["machine"] = machine_name();
  out["studies"] = Json::array({table_json(result.closure)});
  for (const StudyTable& table : result.known) out["studies"].push_back(table_json(table));
  return out;
}

std::string accuracy_text(const AccuracyResult& result) {
  std::string out;
  const StudyTable& t = result.closure;
  out += fmt::format("{:<22} {:>12} {:>14} {:>8}\n", "quantity", "reference", "uncertainty, %", "order");
  for (const StudyQuantity& q : t.quantities) out += fmt::format("{:<22} {:>12.5g} {:>14.3g} {:>8.2g}  {}\n", q.name, q.reference, q.uncertainty_percent, q.order, q.unit);
  out += fmt::format("\n{:<22} {:>9}", "run: error in %", "seconds");
  for (const StudyQuantity& q : t.quantities) out += fmt::format(" {:>10.10}", q.name);
  out += "\n";
  for (const StudyRow& row : t.rows) {
    if (!row.has_values) {
      out += fmt::format("{:<22} {}\n", row.run, row.failure);
      continue;
    }
    out += fmt::format("{:<22} {:>9.1f}", row.run, row.seconds);
    for (double e : row.errors) out += fmt::format(" {:>10.3g}", e);
    out += row.failure.empty() ? "\n" : "  " + row.failure + "\n";
  }
  for (const RecommendedSettings& e : result.recommended)
    out += e.run.empty() ? fmt::format("{:g} %: no run can be used\n", e.asked_percent)
                         : fmt::format("{:g} %: {} ({:.0f} s) gives {} of {} quantities within it: {}\n", e.asked_percent, e.run, e.seconds, e.met.size(), t.quantities.size(), fmt::join(e.met, ", "));
  return out;
}

AccuracyResult run_accuracy(const AccuracyOptions& options) {
  const auto& directory = options.ladder.output;
  std::error_code code;
  std::filesystem::create_directories(directory / "runs", code);
  if (code) throw IoError(fmt::format("{}: cannot be created: {}", (directory / "runs").string(), code.message()));
  AccuracyResult result;
  result.closure = closure_table(options.ladder);
  put_known(options, result);
  result.recommended = recommended_settings(result.closure);

  std::string csv = study_csv_head() + study_csv_rows(result.closure);
  for (const StudyTable& table : result.known) csv += study_csv_rows(table);
  write_text_atomically(directory / "accuracy.csv", csv);
  write_json(directory / "accuracy.json", accuracy_json(result));
  if (!result.parts.empty()) write_text_atomically(directory / "scene_parts.csv", scene_parts_csv(result.parts));
  write_text_atomically(directory / "recommended.toml", recommended_toml(result.recommended, options.command_line));
  // The built-in table is part of the source: no path of this machine in it.
  std::string command, before;
  std::istringstream words(options.command_line);
  for (std::string word; words >> word; before = word) command += (command.empty() ? "" : " ") + (word == directory.string() ? "DIR" : before == "--table" ? "FILE" : word);
  write_text_atomically(options.table_file.empty() ? directory / "recommended_table.cpp" : options.table_file, recommended_source(result.recommended, command));
  write_text_atomically(directory / "accuracy.html", accuracy_page(result, options));
  return result;
}

}  // namespace mv
