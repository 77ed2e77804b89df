// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <cmath>

#include "geometry/annulus/annulus_fit.h"
#include "geometry/core/csv_table.h"
#include "geometry/core/errors.h"

namespace mv {
namespace {

constexpr double farthest = 1e5;  // mm from the origin of a scanner's space

}  // namespace

std::vector<Vec3> read_points_csv(const std::filesystem::path& file) {
  const CsvTable table(file, "x_mm,y_mm,z_mm");
  const std::size_t column[] = {table.column("x_mm"), table.column("y_mm"), table.column("z_mm")};
  std::vector<Vec3> points;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    Vec3& p = points.emplace_back();
    for (Eigen::Index k = 0; k < 3; ++k) {
      p[k] = table.number(row, column[k]);
      if (std::abs(p[k]) > farthest)
        throw InputError(fmt::format("{}: {}: '{}' mm is no place in a body; expected millimetres", table.where(row), table.columns()[column[k]], table.text(row, column[k])));
    }
  }
  if (points.empty()) throw InputError(file.string() + ": no points below the header");
  return points;
}

}  // namespace mv
