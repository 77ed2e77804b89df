// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// From leaflet curves to the leaflets' mid-surface: annulus through the hinge points, B-spline surface through the curves.

#include "geometry/loft/hinge_annulus.h"
#include "geometry/loft/leaflet_curve.h"
#include "geometry/loft/spline_surface.h"
#include "geometry/surface/raw_leaflets.h"

namespace mv {

struct CurveSurfaceOptions {
  Smoothing smoothing;                // of the leaflets
  double knot_spacing = 4;            // mm between knots, both directions
  double point_spacing = 1;           // mm, curves are resampled to this before the fit
  double triangle_size = 0.8;         // mm, of the result
  bool with_thickness = true;         // measured thickness where the curves have it
  bool is_order_meant = true;         // curves are drawn from annulus to free edge (files), or in no order (images)
};

struct CurveSurfaceReport {
  int curves_anterior = 0, curves_posterior = 0, arches = 0;
  AnnulusReport annulus;
  FitReport fit;
  double deviation_mean = 0, deviation_95 = 0, deviation_max = 0;  // mm, curve points from the surface
  std::string deviation_max_at;                                    // name of the curve
  double area = 0, area_anterior = 0, area_posterior = 0;          // mm2, of the fitted surface
  double thickness_mean = 0;                                       // mm, 0 when not measured
  double commissure_height[2] = {0, 0};                            // mm, along the surface from annulus to free edge
};

/// `set` is cleaned, oriented and joined on the way (curve_checks.h). The result holds triangles counter-clockwise seen from the atrium, with region per triangle,
/// the annulus curve, papillary points (tips of clouds included), and the ventricle's direction. Throws InputError: curves of one leaflet only, fewer than 3
/// curves of a leaflet, leaflets whose hinge points interleave, a surface that folds.
RawLeaflets surface_from_curves(CurveSet set, const CurveSurfaceOptions& options, CurveSurfaceReport* report = nullptr);

}  // namespace mv
