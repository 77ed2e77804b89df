// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/chordae/outline_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "geometry/chordae/network_builder.h"
#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"

namespace mv {
namespace {

using Curves = std::vector<std::vector<Vec3>>;

std::string trimmed(const std::string& text) {
  const auto a = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF"), b = text.find_last_not_of(" \t\r\n");
  return a == std::string::npos ? "" : text.substr(a, b - a + 1);
}

Curves read_csv(const std::filesystem::path& file) {
  std::istringstream in(read_file(file));
  std::string line;
  std::getline(in, line);
  const auto split = [](const std::string& row) {
    std::vector<std::string> cells;
    std::istringstream cut(row);
    for (std::string c; std::getline(cut, c, ',');) cells.push_back(trimmed(c));
    return cells;
  };
  std::map<std::string, std::size_t> column;
  for (const auto& names = split(line); const auto& name : names) column[name] = static_cast<std::size_t>(&name - names.data());
  for (const char* needed : {"x_mm", "y_mm", "z_mm"})
    if (!column.count(needed)) throw InputError(file.string() + ": line 1: column " + needed + " is missing; expected x_mm,y_mm,z_mm and, for several curves, curve");
  Curves curves;
  std::string current;
  for (int row = 2; std::getline(in, line); ++row) {
    if (trimmed(line).empty()) continue;
    const auto cells = split(line);
    Vec3 x;
    int k = 0;
    for (const char* name : {"x_mm", "y_mm", "z_mm"}) {
      const std::size_t c = column.at(name);
      const std::string text = c < cells.size() ? cells[c] : "";
      double value = 0;
      const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
      if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
        throw InputError(fmt::format("{}: line {}: {}: '{}' is not a finite number", file.string(), row, name, text));
      x[k++] = value;
    }
    const std::string name = column.count("curve") && column["curve"] < cells.size() ? cells[column["curve"]] : "";
    if (curves.empty() || name != current) curves.emplace_back();
    current = name;
    curves.back().push_back(x);
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
