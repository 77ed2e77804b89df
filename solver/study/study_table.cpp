// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/study_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "solver/output/series.h"

namespace mv {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

std::string cell(double value) { return std::isfinite(value) ? format_number(value) : ""; }

/// A CSV cell that may hold commas and quotes.
std::string quoted(std::string text) {
  std::string out = "\"";
  for (char c : text) out += c == '"' ? std::string("\"\"") : c == '\n' ? std::string(" ") : std::string(1, c);
  return out + "\"";
}

}  // namespace

void put_errors(StudyTable& table) {
  for (StudyRow& row : table.rows) {
    row.errors.assign(table.quantities.size(), nan);
    if (!row.has_values) continue;
    for (std::size_t q = 0; q < table.quantities.size(); ++q) {
      const StudyQuantity& quantity = table.quantities[q];
      const double scale = quantity.is_leak ? quantity.leak_scale : std::abs(quantity.reference);
      if (scale > 0) row.errors[q] = 100 * std::abs(row.values[q] - quantity.reference) / scale + quantity.uncertainty_percent;
    }
  }
}

std::vector<CostError> cost_errors(const StudyTable& table, std::size_t quantity) {
  std::vector<CostError> points;
  for (const StudyRow& row : table.rows) points.push_back({row.seconds, row.is_usable() ? row.errors[quantity] : nan});
  return points;
}

std::vector<RunErrors> run_errors(const StudyTable& table) {
  std::vector<RunErrors> out;
  for (const StudyRow& row : table.rows) {
    RunErrors run{row.run, row.seconds, row.errors};
    if (!row.is_usable()) run.errors.assign(table.quantities.size(), nan);
    out.push_back(std::move(run));
  }
  return out;
}

std::string study_csv_head() {
  return "study,run,axis,fluid_spacing_mm,solid_spacing_mm,solid_order,settings,seconds,threads,quantity,unit,value,reference,reference_uncertainty_percent,error_percent,on_front,"
         "usable,failure,revision\n";
}

std::string study_csv_rows(const StudyTable& table) {
  std::string out;
  for (std::size_t q = 0; q < table.quantities.size(); ++q) {
    const StudyQuantity& quantity = table.quantities[q];
    const std::vector<std::size_t> front = pareto_front(cost_errors(table, q));
    for (std::size_t r = 0; r < table.rows.size(); ++r) {
      const StudyRow& row = table.rows[r];
      const bool is_on_front = std::find(front.begin(), front.end(), r) != front.end();
      out += fmt::format("{},{},{},{},{},{},{},{},1,{},{},{},{},{},{},{},{},{},{}\n", table.id, row.run, quoted(row.axis), cell(row.mesh.fluid_mm > 0 ? row.mesh.fluid_mm : nan),
                         cell(row.mesh.solid_mm > 0 ? row.mesh.solid_mm : nan), row.mesh.order, quoted(fmt::format("{}", fmt::join(row.settings, "; "))),
                         row.has_values ? cell(row.seconds) : "", quantity.name, quantity.unit, row.has_values ? cell(row.values[q]) : "", cell(quantity.reference),
                         cell(quantity.uncertainty_percent), row.has_values ? cell(row.errors[q]) : "", is_on_front ? "yes" : "no", row.is_usable() ? "yes" : "no",
                         quoted(row.failure), row.revision);
    }
  }
  return out;
}

}  // namespace mv
