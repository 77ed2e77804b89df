// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Smooth surface over the strip: cubic tensor B-spline, periodic in u, fitted to scattered samples with a bending energy (papers/s1
// fits leaflets by B-splines too; the criterion for the smoothing is a wavelength). Internal to mv_unfold.

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

using Vec4 = Eigen::Vector4d;  // position (mm) and thickness (mm)

struct StripSample {
  double u, t;    // any u; t in [0, 1]
  Vec4 value;
  double weight;  // mm2 of surface that it stands for
};

class StripSpline {
 public:
  /// Minimises sum w |S - x|^2 + lambda * integral (|S_uu|^2 + 2 |S_ut|^2 / h^2 + |S_tt|^2 / h^4) h du dt, with h(u) the length of the column u (mm)
  /// and lambda = (wavelength / 2 pi)^4: waves of that length are halved, those of twice that length keep 94 %.
  StripSpline(double period, int cells_u, int cells_t, const std::vector<StripSample>& samples, const std::function<double(double)>& height,
              double wavelength);

  Vec4 value(double u, double t) const { return evaluate(u, t, 0, 0); }
  Vec4 along_u(double u, double t) const { return evaluate(u, t, 1, 0); }
  Vec4 along_t(double u, double t) const { return evaluate(u, t, 0, 1); }

 private:
  Vec4 evaluate(double u, double t, int du, int dt) const;
  double period_;
  int cells_u_, cells_t_;
  std::vector<Vec4> coefficients_;  // [u][t], cells_t + 3 across
};

}  // namespace mv
