// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/tube_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "geometry/annulus/annulus_check.h"
#include "geometry/annulus/closed_curve.h"
#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "geometry/core/log.h"
#include "geometry/core/motion_table.h"
#include "pipeline/case_directory.h"

namespace mv {
namespace {

constexpr double farthest = 40;      // mm, of any movement
constexpr double odd_duration = 20;  // of the run
constexpr double odd_stretch = 0.4;  // of the annulus' length; life's stays below a fifth
constexpr int fewest_for_shape = 8;  // points; of fewer a file of this valve tells no shape

double length_of(const std::vector<Vec3>& curve) {
  double length = 0;
  for (std::size_t i = 0; i < curve.size(); ++i) length += (curve[(i + 1) % curve.size()] - curve[i]).norm();
  return length;
}

/// Motions that end long after the run: times in milliseconds.
void warn_of_slowness(const MotionTable& motion, const Config& config, const std::string& file, std::vector<std::string>& warnings) {
  if (const double end = config.number("time.end"); motion.times().back() > odd_duration * end)
    warnings.push_back(fmt::format("{}: the motion ends at {:.4g} s, the run at {:.4g} s (time.end): are the times in seconds?", file, motion.times().back(), end));
}

void warn_of_stretch(const MotionTable& motion, const Annulus& annulus, const std::string& file, std::vector<std::string>& warnings) {
  const double rest = length_of(annulus.points);
  double worst = 0, when = 0;
  for (const double time : motion.times()) {
    std::vector<Vec3> moved = annulus.points;
    for (Vec3& p : moved) p += motion.displacement(motion.nearest(p), time);
    if (const double stretch = length_of(moved) / rest - 1; std::abs(stretch) > std::abs(worst)) worst = stretch, when = time;
  }
  if (std::abs(worst) > odd_stretch)
    warnings.push_back(fmt::format("{}: at {:.4g} s the annulus is {:.0f} % {} than at rest; in life it changes by 5 to 20 %", file, when, 100 * std::abs(worst), worst > 0 ? "longer" : "shorter"));
}

/// All places of a moving annulus belong into the tube, and the leaflets as far along it as they are taken.
void contain(const MotionTable& motion, const std::vector<MotionTable::Place>& places, const LeafletMesh& mesh, const Vec3& normal, TubeOptions& options) {
  double least = 0, most = 0;  // mm, along the normal
  for (const double time : motion.times()) {
    std::size_t k = 0;
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
      if (!mesh.on_annulus[i]) continue;
      const Vec3 u = motion.displacement(places[k++], time);
      options.contained.push_back(mesh.points[i] + u);
      least = std::min(least, u.dot(normal)), most = std::max(most, u.dot(normal));
    }
  }
  const auto [first, last] = std::minmax_element(mesh.points.begin(), mesh.points.end(), [&](const Vec3& a, const Vec3& b) { return a.dot(normal) < b.dot(normal); });
  options.contained.push_back(*first + least * normal);
  options.contained.push_back(*last + most * normal);
}

/// Throws InputError for a motion that no valve makes.
void check_motion(const MotionTable& motion, const Config& config, const std::string& file, std::vector<std::string>& warnings) {
  motion.check_course(file);
  if (motion.largest() > farthest)
    throw InputError(fmt::format("{}: a point moves by {:.0f} mm, more than {:.0f} mm; in life it is 5 to 20 mm: are the places in mm?", file, motion.largest(), farthest));
  warn_of_slowness(motion, config, file, warnings);
}

}  // namespace

Tube make_tube(const Config& config, const Annulus& annulus, const LeafletMesh& mesh, const Papillary& papillary,
               TubeReport* report) {
  TubeOptions options;
  std::vector<std::string> warnings;
  options.length_ventricle = config.number_in("tube.length_ventricle", "mm");
  options.length_atrium = config.number_in("tube.length_atrium", "mm");
  options.spacing = config.number_in("tube.spacing", "mm");
  options.margin_cells = static_cast<int>(config.integer("tube.margin_cells"));
  options.clearance = config.number_in("tube.clearance", "mm");
  options.harmonics = static_cast<int>(config.integer("tube.harmonics"));
  options.contained = mesh.points;
  if (config.flag("tube.contain_tips")) options.tips = papillary.tips;
  if (!config.text("annulus.motion").empty()) {
    const auto file = config.path("annulus.motion");
    const MotionTable motion = MotionTable::read(file);
    if (motion.points() >= fewest_for_shape)
      for (const std::string& note : check_annulus_curve(clean_closed_curve(motion.rest(), nullptr, file.string()), file.string(), 0)) warnings.push_back(note);
    const auto places = motion.places_of_annulus(mesh, file.string());
    check_motion(motion, config, file.string(), warnings);
    warn_of_stretch(motion, annulus, file.string(), warnings);
    if (config.flag("fluid.enabled")) contain(motion, places, mesh, annulus.normal.normalized(), options);
  }
  if (!config.text("papillary.motion").empty()) {
    const auto file = config.path("papillary.motion");
    const MotionTable motion = MotionTable::read(file);
    motion.check_tips(papillary.tips, file.string());
    check_motion(motion, config, file.string(), warnings);
  }
  Tube tube = build_tube(annulus, options, report);
  if (report) report->warnings = std::move(warnings);
  return tube;
}

std::string run_tube_stage(const StageContext& context) {
  TubeReport report;
  const Tube tube = make_tube(context.config, read_annulus(context.in("annulus.vtp")), read_leaflets(context.in("leaflets.vtu")),
                              read_papillary(context.in("papillary.vtp")), &report);
  for (const std::string& note : report.notes) spdlog::info("tube: {}", note);
  for (const std::string& warning : report.warnings) spdlog::warn("tube: {}", with_sources(warning, context.case_directory));
  write_tube(context.out("tube.vtu"), tube);
  const auto& n = tube.grid_cells;
  return fmt::format("{} fluid cells ({} x {} x {}) of {} mm, {} hexahedra, wall {:.2f} to {:.2f} mm from the annulus",
                     static_cast<long>(n[0]) * n[1] * n[2], n[0], n[1], n[2], tube.grid_spacing, tube.hexes.size(),
                     report.gap_min, report.gap_max);
}

}  // namespace mv
