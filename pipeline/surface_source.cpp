// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/surface_source.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>

#include "geometry/core/errors.h"
#include "geometry/core/log.h"
#include "geometry/surface/mid_surface_of_solid.h"
#include "geometry/surface/repair.h"
#include "geometry/surface/sheet_remesh.h"
#include "pipeline/patient_source.h"

namespace mv {
namespace {

constexpr double tip_cap = 2;                  // mm below the top of a muscle that its tip is the mean of
constexpr double smallest_muscle_share = 0.05;  // of the area in the file

std::size_t at(long i) { return static_cast<std::size_t>(i); }

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

void add_notes(RawLeaflets& raw, const std::vector<std::string>& notes) { raw.notes.insert(raw.notes.end(), notes.begin(), notes.end()); }

void to_ras(std::vector<Vec3>& points, const Config& config) {
  if (config.text("surface.space") != "LPS") return;
  for (Vec3& p : points) p.head<2>() *= -1;
}

struct Weighted {
  double area = 0;
  Vec3 sum = Vec3::Zero();
  void add(double a, const Vec3& x) { area += a, sum += a * x; }
  Vec3 mean() const { return sum / area; }
};

double triangle_area(const std::vector<Vec3>& p, const std::array<int, 3>& t) {
  return 0.5 * (p[at(t[1])] - p[at(t[0])]).cross(p[at(t[2])] - p[at(t[0])]).norm();
}
Vec3 triangle_middle(const std::vector<Vec3>& p, const std::array<int, 3>& t) { return (p[at(t[0])] + p[at(t[1])] + p[at(t[2])]) / 3; }

SurfaceKind kind_of(const Config& config) {
  for (const SurfaceKind kind : {SurfaceKind::thick, SurfaceKind::double_wall, SurfaceKind::mid})
    if (to_string(kind) == config.text("surface.kind")) return kind;
  return SurfaceKind::automatic;
}

/// Region per triangle from the names of the groups; empty when they tell nothing.
std::vector<int> regions_of(const RepairedSurface& surface, const std::vector<std::string>& names, std::vector<std::string>& notes) {
  std::vector<int> region_of_group;
  bool is_told = false;
  for (const std::string& name : names) {
    const bool is_anterior = lower(name).find("anterior") != std::string::npos, is_posterior = lower(name).find("posterior") != std::string::npos;
    region_of_group.push_back(is_anterior == is_posterior ? 0 : static_cast<int>(is_anterior ? Region::anterior : Region::posterior));
    is_told = is_told || region_of_group.back() != 0;
    notes.push_back(fmt::format("group '{}' is {}", name, is_anterior == is_posterior ? "not told to be a leaflet" : is_anterior ? "the anterior leaflet" : "the posterior leaflet"));
  }
  std::vector<int> region;
  if (!is_told) return region;
  for (const int group : surface.group) region.push_back(group < 0 ? 0 : region_of_group[at(group)]);
  return region;
}

void read_muscles(const Config& config, const Vec3& valve, RawLeaflets& raw) {
  for (const auto& file : config.paths("surface.papillary")) {
    const std::string name = lower(file.filename().string());
    std::vector<Vec3> tips;
    if (lower(file.extension().string()) == ".csv") {
      tips = read_points_csv(file);
      to_ras(tips, config);
    } else {
      RawSurface muscles = read_surface(file, config.text("surface.unit"));
      to_ras(muscles.points, config);
      add_notes(raw, muscles.notes);
      tips = muscle_tips(muscles, valve, file.string());
    }
    const bool is_anterolateral = name.find("anterolateral") != std::string::npos, is_posteromedial = name.find("posteromedial") != std::string::npos;
    for (const Vec3& tip : tips) {
      raw.papillary_points.push_back(tip);
      raw.papillary_names.emplace_back(is_anterolateral == is_posteromedial ? "" : is_anterolateral ? "anterolateral" : "posteromedial");
    }
  }
}

}  // namespace

std::vector<Vec3> muscle_tips(const RawSurface& muscles, const Vec3& valve, const std::string& name) {
  int count = 0;
  const std::vector<int> part = connected_parts(muscles.triangles, muscles.points.size(), &count);
  std::vector<Weighted> parts(at(count));
  double whole = 0;
  for (std::size_t t = 0; t < part.size(); ++t) {
    const double area = triangle_area(muscles.points, muscles.triangles[t]);
    parts[at(part[t])].add(area, triangle_middle(muscles.points, muscles.triangles[t]));
    whole += area;
  }
  std::vector<Vec3> tips;
  for (int c = 0; c < count; ++c) {
    if (!(parts[at(c)].area >= smallest_muscle_share * whole) || !(whole > 0)) continue;
    const Vec3 towards = valve - parts[at(c)].mean();
    if (!(towards.norm() > tip_cap)) throw InputError("surface.papillary: " + name + " lies around the leaflets; expected a papillary muscle");
    const Vec3 up = towards.normalized();
    double top = -1e300;
    for (std::size_t t = 0; t < part.size(); ++t)
      if (part[t] == c)
        for (const int v : muscles.triangles[t]) top = std::max(top, up.dot(muscles.points[at(v)]));
    Weighted cap;
    Vec3 highest = Vec3::Zero();
    for (std::size_t t = 0; t < part.size(); ++t) {
      if (part[t] != c) continue;
      const Vec3 middle = triangle_middle(muscles.points, muscles.triangles[t]);
      if (up.dot(middle) > top - tip_cap) cap.add(triangle_area(muscles.points, muscles.triangles[t]), middle);
      for (const int v : muscles.triangles[t])
        if (up.dot(muscles.points[at(v)]) >= top) highest = muscles.points[at(v)];
    }
    tips.push_back(cap.area > 0 ? cap.mean() : highest);  // coarse triangles may have no middle in the cap
  }
  if (tips.empty()) throw InputError("surface.papillary: " + name + " has no area; expected a papillary muscle");
  return tips;
}

namespace {

/// The file's surface, repaired.
RepairedSurface repaired_of(const Config& config, std::vector<int>& region, std::vector<std::string>& notes) {
  if (config.text("surface.file").empty())
    throw ConfigError("key 'surface.file' is empty: source.kind = \"surface\" needs a surface, e.g. surface.file = \"valve.stl\"");
  RawSurface file = read_surface(config.path("surface.file"), config.text("surface.unit"));
  expect_valve_size(file, config.path("surface.file").string(), config.text("surface.unit"));
  to_ras(file.points, config);
  notes.insert(notes.end(), file.notes.begin(), file.notes.end());
  RepairOptions options;
  options.kind = kind_of(config);
  RepairedSurface surface = repair_surface(file, options);
  for (const std::string& line : surface.report) notes.push_back("repair: " + line);
  region = regions_of(surface, file.group_names, notes);
  return surface;
}

}  // namespace

SolidSurface read_thick_surface(const Config& config) {
  std::vector<int> region;
  std::vector<std::string> notes;  // the source stage has told them
  RepairedSurface surface = repaired_of(config, region, notes);
  if (surface.kind == SurfaceKind::mid)
    throw ConfigError("key 'mesh.path' = \"thick\": " + config.path("surface.file").string() + " is a mid-surface (surface.kind); expected closed thick leaflets, or mesh.path = \"mid\"");
  return {std::move(surface.points), std::move(surface.triangles), std::move(region)};
}

RawLeaflets read_surface_leaflets(const Config& config, nlohmann::ordered_json& measures) {
  RawLeaflets raw;
  std::vector<int> region;
  const RepairedSurface surface = repaired_of(config, region, raw.notes);
  spdlog::info("surface: {} triangles, {} parts, taken as {}{}, {} pairs of triangles intersect", surface.triangles.size(), surface.parts,
               to_string(surface.kind), kind_of(config) == SurfaceKind::automatic ? " (auto)" : "", surface.self_intersections);
  measures["surface.kind"] = to_string(surface.kind);
  measures["surface.triangles"] = surface.triangles.size();
  measures["surface.parts"] = surface.parts;
  measures["surface.self_intersections"] = surface.self_intersections;

  if (surface.kind == SurfaceKind::mid) {
    raw.points = surface.points, raw.triangles = surface.triangles, raw.region = region;
  } else {
    const SolidMidSurface mid = mid_surface_of_solid({surface.points, surface.triangles, region});
    raw.points = mid.points, raw.triangles = mid.triangles, raw.region = mid.label, raw.thickness = mid.thickness;
    measures["surface.thickness_median_mm"] = mid.thickness_median;
    add_notes(raw, mid.notes);
  }
  Weighted valve;
  for (const auto& t : raw.triangles) valve.add(triangle_area(raw.points, t), triangle_middle(raw.points, t));
  read_muscles(config, valve.mean(), raw);
  measures["surface.papillary_tips"] = raw.papillary_points.size();
  return raw;
}

SourceGeometry make_surface_source(const Config& config) {
  nlohmann::ordered_json measures = nlohmann::ordered_json::object();
  SourceGeometry source = make_patient_source(config, read_surface_leaflets(config, measures));
  source.measures.update(measures);
  return source;
}

}  // namespace mv
