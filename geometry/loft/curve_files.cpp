// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/loft/curve_files.h"

#include <fmt/format.h>
#include <vtkCellArray.h>
#include <vtkFieldData.h>
#include <vtkIdList.h>
#include <vtkPolyData.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "geometry/annulus/annulus_check.h"
#include "geometry/annulus/closed_curve.h"
#include "geometry/core/case_files.h"
#include "geometry/core/config.h"
#include "geometry/core/csv_table.h"
#include "geometry/core/errors.h"
#include "geometry/core/vtk_dataset.h"

namespace mv {
namespace {

constexpr std::size_t longest_name = 60;  // characters that a message repeats

using nlohmann::json;

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

Vec3 to_ras(const Vec3& x, bool is_lps) { return is_lps ? Vec3(-x.x(), -x.y(), x.z()) : x; }

void add_papillary(CurveSet& set, const Vec3& x, const std::string& name) {
  set.papillary_points.push_back(x);
  const std::string n = lower(name);
  const bool is_al = n.find("anterolateral") != std::string::npos || n.find("antlat") != std::string::npos;
  const bool is_pm = n.find("posteromedial") != std::string::npos || n.find("postmed") != std::string::npos;
  set.papillary_names.push_back(is_al == is_pm ? "" : is_al ? "anterolateral" : "posteromedial");
}

void set_annulus(CurveSet& set, const std::vector<Vec3>& points, const std::string& where) {
  if (!set.annulus_curve.empty()) throw InputError(where + ": a second annulus curve; expected one");
  if (points.size() < 8) throw InputError(fmt::format("{}: the annulus has {} points, at least 8 are needed", where, points.size()));
  for (const Vec3& p : points)
    if (!p.allFinite()) throw InputError(where + ": the annulus has a point that is not finite");
  for (const std::string& note : check_annulus_curve(clean_closed_curve(points, nullptr, where), where)) set.notes.push_back(note);
  set.annulus_curve = points;
}

void read_csv(const std::filesystem::path& file, bool is_lps, CurveSet& set) {
  const CsvTable table(file, "leaflet,curve,x_mm,y_mm,z_mm (and thickness_mm if known)");
  const std::size_t of_leaflet = table.column("leaflet"), of_curve = table.column("curve"), of_x[] = {table.column("x_mm"), table.column("y_mm"), table.column("z_mm")};
  const auto of_thickness = table.find("thickness_mm");
  std::vector<LeafletCurve> curves;
  std::map<std::pair<int, std::string>, std::size_t> known;
  std::vector<Vec3> annulus;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const Vec3 x = to_ras({table.number(row, of_x[0]), table.number(row, of_x[1]), table.number(row, of_x[2])}, is_lps);
    const std::string leaflet = lower(table.text(row, of_leaflet)), id = table.text(row, of_curve);
    if (leaflet == "annulus") {
      annulus.push_back(x);
      continue;
    }
    if (leaflet.starts_with("papillary")) {
      add_papillary(set, x, leaflet);
      continue;
    }
    if (leaflet != "anterior" && leaflet != "posterior")
      throw InputError(fmt::format("{}: leaflet '{}'; expected anterior, posterior, annulus, papillary_anterolateral or papillary_posteromedial", table.where(row), leaflet.substr(0, longest_name)));
    const int region = leaflet == "anterior" ? anterior : posterior;
    const auto [place, is_new] = known.emplace(std::pair(region, id), curves.size());
    if (is_new) {
      curves.emplace_back();
      curves.back().name = fmt::format("{}: {} curve {}", file.string(), leaflet, id);
      curves.back().region = region;
    }
    LeafletCurve& curve = curves[place->second];
    curve.points.push_back(x);
    if (!of_thickness) continue;
    const double t = table.number(row, *of_thickness);
    if (!(t > 0)) throw InputError(fmt::format("{}: thickness_mm {}; expected a positive length", table.where(row), t));
    curve.thickness.push_back(t);
  }
  if (table.rows() == 0) throw InputError(file.string() + ": no points below the header");
  if (!annulus.empty()) set_annulus(set, annulus, file.string());
  set.curves.insert(set.curves.end(), curves.begin(), curves.end());
}

void read_vtp(const std::filesystem::path& file, bool is_lps, CurveSet& set) {
  const auto data = read_foreign_poly_data(file);
  const DatasetReader reader(file, data);
  const std::vector<double> x = reader.coordinates();
  vtkCellArray* lines = data->GetLines();
  if (!lines || lines->GetNumberOfCells() == 0)
    throw InputError(fmt::format("{}: no polylines ({} polygons); expected one line per leaflet curve", file.string(), data->GetNumberOfPolys()));
  if (data->GetNumberOfCells() != lines->GetNumberOfCells())
    throw InputError(fmt::format("{}: {} cells besides the {} polylines; expected polylines only", file.string(), data->GetNumberOfCells() - lines->GetNumberOfCells(),
                                 lines->GetNumberOfCells()));
  std::vector<int> regions;
  for (const char* name : {"leaflet", "region"})
    if (regions.empty() && reader.has(DatasetReader::Place::cells, name))
      regions = reader.integers(DatasetReader::Place::cells, name, posterior, anterior, 1, lines->GetNumberOfCells());
  const bool says_space = reader.has(DatasetReader::Place::field, "SPACE");
  const int of_file = region_of_name(file.filename().string());
  vtkNew<vtkIdList> ids;
  for (vtkIdType c = 0; c < lines->GetNumberOfCells(); ++c) {
    lines->GetCellAtId(c, ids);
    LeafletCurve curve;
    curve.name = fmt::format("{}: line {}", file.string(), c + 1);
    curve.region = regions.empty() ? of_file : regions[static_cast<std::size_t>(c)];
    for (vtkIdType k = 0; k < ids->GetNumberOfIds(); ++k) {
      const auto p = static_cast<std::size_t>(3 * ids->GetId(k));
      curve.points.push_back(to_ras({x[p], x[p + 1], x[p + 2]}, is_lps && !says_space));
    }
    set.curves.push_back(curve);
  }
}

[[noreturn]] void fail(const std::string& where, const std::string& what) { throw InputError(where + ": " + what); }

void add_markup(const json& markup, const std::filesystem::path& file, const std::string& where, CurveSet& set) {
  const std::string type = markup.value("type", "");
  const std::string system = markup.contains("coordinateSystem") && markup["coordinateSystem"].is_string() ? markup["coordinateSystem"].get<std::string>() : "";
  if (system != "LPS" && system != "RAS")
    fail(where, "coordinateSystem " + (markup.contains("coordinateSystem") ? markup["coordinateSystem"].dump() : "is missing") + "; expected \"LPS\" or \"RAS\"");
  const std::string units = markup.value("coordinateUnits", "mm");
  if (units != "mm") fail(where, "coordinateUnits \"" + units + "\"; expected mm");
  std::vector<Vec3> points;
  std::vector<std::string> labels;
  if (!markup.contains("controlPoints") || !markup["controlPoints"].is_array()) fail(where, "controlPoints are missing");
  for (const json& p : markup["controlPoints"]) {
    if (p.value("positionStatus", "defined") != "defined") continue;
    const std::string point = fmt::format("control point {}", points.size() + 1);
    if (!p.contains("position") || !p["position"].is_array() || p["position"].size() != 3) fail(where, point + " has no position of three numbers");
    Vec3 x;
    for (int k = 0; k < 3; ++k) {
      const json& value = p["position"][static_cast<std::size_t>(k)];
      if (!value.is_number() || !std::isfinite(value.get<double>())) fail(where, point + ": coordinate " + value.dump() + " is not a finite number");
      x(k) = value.get<double>();
    }
    points.push_back(to_ras(x, system == "LPS"));
    labels.push_back(p.value("label", ""));
  }
  const std::string name = markup.value("name", "");
  if (type == "Fiducial") {
    for (std::size_t i = 0; i < points.size(); ++i) add_papillary(set, points[i], labels[i] + " " + name + " " + file.filename().string());
  } else if (type == "ClosedCurve") {
    set_annulus(set, points, where);
  } else if (type == "Curve" || type == "Line") {
    LeafletCurve curve;
    curve.name = where;
    curve.points = points;
    curve.region = region_of_name(name);
    if (curve.region == 0) curve.region = region_of_name(file.filename().string());
    if (curve.region == 0) fail(where, "neither the markup's name nor the file's tells the leaflet; expected 'anterior' or 'posterior' in it");
    set.curves.push_back(curve);
  } else {
    fail(where, "type \"" + type + "\"; expected Curve or Line (leaflet), ClosedCurve (annulus) or Fiducial (papillary points)");
  }
}

void read_markups(const std::filesystem::path& file, CurveSet& set) {
  json root;
  try {
    root = json::parse(read_file(file));
  } catch (const json::exception& e) {
    throw InputError(file.string() + ": not valid JSON (" + e.what() + "); expected markups saved by 3D Slicer");
  }
  if (!root.is_object() || !root.contains("markups") || !root["markups"].is_array() || root["markups"].empty())
    throw InputError(file.string() + ": no list 'markups'; expected markups saved by 3D Slicer (.mrk.json)");
  int number = 0;
  for (const json& markup : root["markups"]) {
    ++number;
    const std::string where = root["markups"].size() == 1 ? file.string() : fmt::format("{}: markup {}", file.string(), number);
    try {
      add_markup(markup, file, where, set);
    } catch (const json::exception& e) {
      throw InputError(where + ": " + e.what());
    }
  }
}

}  // namespace

int region_of_name(const std::string& name) {
  const std::string n = lower(name);
  const auto has = [&](const char* part) { return n.find(part) != std::string::npos; };
  const bool is_anterior = has("anterior") || has("aml"), is_posterior = has("posterior") || has("pml");
  return is_anterior == is_posterior ? 0 : is_anterior ? anterior : posterior;
}

void read_curves(const std::filesystem::path& file, bool is_lps, CurveSet& set) {
  const std::string name = lower(file.filename().string());
  if (name.ends_with(".csv")) read_csv(file, is_lps, set);
  else if (name.ends_with(".vtp")) read_vtp(file, is_lps, set);
  else if (name.ends_with(".json")) read_markups(file, set);
  else throw InputError(file.string() + ": unknown kind of curve file; expected .csv, .vtp or .mrk.json");
}

}  // namespace mv
