// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/generic/generic_valve.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "geometry/annulus/annulus_fit.h"
#include "geometry/core/errors.h"
#include "geometry/generic/pattern_mesh.h"

namespace mv {

std::array<Vec2, 3> unfolded_triangle(const MidSurface& surface, int triangle) {
  std::array<Vec2, 3> corners;
  double largest = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    corners[k] = surface.unfolded[static_cast<std::size_t>(surface.triangles[static_cast<std::size_t>(triangle)][k])];
    largest = std::max(largest, corners[k].x());
  }
  if (surface.perimeter > 0)
    for (Vec2& c : corners)
      if (largest - c.x() > 0.5 * surface.perimeter) c.x() += surface.perimeter;
  return corners;
}

std::vector<Vec3> generic_annulus_points(const GenericValveParameters& p, int points) {
  if (!(p.axis_major > 0) || !(p.axis_minor > 0)) throw ConfigError("generic.axis_major and generic.axis_minor must be positive");
  if (!(p.saddle_height >= 0) || p.saddle_height > 0.5 * std::min(p.axis_major, p.axis_minor))
    throw ConfigError("generic.saddle_height must lie between 0 and half the shorter axis");
  constexpr int dense = 4096;
  std::vector<Vec3> curve;
  for (int i = 0; i < dense; ++i) {
    const double phi = 2 * std::numbers::pi * i / dense;  // from +y, counter-clockwise seen from +z
    curve.push_back(
        {-0.5 * p.axis_major * std::sin(phi), 0.5 * p.axis_minor * std::cos(phi), 0.5 * p.saddle_height * std::cos(2 * phi)});
  }
  return ClosedCurve(curve, dense).resampled(points);
}

double generic_perimeter(const GenericValveParameters& parameters) {
  return ClosedCurve(generic_annulus_points(parameters)).length();
}

GenericValve build_generic_valve(const GenericValveParameters& parameters, double spacing, const Annulus& annulus,
                                 const Vec3& anterior_direction) {
  GenericValve valve;
  valve.annulus = annulus;
  valve.anterior_direction = (anterior_direction - anterior_direction.dot(annulus.normal) * annulus.normal).normalized();
  const double perimeter = ClosedCurve(annulus.points).length();
  valve.scale = parameters.proportional ? perimeter / generic_perimeter(parameters) : 1.0;
  valve.pattern = {perimeter,
                   valve.scale * parameters.strip_height,
                   valve.scale * parameters.anterior_radius,
                   parameters.anterior_height,
                   parameters.posterior_height,
                   parameters.posterior_scallops,
                   valve.scale * parameters.notch_radius};
  const FlatPattern pattern(valve.pattern);
  const ConeWrap wrap(annulus, valve.anterior_direction, pattern, parameters.inward_slope);
  valve.mid_surface = mesh_pattern(pattern, wrap, spacing, parameters.thickness, &valve.report);
  valve.mid_surface.axis = annulus.normal;
  valve.orifice_radius_min = wrap.smallest_orifice_radius();
  return valve;
}

GenericValve build_generic_valve(const GenericValveParameters& parameters, double spacing) {
  NormalHints hints;
  hints.ventricle_direction = -Vec3::UnitZ();
  Annulus annulus = fit_annulus(generic_annulus_points(parameters), hints);
  return build_generic_valve(parameters, spacing, annulus, Vec3::UnitY());
}

}  // namespace mv
