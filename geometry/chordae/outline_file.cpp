// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/chordae/outline_file.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "geometry/chordae/network_builder.h"
#include "geometry/core/case_files.h"
#include "geometry/core/csv_table.h"
#include "geometry/core/errors.h"

namespace mv {
namespace {

using Curves = std::vector<std::vector<Vec3>>;

Curves read_csv(const std::filesystem::path& file) {
  const CsvTable table(file, "x_mm,y_mm,z_mm and, for several curves, curve");
  const std::size_t x = table.column("x_mm"), y = table.column("y_mm"), z = table.column("z_mm");
  const auto of_curve = table.find("curve");
  if (of_curve) table.expect_in_every_row(*of_curve);
  Curves curves;
  std::string current;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::string name = of_curve ? table.text(row, *of_curve) : "";
    if (curves.empty() || name != current) curves.emplace_back();
    current = name;
    curves.back().emplace_back(table.number(row, x), table.number(row, y), table.number(row, z));
  }
  return curves;
}

Curves read_markups(const std::filesystem::path& file) {
  Curves curves;
  try {
    const auto json = nlohmann::json::parse(read_file(file));
    for (const auto& markup : json.at("markups")) {
      // Slicer's older files write 0 for RAS and 1 for LPS.
      const auto space = markup.value("coordinateSystem", nlohmann::json("LPS"));
      const bool is_lps = space == "LPS" || space == "1" || space == 1;
      if (!is_lps && space != "RAS" && space != "0" && space != 0)
        throw InputError(file.string() + ": coordinateSystem " + space.dump() + " is unknown; expected RAS or LPS");
      if (const auto unit = markup.value("coordinateUnits", std::string("mm")); unit != "mm" && !unit.starts_with("[\"mm\""))
        throw InputError(file.string() + ": coordinateUnits '" + unit + "'; expected mm");
      curves.emplace_back();
      for (const auto& point : markup.at("controlPoints")) {
        const auto& p = point.at("position");
        if (!p.is_array() || p.size() != 3) continue;  // a point that was never placed
        const double flip = is_lps ? -1 : 1;
        curves.back().emplace_back(flip * p[0].get<double>(), flip * p[1].get<double>(), p[2].get<double>());
      }
    }
  } catch (const nlohmann::json::exception& e) {
    throw InputError(file.string() + ": not a markups file of 3D Slicer: " + e.what());
  }
  return curves;
}

}  // namespace

Curves read_outlines(const std::filesystem::path& file, ChordaeSpace space) {
  if (!std::filesystem::is_regular_file(file)) throw IoError("cannot read " + file.string() + ": no such file");
  const std::string ending = file.extension().string();
  Curves curves;
  if (ending == ".json")
    curves = read_markups(file);
  else if (ending == ".csv")
    curves = read_csv(file);
  else if (ending == ".vtp" || ending == ".vtk")
    curves = read_polylines(file);
  else
    throw InputError(file.string() + ": unknown kind of curve file '" + ending + "'; expected .csv, .vtp, .vtk or .mrk.json");
  if (space == ChordaeSpace::lps && ending != ".json")
    for (auto& curve : curves)
      for (Vec3& x : curve) x = Vec3(-x.x(), -x.y(), x.z());
  if (curves.empty()) throw InputError(file.string() + ": holds no curve");
  for (const auto& curve : curves) {
    if (curve.size() < 2) throw InputError(fmt::format("{}: a curve has {} points, expected at least 2", file.string(), curve.size()));
    for (const Vec3& x : curve)
      if (!x.allFinite()) throw InputError(file.string() + ": a point is not finite");
  }
  return curves;
}

}  // namespace mv
