// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Tables of measured values as spreadsheets and segmentation tools write them, with errors that name file, line and column.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace mv {

/// A CSV file: a header line of column names, then rows with as many cells; those that a row lacks at its end are empty. Commas, semicolons or tabs between cells (the header tells which), any line ends (LF, CR LF,
/// CR), quotes around cells, a byte order mark and empty lines are taken. Numbers have decimal points.
class CsvTable {
 public:
  /// `expected`: the header as errors name it, e.g. "x_mm,y_mm,z_mm". Throws IoError when unreadable or a directory, InputError when empty, no text, or a row has more cells than
  /// the header that are not empty.
  CsvTable(const std::filesystem::path& file, std::string_view expected);

  std::size_t rows() const { return lines_.size(); }
  const std::vector<std::string>& columns() const { return columns_; }
  /// Throws InputError when the column is there twice.
  std::optional<std::size_t> find(std::string_view name) const;
  /// Throws InputError when there is none, or two.
  std::size_t column(std::string_view name) const;

  /// Throws InputError when a row ends before the column: a cell that is missing further left has moved the others.
  void expect_in_every_row(std::size_t column) const;

  const std::string& text(std::size_t row, std::size_t column) const { return cells_[row * columns_.size() + column]; }
  /// Throws InputError unless the cell is a finite number.
  double number(std::size_t row, std::size_t column) const;
  bool is_empty(std::size_t row, std::size_t column) const { return text(row, column).empty(); }

  const std::string& file() const { return file_; }
  /// "line 12", as an editor counts.
  std::string line(std::size_t row) const;
  /// "FILE: line 12".
  std::string where(std::size_t row) const;

 private:
  std::string file_, expected_;
  char separator_ = ',';
  std::vector<std::string> columns_, cells_;
  std::vector<int> lines_;
  std::vector<std::size_t> widths_;  // cells of each row in the file
};

}  // namespace mv
