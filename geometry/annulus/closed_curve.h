// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Closed space curves: cleaning of measured points, smoothing, and a smooth periodic curve by arc length (mm).

#include <string>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

/// What cleaning and smoothing did to a measured curve; everything a report needs to judge it.
struct CurveReport {
  int points_read = 0;
  int duplicates_removed = 0;  // points closer to their predecessor than 1e-6 of the curve's extent, the repeated end included
  int spikes_removed = 0;      // points where the curve turns by more than 120 degrees (out-and-back)
  int harmonics = 0;           // Fourier harmonics kept by smoothing; 0 = not smoothed
  double smoothing_rms = 0;    // mm, measured points against the smoothed curve
  double smoothing_max = 0;    // mm
  Vec3 smoothing_max_at = Vec3::Zero();  // measured point where
};

/// Removes duplicates and out-and-back spikes from an ordered closed curve; the order is kept, the last point is not repeated.
/// Throws InputError, which begins with `name`, when fewer than 8 points remain, a coordinate is not finite, or half of the
/// points (and of every n-th of dense ones) are spikes: not in order.
std::vector<Vec3> clean_closed_curve(const std::vector<Vec3>& points, CurveReport* report = nullptr, const std::string& name = "annulus curve");

/// Smooth closed curve x(u), u = arc length in [0, length). Interpolates `ordered` by a periodic Catmull-Rom spline that is
/// re-sampled uniformly by arc length: |dx/du| = 1 to about (sampling distance / radius of curvature)^2. u is taken modulo the
/// length.
class ClosedCurve {
 public:
  /// `ordered`: at least 8 distinct points, closed, last not repeated. Throws InputError.
  explicit ClosedCurve(const std::vector<Vec3>& ordered, int samples = 4096);

  double length() const { return length_; }
  Vec3 at(double u) const;
  Vec3 tangent(double u) const;                                  // dx/du, length about one
  std::vector<Vec3> resampled(int n, double u_start = 0) const;  // n points, equal arc length
  double closest(const Vec3& x) const;                           // u of the closest sample, refined
 private:
  std::vector<Vec3> samples_;
  double length_ = 0;
};

/// Periodic low-pass: Fourier series of the arc-length parametrised curve cut at `harmonics` (with a Lanczos factor, so that no
/// ringing appears at kinks). Fills the smoothing fields of `report`.
std::vector<Vec3> smooth_closed_curve(const std::vector<Vec3>& ordered, int harmonics, int samples = 720,
                                      CurveReport* report = nullptr);

}  // namespace mv
