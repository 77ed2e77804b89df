// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/loft/spline_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace mv {
namespace {

/// Kronecker product for coefficients numbered u * size_v + v.
Eigen::MatrixXd kronecker(const Eigen::MatrixXd& U, const Eigen::MatrixXd& V) {
  Eigen::MatrixXd K(U.rows() * V.rows(), U.cols() * V.cols());
  for (Eigen::Index i = 0; i < U.rows(); ++i)
    for (Eigen::Index j = 0; j < U.cols(); ++j) K.block(i * V.rows(), j * V.cols(), V.rows(), V.cols()) = U(i, j) * V;
  return K;
}

}  // namespace

SplineSurface::SplineSurface(int segments_u, int segments_v, double period, double height)
    : u_(segments_u, period, true), v_(segments_v, 1, false), height_(height),
      coefficients_(Eigen::MatrixXd::Zero(u_.size() * v_.size(), 3)) {}

Eigen::MatrixXd SplineSurface::rows(std::span<const SurfaceDatum> data) const {
  Eigen::MatrixXd B = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(data.size()), u_.size() * v_.size());
  for (std::size_t d = 0; d < data.size(); ++d) {
    const SplineValues a = u_.at(data[d].u), b = v_.at(data[d].v);
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < 4; ++j)
        B(static_cast<Eigen::Index>(d), a.index[i] * v_.size() + b.index[j]) += a.value[i] * b.value[j];
  }
  return B;
}

Eigen::MatrixXd SplineSurface::penalty() const {
  const double r = u_.length() / (2 * std::numbers::pi), h = height_;
  const Eigen::MatrixXd around = kronecker(u_.gram({0, 1 / r, 0, r}), h * v_.gram({1, 0, 0, 0}));
  const Eigen::MatrixXd along = kronecker(u_.gram({1, 0, 0, 0}), (1 / (h * h * h)) * v_.gram({0, 0, 1, 0}));
  return around + along;
}

FitReport SplineSurface::fit(std::span<const SurfaceDatum> data, const Smoothing& smoothing) {
  const auto n = static_cast<Eigen::Index>(data.size());
  Eigen::MatrixXd Y(n, 3);
  Eigen::VectorXd w(n);
  Vec3 mean = Vec3::Zero();
  for (const auto& d : data) mean += d.x / static_cast<double>(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    // About the mean: coordinates may lie far from the origin, and the basis holds the constants exactly.
    Y.row(i) = (data[static_cast<std::size_t>(i)].x - mean).transpose();
    w(i) = data[static_cast<std::size_t>(i)].weight;
  }
  FitReport report;
  coefficients_ = penalized_fit(rows(data), w, Y, penalty(), smoothing, &report);
  coefficients_.rowwise() += mean.transpose();
  return report;
}

Eigen::VectorXd SplineSurface::fit_field(std::span<const SurfaceDatum> data, const Eigen::VectorXd& values, const Smoothing& smoothing) const {
  Eigen::VectorXd w(values.size());
  for (Eigen::Index i = 0; i < w.size(); ++i) w(i) = data[static_cast<std::size_t>(i)].weight;
  return penalized_fit(rows(data), w, values, penalty(), smoothing);
}

double SplineSurface::field(const Eigen::VectorXd& coefficients, double u, double v) const {
  const SplineValues a = u_.at(u), b = v_.at(v);
  double sum = 0;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j) sum += a.value[i] * b.value[j] * coefficients(a.index[i] * v_.size() + b.index[j]);
  return sum;
}

Vec3 SplineSurface::at(double u, double v) const {
  const SplineValues a = u_.at(u), b = v_.at(v);
  Vec3 x = Vec3::Zero();
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j) x += a.value[i] * b.value[j] * coefficients_.row(a.index[i] * v_.size() + b.index[j]).transpose();
  return x;
}

SurfaceDerivatives SplineSurface::derivatives(double u, double v) const {
  const SplineValues a = u_.at(u), b = v_.at(v), da = u_.at(u, 1), db = v_.at(v, 1);
  SurfaceDerivatives s{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j) {
      const Vec3 c = coefficients_.row(a.index[i] * v_.size() + b.index[j]).transpose();
      s.x += a.value[i] * b.value[j] * c;
      s.du += da.value[i] * b.value[j] * c;
      s.dv += a.value[i] * db.value[j] * c;
    }
  return s;
}

Vec3 SplineSurface::normal(double u, double v) const {
  const SurfaceDerivatives s = derivatives(u, v);
  return s.du.cross(s.dv).normalized();
}

double SplineSurface::project(SurfaceDatum& datum) const {
  const double step_u = 2 * u_.length() / u_.segments(), step_v = 0.25;
  double u = datum.u, v = datum.v, distance = (at(u, v) - datum.x).norm();
  for (int k = 0; k < 12; ++k) {
    const SurfaceDerivatives s = derivatives(u, v);
    const Vec3 r = datum.x - s.x;
    double a = s.du.squaredNorm(), b = s.du.dot(s.dv), c = s.dv.squaredNorm();
    const double f = s.du.dot(r), g = s.dv.dot(r);
    const double det = a * c - b * b;
    // On the border the step along it; so does a step that would leave the domain.
    bool along_u = datum.is_v_fixed || !(det > 1e-12 * a * c);
    double du = 0, dv = 0;
    if (!along_u) {
      du = (c * f - b * g) / det;
      dv = (a * g - b * f) / det;
      along_u = (v <= 0 && dv < 0) || (v >= 1 && dv > 0);
    }
    if (along_u) du = f / std::max(a, 1e-12), dv = 0;
    du = std::clamp(du, -step_u, step_u);
    dv = std::clamp(dv, -step_v, step_v);
    double share = 1;
    bool is_better = false;
    for (int half = 0; half < 6 && !is_better; ++half, share *= 0.5) {
      const double u_new = u + share * du, v_new = std::clamp(v + share * dv, 0.0, 1.0);
      const double d = (at(u_new, v_new) - datum.x).norm();
      if (d < distance - 1e-9) u = u_new, v = v_new, distance = d, is_better = true;
    }
    if (!is_better) break;
  }
  datum.u = u - std::floor(u / u_.length()) * u_.length();
  datum.v = v;
  return distance;
}

}  // namespace mv
