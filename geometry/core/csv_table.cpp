// SPDX-License-Identifier: BSD-3-Clause
#include "geometry/core/csv_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"

namespace mv {
namespace {

constexpr std::size_t longest_quote = 80;  // characters of a file that a message repeats

std::string shortened(std::string_view text) {
  return text.size() <= longest_quote ? std::string(text) : std::string(text.substr(0, longest_quote)) + "...";
}

std::string trimmed(std::string_view text) {
  const auto a = text.find_first_not_of(" \t\""), b = text.find_last_not_of(" \t\"");
  return a == std::string_view::npos ? "" : std::string(text.substr(a, b - a + 1));
}

/// Cells of a line; a separator between quotes belongs to its cell.
std::vector<std::string> cells_of(std::string_view line, char separator) {
  std::vector<std::string> cells;
  std::size_t start = 0;
  bool is_quoted = false;
  for (std::size_t i = 0; i <= line.size(); ++i) {
    if (i < line.size() && line[i] == '"') is_quoted = !is_quoted;
    if (i < line.size() && (line[i] != separator || is_quoted)) continue;
    cells.push_back(trimmed(line.substr(start, i - start)));
    start = i + 1;
  }
  return cells;
}

std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  for (std::size_t start = 0; start < text.size();) {
    const std::size_t end = std::min(text.find_first_of("\r\n", start), text.size());
    lines.push_back(text.substr(start, end - start));
    start = end + (text.substr(end, 2) == "\r\n" ? 2 : 1);
  }
  return lines;
}

bool is_blank(std::string_view line) { return line.find_first_not_of(" \t,;\"") == std::string_view::npos; }

char separator_of(std::string_view header) {
  for (const char c : {',', ';', '\t'})
    if (header.find(c) != std::string_view::npos) return c;
  return ',';
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ",") + name;
  return text;
}

}  // namespace

CsvTable::CsvTable(const std::filesystem::path& file, std::string_view expected) : file_(file.string()), expected_(expected) {
  if (std::filesystem::is_directory(file)) throw IoError(file_ + ": is a directory; expected a CSV file with the header " + expected_);
  std::string bytes = read_file(file);
  if (bytes.starts_with("\xEF\xBB\xBF")) bytes.erase(0, 3);
  if (bytes.find('\0') != std::string::npos) throw InputError(file_ + ": holds bytes that are no text (UTF-16, or a binary file?); expected CSV in UTF-8 with the header " + expected_);
  const auto lines = lines_of(bytes);
  std::size_t header = 0;
  while (header < lines.size() && is_blank(lines[header])) ++header;
  if (header == lines.size()) throw InputError(file_ + ": is empty; expected the header " + expected_ + " and a row for each point");
  separator_ = separator_of(lines[header]);
  columns_ = cells_of(lines[header], separator_);
  for (std::size_t i = header + 1; i < lines.size(); ++i) {
    if (is_blank(lines[i])) continue;
    auto cells = cells_of(lines[i], separator_);
    while (cells.size() > columns_.size() && cells.back().empty()) cells.pop_back();
    if (cells.size() > columns_.size()) {
      const char* hint = separator_ == ',' && cells.size() == 2 * columns_.size() ? "; are these decimal commas? Numbers need decimal points" : "";
      throw InputError(fmt::format("{}: line {}: {} values, the header has {} columns ({}){}", file_, i + 1, cells.size(), columns_.size(), shortened(joined(columns_)), hint));
    }
    widths_.push_back(cells.size());
    cells.resize(columns_.size());
    cells_.insert(cells_.end(), std::make_move_iterator(cells.begin()), std::make_move_iterator(cells.end()));
    lines_.push_back(static_cast<int>(i) + 1);
  }
}

std::optional<std::size_t> CsvTable::find(std::string_view name) const {
  const auto found = std::find(columns_.begin(), columns_.end(), name);
  if (found == columns_.end()) return std::nullopt;
  if (std::find(found + 1, columns_.end(), name) != columns_.end()) throw InputError(fmt::format("{}: column '{}' is there twice; expected {}", file_, shortened(name), expected_));
  return static_cast<std::size_t>(found - columns_.begin());
}

std::size_t CsvTable::column(std::string_view name) const {
  if (const auto found = find(name)) return *found;
  throw InputError(fmt::format("{}: column '{}' is missing (the header is '{}'); expected {}", file_, name, shortened(joined(columns_)), expected_));
}

void CsvTable::expect_in_every_row(std::size_t column) const {
  for (std::size_t row = 0; row < rows(); ++row)
    if (widths_[row] <= column)
      throw InputError(fmt::format("{}: {} values, '{}' is column {} of the header ({})", where(row), widths_[row], columns_[column], column + 1, shortened(joined(columns_))));
}

double CsvTable::number(std::size_t row, std::size_t column) const {
  const std::string& cell = text(row, column);
  const std::string_view digits = std::string_view(cell).substr(cell.starts_with('+') && !cell.starts_with("+-") ? 1 : 0);  // from_chars takes no plus
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error == std::errc() && end == digits.data() + digits.size() && std::isfinite(value)) return value;
  const char* hint = cell.find(',') != std::string::npos ? "; numbers need decimal points" : "";
  throw InputError(fmt::format("{}: {}: '{}' is not a finite number{}", where(row), columns_[column], shortened(cell), hint));
}

std::string CsvTable::line(std::size_t row) const { return fmt::format("line {}", lines_[row]); }

std::string CsvTable::where(std::size_t row) const { return file_ + ": " + line(row); }

}  // namespace mv
