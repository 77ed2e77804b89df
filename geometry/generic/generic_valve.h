// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// The generic four-semicircle valve (papers/s0 section 2, DESIGN 4): the flat pattern wrapped on a cone below an elliptic or a
// measured annulus. Lengths mm. Frame of the elliptic one: annulus plane z = 0, atrium +z, anterior leaflet +y.

#include <optional>
#include <vector>

#include "geometry/annulus/closed_curve.h"
#include "geometry/core/case.h"
#include "geometry/generic/flat_pattern.h"
#include "geometry/generic/mid_surface.h"

namespace mv {

struct GenericValveParameters {
  double axis_major = 38;  // full axis of the ellipse along x (commissure to commissure)
  double axis_minor = 30;  // full axis along y (anterior to posterior)
  double saddle_height =
      0;  // peak to peak; anterior and posterior horns towards the atrium: z = saddle/2 cos(2 phi), phi from +y
  double strip_height = 6;
  double anterior_radius = 18;
  double anterior_height = 0.9;
  double posterior_height = 0.75;
  int posterior_scallops = 3;
  double inward_slope = 0.35;  // of the cone: travel towards the centre per unit of depth, mean over the annulus (apex at depth
                               // mean radius / slope)
  double notch_radius = 1;
  double thickness = 1;      // of the leaflets: edges are measured on their faces
  bool proportional = true;  // on a measured annulus: scale strip, radius and fillet by its perimeter over the ellipse's
};

/// Annulus ellipse with its saddle, `points` of equal arc length, counter-clockwise seen from the atrium (+z), starting at +y.
std::vector<Vec3> generic_annulus_points(const GenericValveParameters& parameters, int points = 720);

/// Perimeter of that curve (107.2 mm for the defaults).
double generic_perimeter(const GenericValveParameters& parameters);

/// Maps the flat pattern to space. Column u starts at the annulus point p(u) and follows
///   x(u, v) = p(u) + depth(v) n + travel(v) c(u),   c(u) the in-plane unit vector from p(u) to the centre, n the annulus normal,
/// on a straight line towards the apex of the cone, travel/depth = inward_slope R(u)/R_mean with R(u) the in-plane distance to
/// the centre and R_mean its mean, while travel <= 0.5 R(u), then on a circular arc that turns vertical at travel = 0.65 R(u),
/// then straight down. Every level of the cone is a smaller copy of the annulus, so a hollow anterior side is not sharpened. Arc
/// length along a column equals v exactly, arc length along the annulus equals u; elsewhere the cone shortens lengths along u.
/// Rays to the centre do not cross and at least a third of every radius stays free, so the wall neither meets itself nor closes
/// the orifice.
class ConeWrap {
 public:
  /// `annulus.points` ordered and smooth; anterior_direction in the plane (projected). u runs counter-clockwise seen from the
  /// atrium, [0, 2 anterior_radius] centred on the anterior direction. Throws InputError when the curve is not star-shaped about
  /// its centre.
  ConeWrap(const Annulus& annulus, const Vec3& anterior_direction, const FlatPattern& pattern, double inward_slope);

  Vec3 position(const Vec2& uv) const;
  Vec3 normal(const Vec2& uv) const;   // unit, towards the inner (atrial) side
  Vec3 along_u(const Vec2& uv) const;  // dx/du
  Vec3 along_v(const Vec2& uv) const;  // dx/dv, unit
  const Vec3& centre() const { return centre_; }
  double smallest_orifice_radius() const;  // mm, over the free edge, in the annulus plane

 private:
  struct Column {
    Vec3 start;
    Vec3 inward;
    double radius;
  };
  struct Profile {
    double depth, travel, cosine, sine;
  };  // sine = d travel/dv
  Column column(double u) const;
  Profile profile(double v, double radius) const;
  ClosedCurve curve_;
  double u_offset_ = 0;  // curve parameter of pattern u = 0
  Vec3 centre_, axis_;
  double slope_ = 0, mean_radius_ = 0;
  const FlatPattern pattern_;
};

/// How the mid-surface mesh came out.
struct SurfaceMeshReport {
  int points = 0, triangles = 0;
  double edge_min = 0, edge_mean = 0, edge_max = 0;  // mm, on the mid-surface
  double face_edge_max = 0;                          // mm, on the faces, half the thickness off it
  double angle_min = 0, angle_max = 0;               // degrees
};

struct GenericValve {
  Annulus annulus;  // curve as used (smoothed), with plane
  Vec3 anterior_direction;
  PatternParameters pattern;  // after scaling
  double scale = 1;           // perimeter / generic perimeter when proportional
  MidSurface mid_surface;
  SurfaceMeshReport report;
  double orifice_radius_min = 0;  // mm
};

/// Builds pattern, wrap and triangulated mid-surface with near-equilateral triangles with no edge longer than `spacing` (mm), on
/// the faces too (mean edge about 0.8 spacing; up to 1.25 spacing is let pass, the measured value is in the report). The
/// triangulation follows both commissure columns (u = 0 and u = 2 anterior_radius), so every triangle belongs to one leaflet and
/// none crosses the end of the pattern. `annulus` absent: the ellipse of the parameters, anterior +y. Throws ConfigError,
/// InputError, GateError (mesh quality not reached).
GenericValve build_generic_valve(const GenericValveParameters& parameters, double spacing);
GenericValve build_generic_valve(const GenericValveParameters& parameters, double spacing, const Annulus& annulus,
                                 const Vec3& anterior_direction);

}  // namespace mv
