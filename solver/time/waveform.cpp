// SPDX-License-Identifier: BSD-3-Clause
#include "solver/time/waveform.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "geometry/core/csv_table.h"
#include "geometry/core/errors.h"

namespace mv {
namespace {

std::size_t column_of(const CsvTable& table, const std::string& name, std::size_t fallback) {
  if (name.empty()) {
    if (fallback >= table.columns().size()) throw InputError(fmt::format("{}: has {} columns, at least {} were expected", table.file(), table.columns().size(), fallback + 1));
    return fallback;
  }
  if (const auto found = table.find(name)) return *found;
  throw InputError(fmt::format("{}: has no column '{}' (nearest: '{}')", table.file(), name, nearest_name(name, table.columns())));
}

std::vector<double> numbers_of(const CsvTable& table, std::size_t column) {
  std::vector<double> numbers;
  for (std::size_t row = 0; row < table.rows(); ++row) numbers.push_back(table.number(row, column));
  return numbers;
}

}  // namespace

Waveform Waveform::from_table(std::vector<double> times, std::vector<double> pressures) {
  if (times.size() < 2 || times.size() != pressures.size()) throw InputError("a pressure table needs two or more times and as many pressures");
  for (std::size_t i = 1; i < times.size(); ++i)
    if (!(times[i] > times[i - 1])) throw InputError(fmt::format("pressure table: time {} s in row {} does not increase", times[i], i + 1));
  Waveform w;
  w.kind_ = Kind::table;
  w.times_ = std::move(times);
  w.pressures_ = std::move(pressures);
  return w;
}

Waveform Waveform::from_config(const Config& config, const std::filesystem::path& case_directory) {
  const std::string& kind = config.text("pressure.waveform");
  if (kind != "csv") {
    Waveform w;
    w.kind_ = kind == "ramp" ? Kind::ramp : kind == "smooth" ? Kind::smooth : Kind::systolic;
    w.peak_ = config.number("pressure.peak");
    w.rise_time_ = config.number("pressure.rise_time");
    return w;
  }
  const std::string& name = config.text("pressure.csv");
  if (name.empty()) throw ConfigError("pressure.csv is empty; pressure.waveform = \"csv\" needs the path of a CSV file");
  std::filesystem::path file = std::filesystem::path(name);
  if (file.is_relative()) {
    const auto beside_config = config.base_directory() / file;
    const auto in_case = case_directory / file.filename();
    file = std::filesystem::exists(in_case) ? in_case : beside_config;
  }
  const CsvTable table(file, "a time and one or two pressures, e.g. time,pressure");
  if (table.rows() < 2) throw InputError(file.string() + ": needs at least two rows of numbers");
  const double time_unit = config.text("pressure.csv_time_unit") == "ms" ? 1e-3 : 1.0;
  const double pressure_unit = unit_factor(config.text("pressure.csv_pressure_unit"));
  const auto& columns = config.texts("pressure.csv_columns");
  if (columns.size() > 2) throw ConfigError("pressure.csv_columns: one column (the difference) or two (ventricle, atrium) were expected");
  std::vector<double> times = numbers_of(table, column_of(table, config.text("pressure.csv_time_column"), 0));
  std::vector<double> pressures = numbers_of(table, column_of(table, columns.empty() ? "" : columns[0], 1));
  for (double& time : times) time *= time_unit;
  if (columns.size() == 2) {
    const std::vector<double> low = numbers_of(table, column_of(table, columns[1], 1));
    for (std::size_t i = 0; i < pressures.size(); ++i) pressures[i] -= low[i];
  }
  for (double& p : pressures) p *= pressure_unit;
  Waveform w = from_table(std::move(times), std::move(pressures));
  w.shift_ = config.number("pressure.csv_start");
  if (w.shift_ < w.times_.front() || w.shift_ >= w.times_.back())
    throw ConfigError(fmt::format("pressure.csv_start: {} s lies outside the table {} ({} s to {} s)", w.shift_, file.string(), w.times_.front(), w.times_.back()));
  return w;
}

double Waveform::at(double time) const {
  switch (kind_) {
    case Kind::systolic: return time <= 0 ? 0.0 : time >= rise_time_ ? peak_ : 0.5 * peak_ * (1 - std::cos(M_PI * time / rise_time_));
    case Kind::ramp: return time <= 0 ? 0.0 : time >= rise_time_ ? peak_ : peak_ * time / rise_time_;
    case Kind::smooth: {
      const double s = std::clamp(time / rise_time_, 0.0, 1.0);
      return peak_ * s * s * s * (10 - 15 * s + 6 * s * s);
    }
    case Kind::table: break;
  }
  const double t = time + shift_;
  if (t <= times_.front()) return pressures_.front();
  if (t >= times_.back()) return pressures_.back();
  const auto upper = std::upper_bound(times_.begin(), times_.end(), t);
  const std::size_t i = static_cast<std::size_t>(upper - times_.begin());
  const double s = (t - times_[i - 1]) / (times_[i] - times_[i - 1]);
  return (1 - s) * pressures_[i - 1] + s * pressures_[i];
}

double Waveform::largest() const {
  if (kind_ != Kind::table) return std::abs(peak_);
  double largest = 0;
  for (double p : pressures_) largest = std::max(largest, std::abs(p));
  return largest;
}

}  // namespace mv
