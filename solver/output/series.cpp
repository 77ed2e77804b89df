// SPDX-License-Identifier: BSD-3-Clause
#include "solver/output/series.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <utility>
#include <variant>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"

namespace mv {

namespace fs = std::filesystem;

namespace {

/// Output times are written exactly; this only forgives the last digit of a checkpoint's time.
constexpr double time_tolerance = 1e-12;

std::vector<std::string> split(std::string_view line) {
  std::vector<std::string> cells;
  std::size_t begin = 0;
  for (;;) {
    const std::size_t comma = line.find(',', begin);
    cells.emplace_back(line.substr(begin, comma == std::string_view::npos ? comma : comma - begin));
    if (comma == std::string_view::npos) return cells;
    begin = comma + 1;
  }
}

/// Complete lines only: text after the last newline is what an interrupted write left.
std::vector<std::string_view> complete_lines(std::string_view text) {
  std::vector<std::string_view> lines;
  for (std::size_t begin = 0;;) {
    const std::size_t end = text.find('\n', begin);
    if (end == std::string_view::npos) return lines;
    std::string_view line = text.substr(begin, end - begin);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    lines.push_back(line);
    begin = end + 1;
  }
}

double to_number(std::string_view cell) {
  double value = std::numeric_limits<double>::quiet_NaN();
  if (cell.empty()) return value;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  return error == std::errc() && end == cell.data() + cell.size() ? value : std::numeric_limits<double>::quiet_NaN();
}

std::string joined(std::span<const std::string> cells) {
  std::string line;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i > 0) line += ',';
    line += cells[i];
  }
  line += '\n';
  return line;
}

[[noreturn]] void fail(const fs::path& file, const std::string& what) {
  throw IoError(file.string() + ": " + what + ": " + std::strerror(errno));
}

using Member = std::variant<double SeriesRow::*, std::string SeriesRow::*>;
struct Column {
  const char* name;
  Member member;
};

const std::vector<Column>& series_layout() {
#define MV_COLUMN(name) \
  { #name, &SeriesRow::name }
  static const std::vector<Column> layout{MV_COLUMN(time_s),
                                          MV_COLUMN(dt_s),
                                          MV_COLUMN(limiter),
                                          MV_COLUMN(pressure_difference_mmHg),
                                          MV_COLUMN(flow_ml_s),
                                          MV_COLUMN(volume_ml),
                                          MV_COLUMN(leak_net_ml_s),
                                          MV_COLUMN(contact_force_N),
                                          MV_COLUMN(contact_penalty_N),
                                          MV_COLUMN(contact_film_N),
                                          MV_COLUMN(contact_area_mm2),
                                          MV_COLUMN(penetration_max_mm),
                                          MV_COLUMN(papillary_force_0_N),
                                          MV_COLUMN(papillary_force_1_N),
                                          MV_COLUMN(chordae_primary_N),
                                          MV_COLUMN(chordae_secondary_N),
                                          MV_COLUMN(peak_velocity_m_s),
                                          MV_COLUMN(divergence_max),
                                          MV_COLUMN(kinetic_J),
                                          MV_COLUMN(elastic_J),
                                          MV_COLUMN(chordae_elastic_J),
                                          MV_COLUMN(work_pressure_J),
                                          MV_COLUMN(viscous_loss_J),
                                          MV_COLUMN(advection_loss_J),
                                          MV_COLUMN(friction_loss_J),
                                          MV_COLUMN(damping_loss_J),
                                          MV_COLUMN(boundary_kinetic_J),
                                          MV_COLUMN(energy_residual_relative),
                                          MV_COLUMN(J_min),
                                          MV_COLUMN(J_max),
                                          MV_COLUMN(distortion_controlled_fraction),
                                          MV_COLUMN(solid_volume_drift)};
#undef MV_COLUMN
  return layout;
}

const char* kind_name(ChordaKind kind) {
  constexpr const char* names[] = {"primary", "secondary", "strut", "basal", "marginal"};
  return names[static_cast<int>(kind)];
}

}  // namespace

std::string format_number(double value) {
  if (value == 0) return "0";  // no "-0"
  std::array<char, 32> text;
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() ? std::string(text.data(), end) : std::string("nan");
}

CsvWriter::CsvWriter(fs::path file, std::vector<std::string> columns, double resume_time)
    : file_(std::move(file)), columns_(std::move(columns)) {
  std::string text = joined(columns_);
  std::error_code ignored;
  if (resume_time >= 0 && fs::exists(file_, ignored)) {
    const std::string earlier = read_file(file_);
    const auto lines = complete_lines(earlier);
    if (lines.empty() || std::string(lines[0]) + "\n" != text)
      throw InputError(file_.string() +
                       ": its columns are not those of this version; start the run afresh or move the file away");
    for (std::size_t i = 1; i < lines.size(); ++i) {
      const double time = to_number(lines[i].substr(0, lines[i].find(',')));
      if (!(time <= resume_time + time_tolerance)) break;
      text += lines[i];
      text += '\n';
    }
  }
  write_text_atomically(file_, text);
  descriptor_ = ::open(file_.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  if (descriptor_ < 0) fail(file_, "cannot open for writing");
}

CsvWriter::CsvWriter(CsvWriter&& other) noexcept
    : file_(std::move(other.file_)), columns_(std::move(other.columns_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

CsvWriter::~CsvWriter() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void CsvWriter::append(std::span<const std::string> cells) {
  if (cells.size() != columns_.size())
    throw std::logic_error(file_.string() + ": row of " + std::to_string(cells.size()) + " cells for " +
                           std::to_string(columns_.size()) + " columns");
  const std::string line = joined(cells);
  struct stat before {};
  if (::fstat(descriptor_, &before) != 0) fail(file_, "cannot read its size");
  std::size_t written = 0;
  while (written < line.size()) {
    const ssize_t n = ::write(descriptor_, line.data() + written, line.size() - written);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      const int cause = errno;
      if (::ftruncate(descriptor_, before.st_size) != 0) errno = cause;
      errno = cause;
      fail(file_, "cannot append a row");
    }
    written += static_cast<std::size_t>(n);
  }
}

void CsvWriter::append(std::span<const double> values) {
  std::vector<std::string> cells;
  cells.reserve(values.size());
  for (double v : values) cells.push_back(std::isnan(v) ? std::string() : format_number(v));
  append(cells);
}

const std::vector<std::string>& series_columns() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> out;
    for (const Column& c : series_layout()) out.emplace_back(c.name);
    return out;
  }();
  return names;
}

SeriesWriter::SeriesWriter(const fs::path& results, double resume_time)
    : csv_(results / "series.csv", series_columns(), resume_time), cells_(series_columns().size()) {}

void SeriesWriter::append(const SeriesRow& row) {
  const auto& layout = series_layout();
  for (std::size_t i = 0; i < layout.size(); ++i) {
    if (const auto* text = std::get_if<std::string SeriesRow::*>(&layout[i].member)) {
      cells_[i] = row.**text;
    } else {
      const double value = row.*std::get<double SeriesRow::*>(layout[i].member);
      cells_[i] = std::isnan(value) ? std::string() : format_number(value);
    }
  }
  csv_.append(cells_);
}

std::vector<std::string> chordae_columns(const Chordae& chordae) {
  std::vector<std::string> columns{"time_s"};
  for (std::size_t i = 0; i < chordae.segments.size(); ++i) {
    const ChordaSegment& s = chordae.segments[i];
    char number[24];
    std::snprintf(number, sizeof number, "%02zu", i);
    const char* leaflet = s.leaflet == anterior ? "anterior" : s.leaflet == posterior ? "posterior" : "both";
    columns.push_back(std::string(kind_name(s.kind)) + "_" + number + "_" + leaflet + "_m" + std::to_string(s.muscle) + "_N");
  }
  return columns;
}

ChordaeSeriesWriter::ChordaeSeriesWriter(const fs::path& results, const Chordae& chordae, double resume_time)
    : csv_(results / "chordae.csv", chordae_columns(chordae), resume_time), values_(chordae.segments.size() + 1) {}

void ChordaeSeriesWriter::append(double time, std::span<const double> tensions) {
  values_[0] = time;
  std::copy(tensions.begin(), tensions.end(), values_.begin() + 1);
  csv_.append(values_);
}

bool SeriesTable::has(std::string_view column) const { return std::find(columns.begin(), columns.end(), column) != columns.end(); }

std::vector<std::string> SeriesTable::texts(std::string_view column) const {
  std::vector<std::string> out(rows.size());
  const auto at = std::find(columns.begin(), columns.end(), column);
  if (at == columns.end()) return out;
  const auto c = static_cast<std::size_t>(at - columns.begin());
  for (std::size_t r = 0; r < rows.size(); ++r) out[r] = rows[r][c];
  return out;
}

std::vector<double> SeriesTable::numbers(std::string_view column) const {
  std::vector<double> out;
  for (const std::string& cell : texts(column)) out.push_back(to_number(cell));
  return out;
}

SeriesTable read_csv(const fs::path& file) {
  const std::string text = read_file(file);
  SeriesTable table;
  for (std::string_view line : complete_lines(text)) {
    if (table.columns.empty()) {
      table.columns = split(line);
      continue;
    }
    table.rows.push_back(split(line));
    if (table.rows.back().size() != table.columns.size())
      throw InputError(file.string() + ": row " + std::to_string(table.rows.size()) + " has " +
                       std::to_string(table.rows.back().size()) + " cells, the header " + std::to_string(table.columns.size()));
  }
  if (table.columns.empty()) throw InputError(file.string() + ": no header line (empty or damaged)");
  return table;
}

}  // namespace mv
