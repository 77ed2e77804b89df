// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/generic_source.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "geometry/annulus/annulus_check.h"
#include "geometry/annulus/annulus_fit.h"
#include "geometry/annulus/closed_curve.h"
#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "geometry/core/log.h"
#include "geometry/generic/generic_valve.h"

namespace mv {
namespace {

constexpr double same_point = 1e-3;  // mm

GenericValveParameters parameters_of(const Config& config) {
  GenericValveParameters p;
  p.axis_major = config.number_in("generic.axis_major", "mm");
  p.axis_minor = config.number_in("generic.axis_minor", "mm");
  p.saddle_height = config.number_in("generic.saddle_height", "mm");
  p.strip_height = config.number_in("generic.strip_height", "mm");
  p.anterior_radius = config.number_in("generic.anterior_radius", "mm");
  p.anterior_height = config.number("generic.anterior_height");
  p.posterior_height = config.number("generic.posterior_height");
  p.posterior_scallops = static_cast<int>(config.integer("generic.posterior_scallops"));
  p.inward_slope = config.number("generic.inward_slope");
  p.notch_radius = config.number_in("generic.notch_radius", "mm");
  p.proportional = config.flag("generic.proportional");
  return p;
}

Vec3 tip_of(const Config& config, const char* key) {
  const auto& metres = config.numbers(key);
  return Vec3(metres[0], metres[1], metres[2]) / unit_factor("mm");
}

/// Tips of the configuration, moved from the valve's own frame (x = anterior x normal reversed, y anterior, z against the
/// normal).
Papillary tips_in_frame(const Config& config, const GenericValve& valve) {
  const Vec3 z = -valve.annulus.normal, y = valve.anterior_direction, x = y.cross(z);
  Papillary papillary;
  for (const char* name : {"anterolateral", "posteromedial"}) {
    const Vec3 local = valve.scale * tip_of(config, (std::string("generic.papillary_tips_") + name).c_str());
    papillary.tips.push_back(valve.annulus.origin + local.x() * x + local.y() * y + local.z() * z);
    papillary.names.emplace_back(name);
  }
  return papillary;
}

std::optional<Vec3> given_anterior_direction(const Config& config) {
  if (config.is_auto("generic.anterior_direction")) return std::nullopt;
  const auto& d = config.numbers("generic.anterior_direction");
  if (Vec3(d[0], d[1], d[2]).norm() == 0)
    throw ConfigError("key 'generic.anterior_direction' is the zero vector: expected a direction");
  return Vec3(d[0], d[1], d[2]);
}

GenericValve valve_on_real_annulus(const Config& config, const std::vector<Vec3>& papillary_points, double spacing, std::vector<std::string>& notes) {
  CurveReport curve_report;
  const auto file = config.path("generic.annulus");
  std::vector<Vec3> curve = clean_closed_curve(read_points_csv(file), &curve_report, file.string());
  const auto harmonics = static_cast<int>(config.integer("generic.smoothing_harmonics"));
  notes = check_annulus_curve(curve, file.string(), harmonics);
  if (curve_report.spikes_removed > 0) notes.push_back(fmt::format("{}: {} points where the annulus turns back by more than 120 degrees were left out", file.string(), curve_report.spikes_removed));
  if (!papillary_points.empty())
    for (const std::string& note : check_papillary_points(papillary_points, curve, config.path("generic.papillary").string())) notes.push_back(note);
  if (harmonics > 0) curve = smooth_closed_curve(curve, harmonics, 720, &curve_report);
  spdlog::info(
      "annulus: {} points read, {} duplicates and {} spikes removed, smoothing moved it by {:.2f} mm rms, {:.2f} mm at most",
      curve_report.points_read, curve_report.duplicates_removed, curve_report.spikes_removed, curve_report.smoothing_rms,
      curve_report.smoothing_max);
  const auto given = given_anterior_direction(config);
  if (!given && papillary_points.empty()) {
    throw ConfigError(
        "key 'generic.anterior_direction' is \"auto\": a real annulus without generic.papillary does not tell where the anterior "
        "leaflet "
        "lies; expected a vector such as [0, 1, 0] or a papillary CSV");
  }
  NormalHints hints;
  hints.papillary_points = papillary_points;
  try {
    const Annulus annulus = fit_annulus(curve, hints);
    const AnteriorDirection anterior = find_anterior_direction(annulus, papillary_points, given);
    spdlog::info("annulus: normal by {}, anterior leaflet by rule: {}", annulus.sign_rule, anterior.rule);
    return build_generic_valve(parameters_of(config), spacing, annulus, anterior.direction);
  } catch (const InputError& e) {
    throw InputError(file.string() + ": " + e.what());
  }
}

}  // namespace

SourceGeometry make_generic_source(const Config& config) {
  const double spacing = config.number_in("mesh.spacing", "mm");
  const bool is_real = !config.text("generic.annulus").empty();
  std::vector<Vec3> papillary_points;
  if (!config.text("generic.papillary").empty()) {
    const auto file = config.path("generic.papillary");
    papillary_points = read_points_csv(file);
    if (std::none_of(papillary_points.begin(), papillary_points.end(), [&](const Vec3& p) { return (p - papillary_points.front()).norm() > same_point; }))
      throw InputError(fmt::format("{}: {} papillary points, at one place; expected two distinct tips or more points of both muscles", file.string(), papillary_points.size()));
  }

  SourceGeometry source;
  const GenericValve valve =
      is_real ? valve_on_real_annulus(config, papillary_points, spacing, source.notes) : build_generic_valve(parameters_of(config), spacing);
  source.surface = valve.mid_surface;
  source.annulus_curve = valve.annulus.points;
  source.anterior_direction = valve.anterior_direction;
  source.scale = valve.scale;
  source.papillary = papillary_points.empty() ? tips_in_frame(config, valve)
                                              : group_papillary_points(papillary_points, valve.annulus, valve.anterior_direction);
  source.summary =
      fmt::format("{} points, {} triangles, edges {:.2f} to {:.2f} mm, smallest angle {:.0f} deg", valve.report.points,
                  valve.report.triangles, valve.report.edge_min, valve.report.edge_max, valve.report.angle_min);
  return source;
}

}  // namespace mv
