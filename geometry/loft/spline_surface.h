// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Tensor-product cubic B-spline surface S(u, v) over a ring, fitted to points by penalised least squares (papers/s1, appendix A: leaflets by
// B-spline surface fitting through curves; the penalty and the choice of its weight are ours).

#include <span>
#include <vector>

#include "geometry/core/case.h"
#include "geometry/loft/penalized_fit.h"
#include "geometry/loft/spline_basis.h"

namespace mv {

/// One point to be fitted, with its parameters.
struct SurfaceDatum {
  Vec3 x = Vec3::Zero();
  double u = 0, v = 0;   // mm around, share from annulus (0) to free edge (1)
  double weight = 1;
  bool is_v_fixed = false;  // on the annulus or the free edge: only u may be corrected
};

struct SurfaceDerivatives {
  Vec3 x, du, dv;
};

/// u in [0, period), v in [0, 1]. `height`: mm that v = 1 stands for in the penalty.
class SplineSurface {
 public:
  SplineSurface(int segments_u, int segments_v, double period, double height);

  /// Minimises sum w |S(u_i, v_i) - x_i|^2 + lambda integral (r^2 |S_uuu + S_u / r^2|^2 + |S_vv|^2) du dv, r = period / 2 pi. Without data the
  /// surface goes on as a ruled surface between ellipses, for which the penalty vanishes.
  FitReport fit(std::span<const SurfaceDatum> data, const Smoothing& smoothing);
  /// The same penalty on a scalar field over the surface, e.g. thickness. Returns its coefficients.
  Eigen::VectorXd fit_field(std::span<const SurfaceDatum> data, const Eigen::VectorXd& values, const Smoothing& smoothing) const;
  double field(const Eigen::VectorXd& coefficients, double u, double v) const;

  Vec3 at(double u, double v) const;
  SurfaceDerivatives derivatives(double u, double v) const;
  /// Unit; S_u x S_v.
  Vec3 normal(double u, double v) const;
  /// Moves (u, v) to the closest point on the surface near by (Gauss-Newton, v kept in [0, 1]); returns the distance, mm.
  double project(SurfaceDatum& datum) const;
  double period() const { return u_.length(); }

 private:
  Eigen::MatrixXd rows(std::span<const SurfaceDatum> data) const;
  Eigen::MatrixXd penalty() const;

  SplineBasis u_, v_;
  double height_;
  Eigen::MatrixXd coefficients_;  // size u * size v, 3
};

}  // namespace mv
