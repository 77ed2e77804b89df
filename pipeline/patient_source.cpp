// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/patient_source.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "geometry/annulus/annulus_check.h"
#include "geometry/core/errors.h"
#include "geometry/core/log.h"
#include "geometry/generic/generic_valve.h"

namespace mv {
namespace {

constexpr double nearest_commissures = 5;  // mm
constexpr double flat_leaflets = 4;        // mm

Vec3 vector_of(const Config& config, const char* key, double unit) {
  const auto& values = config.numbers(key);
  return Vec3(values[0], values[1], values[2]) / unit;
}

/// Generic tips in the frame x = along the commissures, y anterior, z towards the atrium.
Papillary generic_tips(const Config& config, const LeafletSurface& leaflets) {
  const double scale = leaflets.surface.perimeter / generic_perimeter(GenericValveParameters{});
  const Vec3 z = -leaflets.annulus.normal, y = leaflets.anterior_direction, x = y.cross(z);
  Papillary papillary;
  for (const char* name : {"anterolateral", "posteromedial"}) {
    const Vec3 tip = scale * vector_of(config, (std::string("generic.papillary_tips_") + name).c_str(), unit_factor("mm"));
    papillary.tips.push_back(leaflets.annulus.origin + tip.x() * x + tip.y() * y + tip.z() * z);
    papillary.names.emplace_back(name);
  }
  return papillary;
}

nlohmann::ordered_json to_json(const LeafletSurfaceReport& r) {
  nlohmann::ordered_json json;
  json["annulus.moved_rms_mm"] = r.annulus_moved_rms;
  json["annulus.moved_max_mm"] = r.annulus_moved_max;
  json["leaflets.moved_mean_mm"] = r.surface_moved_mean;
  json["leaflets.moved_max_mm"] = r.surface_moved_max;
  json["leaflets.anterior_area_mm2"] = r.area_anterior;
  json["leaflets.posterior_area_mm2"] = r.area_posterior;
  json["leaflets.free_edge_length_mm"] = r.free_edge_length;
  json["leaflets.edge_min_mm"] = r.edge_min;
  json["leaflets.edge_mean_mm"] = r.edge_mean;
  json["leaflets.edge_max_mm"] = r.edge_max;
  json["leaflets.angle_min_deg"] = r.angle_min;
  json["leaflets.angle_max_deg"] = r.angle_max;
  json["pattern.area_distortion_max"] = r.area_distortion_max;
  json["rule.annulus"] = r.annulus_rule;
  json["rule.atrial_side"] = r.normal_rule;
  json["rule.leaflets"] = r.region_rule;
  return json;
}

}  // namespace

LeafletSurfaceOptions leaflet_surface_options(const Config& config) {
  LeafletSurfaceOptions options;
  options.layers = static_cast<int>(config.integer("mesh.layers"));
  options.dihedral_min = config.number_in("gates.min_dihedral", "deg");
  options.spacing = config.number_in("mesh.spacing", "mm");
  options.thickness = config.number_in("mesh.thickness", "mm");
  options.thickness_min = config.number_in("patient.thickness_min", "mm");
  options.thickness_max = config.number_in("patient.thickness_max", "mm");
  options.annulus_harmonics = static_cast<int>(config.integer("patient.annulus_harmonics"));
  options.smoothing = config.number_in("patient.smoothing", "mm");
  options.commissure_gap = config.number_in("patient.commissure_gap", "mm");
  if (options.thickness_min > options.thickness_max)
    throw ConfigError(fmt::format("key 'patient.thickness_min' = {} mm is larger than patient.thickness_max = {} mm",
                                  options.thickness_min, options.thickness_max));
  return options;
}

void apply_patient_keys(const Config& config, RawLeaflets& raw) {
  const auto points_of = [&](const char* key, std::vector<Vec3>& target) {
    if (config.text(key).empty()) return false;
    raw.notes.push_back(fmt::format("{} {}", key, target.empty() ? "is used" : "replaces what the source found"));
    target = read_points_csv(config.path(key));
    return true;
  };
  if (points_of("patient.annulus", raw.annulus_curve)) {
    const std::string file = config.path("patient.annulus").string();
    for (const std::string& note : check_annulus_curve(clean_closed_curve(raw.annulus_curve, nullptr, file), file)) raw.notes.push_back(note);
  }
  if (points_of("patient.papillary", raw.papillary_points)) raw.papillary_names.clear();
  if (points_of("patient.commissures", raw.commissures) && raw.commissures.size() != 2)
    throw InputError(fmt::format("{}: {} points, expected the two commissures", config.path("patient.commissures").string(),
                                 raw.commissures.size()));
  if (!config.text("patient.commissures").empty() && (raw.commissures[0] - raw.commissures[1]).norm() < nearest_commissures)
    throw InputError(fmt::format("{}: the two commissures lie {:.2f} mm apart; expected 15 to 50 mm: one of them twice, or another unit?", config.path("patient.commissures").string(),
                                 (raw.commissures[0] - raw.commissures[1]).norm()));
  if (!config.is_auto("patient.anterior_point")) raw.anterior_hint = vector_of(config, "patient.anterior_point", unit_factor("mm"));
  if (!config.is_auto("patient.ventricle_direction")) {
    raw.ventricle_direction = vector_of(config, "patient.ventricle_direction", 1);
    if (!(raw.ventricle_direction->norm() > 0))
      throw ConfigError("key 'patient.ventricle_direction' is the zero vector: expected a direction");
  }
}

SourceGeometry to_source_geometry(const LeafletSurface& leaflets, const Config& config) {
  SourceGeometry source;
  source.surface = leaflets.surface;
  source.annulus_curve = leaflets.annulus.points;
  source.anterior_direction = leaflets.anterior_direction;
  source.scale = leaflets.surface.perimeter / generic_perimeter(GenericValveParameters{});
  source.papillary = leaflets.papillary;
  if (source.papillary.tips.empty()) {
    source.notes.push_back("the data hold no papillary tips: generic ones are placed below the annulus (patient.papillary gives real ones)");
    source.papillary = generic_tips(config, leaflets);
  }
  double lowest = 1e300, highest = -1e300;  // mm along the normal
  for (const Vec3& p : leaflets.surface.points) {
    const double depth = (p - leaflets.annulus.origin).dot(leaflets.annulus.normal);
    lowest = std::min(lowest, depth), highest = std::max(highest, depth);
  }
  if (highest - lowest < flat_leaflets)
    source.notes.push_back(fmt::format("the leaflets lie within {:.1f} mm of each other along the annulus' normal: flat, or seen from one side only; expected 10 to 30 mm", highest - lowest));
  const LeafletSurfaceReport& r = leaflets.report;
  source.notes.insert(source.notes.begin(), r.notes.begin(), r.notes.end());
  source.measures = to_json(r);
  source.summary = fmt::format(
      "{} points, {} triangles, edges {:.2f} to {:.2f} mm, {:.2f} mm mean from the raw surface, anterior {:.0f} mm2, posterior {:.0f} mm2",
      leaflets.surface.points.size(), leaflets.surface.triangles.size(), r.edge_min, r.edge_max, r.surface_moved_mean,
      r.area_anterior, r.area_posterior);
  return source;
}

SourceGeometry make_patient_source(const Config& config, RawLeaflets raw) {
  apply_patient_keys(config, raw);
  LeafletSurface leaflets = build_leaflet_surface(raw, leaflet_surface_options(config));
  const std::string name = config.text("patient.papillary").empty() ? "papillary points" : config.path("patient.papillary").string();
  if (!raw.papillary_points.empty())
    for (const std::string& note : check_papillary_points(raw.papillary_points, leaflets.annulus.points, name)) leaflets.report.notes.push_back(note);
  for (const std::string& note : check_annulus_curve(leaflets.annulus.points, "annulus of the leaflets", 0)) leaflets.report.notes.push_back(note);
  const LeafletSurfaceReport& r = leaflets.report;
  spdlog::info("leaflets: annulus by {}, atrial side by {}, leaflets by {}", r.annulus_rule, r.normal_rule, r.region_rule);
  spdlog::info("leaflets: smoothing moved the annulus by {:.2f} mm rms, {:.2f} mm at most, the surface by {:.2f} mm mean, {:.2f} mm at most",
               r.annulus_moved_rms, r.annulus_moved_max, r.surface_moved_mean, r.surface_moved_max);
  return to_source_geometry(leaflets, config);
}

}  // namespace mv
