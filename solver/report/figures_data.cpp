// SPDX-License-Identifier: BSD-3-Clause
#include "solver/report/figures_data.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>

#include "solver/report/html.h"

namespace mv {

namespace {

constexpr std::size_t most_rows = 2000;
constexpr double map_step = 0.3;     // mm
constexpr double end_window = 0.05;  // s, the chordae's forces "at the end" are means over it

/// Null for what is not finite.
Json rounded(double value, int digits = 5) {
  if (!std::isfinite(value)) return nullptr;
  char text[40];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return std::strtod(text, nullptr);
}

std::string spaced(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

std::size_t stride_of(std::size_t rows) { return rows <= most_rows ? 1 : (rows + most_rows - 1) / most_rows; }

Json column(const std::vector<double>& values, double factor = 1) {
  Json out = Json::array();
  for (std::size_t i = 0; i < values.size(); i += stride_of(values.size())) out.push_back(rounded(factor * values[i]));
  return out;
}

bool has_number(const std::vector<double>& values) {
  return std::any_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

/// Parts of a column name such as "primary_03_anterior_m0_N".
struct ChordaName {
  std::string kind, number, leaflet, muscle;
};

bool parse_chorda(const std::string& column, ChordaName& name) {
  std::vector<std::string> parts(1);
  for (char c : column) {
    if (c == '_')
      parts.emplace_back();
    else
      parts.back() += c;
  }
  if (parts.size() != 5 || parts[4] != "N") return false;
  name = {parts[0], parts[1], parts[2], parts[3]};
  return true;
}

/// Two drawn kinds: those that end at the border, and those inside.
std::string group_of(const std::string& kind) { return kind == "primary" || kind == "marginal" ? "primary" : "secondary"; }

Json chordae_data(const SeriesTable& table, const Json& muscles) {
  const std::vector<double> time = table.numbers("time_s");
  struct Group {
    std::vector<double> sum, lowest, highest;
    int count = 0;
  };
  std::map<std::string, Group> groups;
  Json bars = Json::array();
  for (const std::string& c : table.columns) {
    ChordaName name;
    if (!parse_chorda(c, name)) continue;
    const std::vector<double> force = table.numbers(c);
    Group& g = groups[group_of(name.kind)];
    if (g.count == 0) {
      g.sum.assign(force.size(), 0.0);
      g.lowest = g.highest = force;
    }
    ++g.count;
    double at_end = 0;
    int rows_at_end = 0;
    for (std::size_t i = 0; i < force.size(); ++i) {
      g.sum[i] += force[i];
      g.lowest[i] = std::min(g.lowest[i], force[i]);
      g.highest[i] = std::max(g.highest[i], force[i]);
      if (time[i] >= time.back() - end_window && std::isfinite(force[i])) {
        at_end += force[i];
        ++rows_at_end;
      }
    }
    const int muscle = std::atoi(name.muscle.c_str() + 1);
    bars.push_back({{"label", name.number},
                    {"kind", group_of(name.kind)},
                    {"force", rounded(rows_at_end > 0 ? at_end / rows_at_end : NAN, 4)},
                    {"leaflet", name.leaflet},
                    {"muscle", muscle < static_cast<int>(muscles.size()) ? muscles[static_cast<std::size_t>(muscle)]
                                                                         : Json("muscle " + std::to_string(muscle))}});
  }
  if (groups.empty()) return nullptr;
  Json out;
  out["time_ms"] = column(time, 1e3);
  for (auto& [kind, g] : groups)
    out["groups"][kind] = {
        {"count", g.count}, {"mean", column(g.sum, 1.0 / g.count)}, {"min", column(g.lowest)}, {"max", column(g.highest)}};
  out["bars"] = std::move(bars);
  return out;
}

Json lines_of(const std::vector<MapLine>& lines) {
  Json out = Json::array();
  for (const MapLine& line : lines) {
    Json points = Json::array();
    for (const Vec2& p : line) points.push_back({rounded(p.x()), rounded(p.y())});
    out.push_back(std::move(points));
  }
  return out;
}

Json map_data(const ContactMap& map, const MapView& view, double pressure_scale) {
  const MapGrid grid = sample_map(map, map_step);
  Json out;
  out["u0"] = rounded(grid.u0);
  out["v0"] = rounded(grid.v0);
  out["step"] = grid.step;
  out["columns"] = grid.columns;
  out["rows"] = grid.rows;
  out["scale"] = pressure_scale;
  Json pressure = Json::array(), gap = Json::array(), region = Json::array();
  for (int j = 0; j < grid.rows; ++j) {
    Json p = Json::array(), g = Json::array(), r = Json::array();
    for (int i = 0; i < grid.columns; ++i) {
      const auto c = static_cast<std::size_t>(j) * static_cast<std::size_t>(grid.columns) + static_cast<std::size_t>(i);
      p.push_back(rounded(grid.pressure[c], 3));
      g.push_back(rounded(grid.gap[c], 3));
      r.push_back(grid.region[c]);
    }
    pressure.push_back(std::move(p));
    gap.push_back(std::move(g));
    region.push_back(std::move(r));
  }
  out["pressure"] = std::move(pressure);
  out["gap"] = std::move(gap);
  out["region"] = std::move(region);
  out["outline"] = lines_of(view.outline);
  out["belt"] = lines_of(view.belt);
  out["commissures"] = lines_of(view.commissures);
  out["labels"] = Json::array();
  for (const MapLabel& label : view.labels)
    out["labels"].push_back(
        {{"name", label.name}, {"u", rounded(label.u)}, {"v", rounded(label.v)}, {"commissure", label.is_commissure}});
  return out;
}

/// Where a hole is on the map: u of the atrial points nearest to its place in the last frame, one on each leaflet that borders on
/// it (no more than `border` mm further away than the nearer one). Empty when its place is not known.
Json places_on_map(const ResultsData& data, const Json& hole) {
  constexpr double border = 3;
  Json places = Json::array();
  if (!data.map || !data.frames.closed || !hole.contains("place_mm") || !hole["place_mm"].is_array() ||
      hole["place_mm"].size() != 3)
    return places;
  Vec3 place;
  for (std::size_t k = 0; k < 3; ++k)
    place[static_cast<Eigen::Index>(k)] = hole["place_mm"][k].is_number() ? hole["place_mm"][k].get<double>() : NAN;
  const auto& points = data.frames.closed->mesh.points;
  std::map<int, std::pair<double, double>> nearest;  // region -> distance, u
  for (std::size_t i = 0; i < data.map->points.size(); ++i) {
    const auto p = static_cast<std::size_t>(data.map->mesh_point[i]);
    if (p >= points.size()) continue;
    const double distance = (points[p] - place).norm();
    const auto [at, is_new] = nearest.try_emplace(data.map->region[i], distance, data.map->points[i].x());
    if (!is_new && distance < at->second.first) at->second = {distance, data.map->points[i].x()};
  }
  double closest = INFINITY;
  for (const auto& [region, found] : nearest) closest = std::min(closest, found.first);
  for (const auto& [region, found] : nearest)
    if (found.first <= closest + border) places.push_back(rounded(found.second, 4));
  return places;
}

}  // namespace

Json figure_data(const ResultsData& data, const std::optional<MapView>& view, double pressure_scale) {
  Json out;
  out["papillary"] = Json{"anterolateral", "posteromedial"};
  if (const Json& names = json_at(data.run, "case.papillary"); names.is_array() && names.size() >= 2) out["papillary"] = names;
  out["series"] = Json::object();
  if (data.series && !data.series->rows.empty()) {
    out["time_ms"] = column(data.series->numbers("time_s"), 1e3);
    for (const std::string& c : data.series->columns) {
      if (c == "time_s" || c == "limiter") continue;
      const std::vector<double> values = data.series->numbers(c);
      if (has_number(values)) out["series"][c] = column(values);
    }
    const std::vector<std::string> limiter = data.series->texts("limiter");
    out["limiter"] = Json::array();
    for (std::size_t i = 0; i < limiter.size(); i += stride_of(limiter.size())) out["limiter"].push_back(spaced(limiter[i]));
  }
  if (const Json& closing = json_at(data.summary, "flow.closing_time_s"); closing.is_number())
    out["closing_ms"] = rounded(1e3 * closing.get<double>());
  if (data.chordae && !data.chordae->rows.empty()) {
    Json chordae = chordae_data(*data.chordae, out["papillary"]);
    if (!chordae.is_null()) out["chordae"] = std::move(chordae);
  }
  if (data.map && view) out["map"] = map_data(*data.map, *view, pressure_scale);
  if (const Json& holes = json_at(data.summary, "seal.holes"); holes.is_array())
    for (const Json& hole : holes)
      if (hole.is_object() && hole.contains("area_mm2"))
        out["holes"].push_back({{"u", places_on_map(data, hole)}, {"area", html::number(hole.value("area_mm2", NAN))}});
  if (const Json& gaps = json_at(data.summary, "contact.belt_interruptions"); gaps.is_array())
    for (const Json& gap : gaps)
      if (gap.is_object() && gap.contains("u_from_mm") && gap.contains("u_to_mm"))
        out["interruptions"].push_back({{"from", gap["u_from_mm"]}, {"to", gap["u_to_mm"]}});
  return out;
}

}  // namespace mv
