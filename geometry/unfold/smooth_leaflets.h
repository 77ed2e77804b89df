// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// The smooth valve over its flat pattern: spline, annulus and column lengths. Internal to mv_unfold.

#include "geometry/annulus/closed_curve.h"
#include "geometry/generic/pattern_mesh.h"
#include "geometry/unfold/strip_spline.h"

namespace mv {

/// Smooth periodic function from its values at equal steps of u.
class PeriodicTable {
 public:
  PeriodicTable() = default;
  PeriodicTable(double period, std::vector<double> values) : period_(period), values_(std::move(values)) {}
  double at(double u) const;  // Catmull-Rom
  const std::vector<double>& values() const { return values_; }

 private:
  double period_ = 1;
  std::vector<double> values_;
};

/// x(u, v) = S(u, t) + b(t) (A(u) - S(u, 0)), t = v / H(u), with S the spline, A the annulus by arc length, b a smooth step from 1 at t = 0 to 0 at t = 1/2, and
/// H(u) the length of the column u: v is the distance along the column (to the accuracy to which the spline's columns run at even speed).
class SmoothLeaflets {
 public:
  /// Fits the spline three times, each time with t moved so that columns run at even speed. u of samples and result is
  /// that of the annulus curve. `height`: first estimate of H.
  SmoothLeaflets(const ClosedCurve& annulus, std::vector<StripSample> samples, const PeriodicTable& height, double wavelength, double cell);

  double period() const { return annulus_.length(); }
  double height(double u) const { return height_.at(u); }
  Vec3 position(const Vec2& uv) const;
  Vec3 along_u(const Vec2& uv) const;
  Vec3 along_v(const Vec2& uv) const;
  Vec3 normal(const Vec2& uv) const;  // unit, along_u x along_v
  double thickness(const Vec2& uv) const;
  std::vector<Vec2> free_edge(double step) const;
  /// Largest absolute normal curvature along u and v, 1/mm.
  double curvature(const Vec2& uv) const;
  /// Largest relative difference between v and the distance along a column.
  double speed_error() const;

 private:
  Vec3 at(double u, double t) const;
  std::vector<double> column_lengths(double u, int pieces) const;  // cumulative, pieces + 1
  ClosedCurve annulus_;
  PeriodicTable height_;
  std::vector<StripSpline> spline_;  // one; it has no default
};

}  // namespace mv
