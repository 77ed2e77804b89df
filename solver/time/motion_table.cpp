// SPDX-License-Identifier: BSD-3-Clause
#include "solver/time/motion_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <sstream>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"

namespace mv {
namespace {

constexpr const char* columns[] = {"point", "time_s", "x_mm", "y_mm", "z_mm"};
constexpr long most_points = 1'000'000;

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::stringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) {
    const auto first = cell.find_first_not_of(" \t\r"), last = cell.find_last_not_of(" \t\r");
    cells.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
  }
  return cells;
}

/// Slopes of a monotone cubic, zero at both ends.
std::vector<double> slopes_of(const std::vector<double>& t, const std::vector<double>& y) {
  const std::size_t n = t.size();
  std::vector<double> slope(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double h0 = t[i] - t[i - 1], h1 = t[i + 1] - t[i];
    const double d0 = (y[i] - y[i - 1]) / h0, d1 = (y[i + 1] - y[i]) / h1;
    if (d0 * d1 > 0) slope[i] = 3 * (h0 + h1) / ((2 * h1 + h0) / d0 + (h1 + 2 * h0) / d1);
  }
  return slope;
}

}  // namespace

MotionTable::MotionTable(std::vector<double> times, std::vector<Vec3> rest, std::vector<std::vector<Vec3>> displacements)
    : times_(std::move(times)), rest_(std::move(rest)), displacements_(std::move(displacements)) {
  slopes_.assign(displacements_.size(), std::vector<Vec3>(times_.size(), Vec3::Zero()));
  std::vector<double> y(times_.size());
  for (std::size_t p = 0; p < displacements_.size(); ++p)
    for (Eigen::Index k = 0; k < 3; ++k) {
      for (std::size_t i = 0; i < y.size(); ++i) y[i] = displacements_[p][i][k];
      const std::vector<double> slope = slopes_of(times_, y);
      for (std::size_t i = 0; i < y.size(); ++i) slopes_[p][i][k] = slope[i];
    }
}

Vec3 MotionTable::displacement(int point, double time) const {
  const auto& u = displacements_[static_cast<std::size_t>(point)];
  if (time <= times_.front()) return u.front();
  if (time >= times_.back()) return u.back();
  const auto& m = slopes_[static_cast<std::size_t>(point)];
  const auto i = static_cast<std::size_t>(std::upper_bound(times_.begin(), times_.end(), time) - times_.begin());
  const double h = times_[i] - times_[i - 1], s = (time - times_[i - 1]) / h;
  const double s2 = s * s, s3 = s2 * s;
  return (2 * s3 - 3 * s2 + 1) * u[i - 1] + (s3 - 2 * s2 + s) * h * m[i - 1] + (3 * s2 - 2 * s3) * u[i] + (s3 - s2) * h * m[i];
}

double MotionTable::largest() const {
  double largest = 0;
  for (const auto& u : displacements_)
    for (const Vec3& d : u) largest = std::max(largest, d.norm());
  return largest;
}

MotionTable MotionTable::read(const std::filesystem::path& file) {
  std::stringstream in(read_file(file));
  const std::string name = file.string();
  std::string line;
  std::getline(in, line);
  if (line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);
  const auto header = cells_of(line);
  std::size_t at[5];
  for (std::size_t c = 0; c < 5; ++c) {
    const auto found = std::find(header.begin(), header.end(), columns[c]);
    if (found == header.end()) throw InputError(fmt::format("{}: line 1: column '{}' is missing; expected point,time_s,x_mm,y_mm,z_mm", name, columns[c]));
    at[c] = static_cast<std::size_t>(found - header.begin());
  }
  struct Row {
    double time;
    Vec3 x;
    long line;
  };
  std::map<long, std::vector<Row>> rows;
  for (long number = 2; std::getline(in, line); ++number) {
    const auto cells = cells_of(line);
    if (cells.empty() || (cells.size() == 1 && cells[0].empty())) continue;
    double v[5];
    for (std::size_t c = 0; c < 5; ++c) {
      const std::string where = fmt::format("{}: line {}: column {}: ", name, number, columns[c]);
      if (at[c] >= cells.size()) throw InputError(where + "missing");
      const std::string& cell = cells[at[c]];
      const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), v[c]);
      if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(v[c])) throw InputError(where + "'" + cell + "' is no finite number");
    }
    const long point = std::lround(v[0]);
    if (point < 0 || point > most_points || static_cast<double>(point) != v[0]) throw InputError(fmt::format("{}: line {}: point {} is no number 0, 1, 2 ...", name, number, v[0]));
    auto& own = rows[point];
    if (!own.empty() && !(v[1] > own.back().time)) throw InputError(fmt::format("{}: line {}: time {} s of point {} does not grow", name, number, v[1], point));
    own.push_back({v[1], Vec3(v[2], v[3], v[4]), number});
  }
  if (rows.empty()) throw InputError(name + ": no rows below the header");
  std::vector<double> times;
  for (const Row& r : rows.begin()->second) times.push_back(r.time);
  if (times.size() < 2) throw InputError(fmt::format("{}: point {} has one row; a motion needs two or more", name, rows.begin()->first));
  if (times.front() > 0) throw InputError(fmt::format("{}: starts at {} s; the first row must give the place at rest, at 0 s or before", name, times.front()));
  std::vector<Vec3> rest;
  std::vector<std::vector<Vec3>> displacements;
  for (const auto& [point, own] : rows) {
    if (point != static_cast<long>(rest.size())) throw InputError(fmt::format("{}: point {} is missing; points are numbered 0, 1, 2 ...", name, rest.size()));
    if (own.size() != times.size()) throw InputError(fmt::format("{}: point {} has {} rows, point 0 has {}; all points need the same times", name, point, own.size(), times.size()));
    rest.push_back(own.front().x);
    auto& u = displacements.emplace_back();
    for (std::size_t i = 0; i < own.size(); ++i) {
      if (own[i].time != times[i]) throw InputError(fmt::format("{}: line {}: time {} s differs from point 0's {} s", name, own[i].line, own[i].time, times[i]));
      u.push_back(own[i].x - own.front().x);
    }
  }
  return MotionTable(std::move(times), std::move(rest), std::move(displacements));
}

void write_motion(const std::filesystem::path& file, const std::vector<double>& times, const std::vector<Vec3>& rest,
                  const std::vector<std::vector<Vec3>>& displacements) {
  std::string text = "point,time_s,x_mm,y_mm,z_mm\n";
  for (std::size_t p = 0; p < rest.size(); ++p)
    for (std::size_t i = 0; i < times.size(); ++i) {
      const Vec3 x = rest[p] + displacements[p][i];
      text += fmt::format("{},{:.9g},{:.9g},{:.9g},{:.9g}\n", p, times[i], x.x(), x.y(), x.z());
    }
  write_text_atomically(file, text);
}

}  // namespace mv
