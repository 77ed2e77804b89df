// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Annulus from hinge points: a closed smooth curve through points that are known only here and there around the ring.

#include <vector>

#include "geometry/core/case.h"
#include "geometry/loft/penalized_fit.h"
#include "geometry/loft/spline_basis.h"

namespace mv {

/// Ellipse in space: the frame in which "around the annulus" is an angle.
struct EllipseFrame {
  Vec3 origin = Vec3::Zero();
  Vec3 e1 = Vec3::UnitX(), e2 = Vec3::UnitY(), normal = Vec3::UnitZ();  // right-handed; e1 along the long axis
  double a = 1, b = 1;                                                   // mm, half axes
  bool is_fitted = true;  // false: half extents of the points, because they did not determine an ellipse

  /// Eccentric angle in [0, 2 pi): atan2(y/b, x/a).
  double angle(const Vec3& x) const;
  Vec3 at(double angle) const;
};

/// Plane by principal components, ellipse in it by direct least squares (Fitzgibbon 1999, in the stable form of Halir & Flusser 1998).
/// Throws InputError for fewer than 6 points, or points on a line.
EllipseFrame fit_ellipse(const std::vector<Vec3>& points);

struct AnnulusOptions {
  Smoothing smoothing;      // of the deviation from the ellipse
  int segments = 24;        // of the spline
  std::vector<Vec3> limits; // points on parallel planes that the annulus does not pass, e.g. slices without leaflet
  Vec3 limit_normal = Vec3::Zero();  // normal of these planes; zero: no limits
};

struct AnnulusReport {
  FitReport fit;
  double residual_mean = 0, residual_max = 0;  // mm, hinge points from the curve
  double largest_gap_degrees = 0;              // largest angle without hinge point
  double largest_gap_mm = 0;                   // length of the curve over that gap
  double pulled_back = 0;                      // mm, by which the limits moved the curve at most
};

/// Closed curve A(theta), theta the eccentric angle: periodic cubic spline that minimises
///   sum |A(theta_i) - x_i|^2 + lambda integral |A''' + A'|^2 dtheta.
/// The penalty vanishes for every ellipse, tilted or not, with or without a sinusoidal height: where hinge points are missing the curve goes on
/// as the ellipse that fits the rest, not as a chord.
class HingeAnnulus {
 public:
  /// Throws InputError for fewer than 6 points, or a gap of more than 150 degrees without any.
  HingeAnnulus(const std::vector<Vec3>& points, const AnnulusOptions& options = {});

  const EllipseFrame& frame() const { return frame_; }
  const AnnulusReport& report() const { return report_; }
  Vec3 at(double angle) const;
  /// `n` points at equal steps of the angle.
  std::vector<Vec3> points(int n) const;
  /// Distance of x from the curve, mm; `angle` receives where.
  double distance(const Vec3& x, double* angle = nullptr) const;
  double length() const;

 private:
  void fit(const std::vector<Vec3>& points, const AnnulusOptions& options);
  void measure(const std::vector<Vec3>& points);

  EllipseFrame frame_;
  SplineBasis basis_;
  Eigen::MatrixXd coefficients_;
  AnnulusReport report_;
};

}  // namespace mv
