// SPDX-License-Identifier: GPL-3.0-or-later
#include <cctype>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <string>

#include "geometry/annulus/annulus_fit.h"
#include "geometry/core/errors.h"

namespace mv {
namespace {

std::string trimmed(const std::string& text) {
  std::size_t a = 0, b = text.size();
  while (a < b && std::isspace(static_cast<unsigned char>(text[a]))) ++a;
  while (b > a && std::isspace(static_cast<unsigned char>(text[b - 1]))) --b;
  return text.substr(a, b - a);
}

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> cells;
  std::size_t start = 0;
  while (true) {
    const std::size_t comma = line.find(',', start);
    cells.push_back(trimmed(line.substr(start, comma == std::string::npos ? std::string::npos : comma - start)));
    if (comma == std::string::npos) return cells;
    start = comma + 1;
  }
}

}  // namespace

std::vector<Vec3> read_points_csv(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw IoError("cannot read " + file.string());
  std::string line;
  if (!std::getline(in, line)) throw InputError(file.string() + ": empty file, expected the header x_mm,y_mm,z_mm");
  if (line.rfind("\xEF\xBB\xBF", 0) == 0) line.erase(0, 3);
  const std::array<std::string, 3> names{"x_mm", "y_mm", "z_mm"};
  std::array<std::size_t, 3> column{};
  const std::vector<std::string> header = split(line);
  for (std::size_t k = 0; k < 3; ++k) {
    std::size_t c = 0;
    while (c < header.size() && header[c] != names[k]) ++c;
    if (c == header.size())
      throw InputError(file.string() + ": line 1: column " + names[k] + " is missing (header is '" + trimmed(line) +
                       "'); expected x_mm,y_mm,z_mm with lengths in mm");
    column[k] = c;
  }
  std::vector<Vec3> points;
  for (int number = 2; std::getline(in, line); ++number) {
    if (trimmed(line).empty()) continue;
    const std::vector<std::string> cells = split(line);
    Vec3 p;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::string where = file.string() + ": line " + std::to_string(number) + ": " + names[k];
      if (column[k] >= cells.size()) throw InputError(where + " is missing");
      const std::string& cell = cells[column[k]];
      double value = 0;
      const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
      if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value))
        throw InputError(where + ": '" + cell + "' is not a finite number");
      p[static_cast<Eigen::Index>(k)] = value;
    }
    points.push_back(p);
  }
  if (points.empty()) throw InputError(file.string() + ": no points below the header");
  return points;
}

}  // namespace mv
