// SPDX-License-Identifier: BSD-3-Clause
#include "solver/time/waveform.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "geometry/core/errors.h"

namespace mv {
namespace {

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> cells;
  std::stringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) {
    const auto from = cell.find_first_not_of(" \t\r\"");
    const auto to = cell.find_last_not_of(" \t\r\"");
    cells.push_back(from == std::string::npos ? "" : cell.substr(from, to - from + 1));
  }
  return cells;
}

struct Table {
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;
};

Table read_table(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) throw IoError(fmt::format("{}: cannot be read; pressure.csv must name an existing CSV file", file.string()));
  Table table;
  std::string line;
  if (!std::getline(stream, line)) throw InputError(file.string() + ": is empty; a header line and rows of numbers were expected");
  table.names = split(line);
  table.columns.resize(table.names.size());
  for (int row = 2; std::getline(stream, line); ++row) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    const auto cells = split(line);
    if (cells.size() != table.names.size())
      throw InputError(fmt::format("{}: line {} has {} cells, the header has {}", file.string(), row, cells.size(), table.names.size()));
    for (std::size_t c = 0; c < cells.size(); ++c) {
      char* end = nullptr;
      const double value = std::strtod(cells[c].c_str(), &end);
      if (cells[c].empty() || *end != 0 || !std::isfinite(value))
        throw InputError(fmt::format("{}: line {}, column '{}': '{}' is not a finite number", file.string(), row, table.names[c], cells[c]));
      table.columns[c].push_back(value);
    }
  }
  if (table.columns.empty() || table.columns[0].size() < 2) throw InputError(file.string() + ": needs at least two rows of numbers");
  return table;
}

std::size_t column(const Table& table, const std::string& name, std::size_t fallback, const std::filesystem::path& file) {
  if (name.empty()) {
    if (fallback >= table.names.size()) throw InputError(fmt::format("{}: has {} columns, at least {} were expected", file.string(), table.names.size(), fallback + 1));
    return fallback;
  }
  const auto it = std::find(table.names.begin(), table.names.end(), name);
  if (it == table.names.end())
    throw InputError(fmt::format("{}: has no column '{}' (nearest: '{}')", file.string(), name, nearest_name(name, table.names)));
  return static_cast<std::size_t>(it - table.names.begin());
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
  const Table table = read_table(file);
  const double time_unit = config.text("pressure.csv_time_unit") == "ms" ? 1e-3 : 1.0;
  const double pressure_unit = unit_factor(config.text("pressure.csv_pressure_unit"));
  const auto& columns = config.texts("pressure.csv_columns");
  if (columns.size() > 2) throw ConfigError("pressure.csv_columns: one column (the difference) or two (ventricle, atrium) were expected");
  const std::size_t t = column(table, config.text("pressure.csv_time_column"), 0, file);
  const std::size_t high = column(table, columns.empty() ? "" : columns[0], 1, file);
  std::vector<double> times = table.columns[t], pressures = table.columns[high];
  for (double& time : times) time *= time_unit;
  if (columns.size() == 2) {
    const auto& low = table.columns[column(table, columns[1], 1, file)];
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
