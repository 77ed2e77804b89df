// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/loft/hinge_annulus.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/core/errors.h"

namespace mv {
namespace {

using std::numbers::pi;
constexpr std::size_t fewest_points = 6;
constexpr double largest_gap_allowed = 150;  // degrees; beyond, half of the ring would be guessed
constexpr double slenderest = 4;             // ratio of the axes of anything that is still an annulus
constexpr int samples = 720;

struct Conic {
  Vec2 center;
  double a, b, tilt;
};

/// Direct least squares ellipse; nullopt-like a = 0 when the points do not determine one.
Conic direct_ellipse(const std::vector<Vec2>& points) {
  const auto n = static_cast<Eigen::Index>(points.size());
  Eigen::MatrixXd D1(n, 3), D2(n, 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double x = points[static_cast<std::size_t>(i)].x(), y = points[static_cast<std::size_t>(i)].y();
    D1.row(i) << x * x, x * y, y * y;
    D2.row(i) << x, y, 1;
  }
  const Mat3 S1 = D1.transpose() * D1, S2 = D1.transpose() * D2, S3 = D2.transpose() * D2;
  const Eigen::FullPivLU<Mat3> lu(S3);
  if (!lu.isInvertible()) return {Vec2::Zero(), 0, 0, 0};
  const Mat3 T = -lu.solve(S2.transpose());
  const Mat3 M = S1 + S2 * T;
  Mat3 C;
  C << 0, 0, 0.5, 0, -1, 0, 0.5, 0, 0;
  const Eigen::EigenSolver<Mat3> eigen(C * M);
  for (int k = 0; k < 3; ++k) {
    const Vec3 v = eigen.eigenvectors().col(k).real();
    if (4 * v(0) * v(2) - v(1) * v(1) <= 0) continue;
    const Vec3 w = T * v;
    Eigen::Matrix2d Q;
    Q << v(0), v(1) / 2, v(1) / 2, v(2);
    const Vec2 center = -0.5 * Q.inverse() * Vec2(w(0), w(1));
    const double level = center.dot(Q * center) - w(2);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(Q / level);
    if (!(axes.eigenvalues().minCoeff() > 0)) continue;
    const Vec2 along = axes.eigenvectors().col(0);
    return {center, 1 / std::sqrt(axes.eigenvalues()(0)), 1 / std::sqrt(axes.eigenvalues()(1)), std::atan2(along.y(), along.x())};
  }
  return {Vec2::Zero(), 0, 0, 0};
}

double wrapped(double angle) {
  angle = std::fmod(angle, 2 * pi);
  return angle < 0 ? angle + 2 * pi : angle;
}

}  // namespace

double EllipseFrame::angle(const Vec3& x) const {
  const Vec3 d = x - origin;
  return wrapped(std::atan2(d.dot(e2) / b, d.dot(e1) / a));
}

Vec3 EllipseFrame::at(double angle) const { return origin + e1 * a * std::cos(angle) + e2 * b * std::sin(angle); }

EllipseFrame fit_ellipse(const std::vector<Vec3>& points) {
  if (points.size() < fewest_points)
    throw InputError(fmt::format("annulus: {} hinge points, at least {} are needed; give more curves or slices, or the annulus itself",
                                 points.size(), fewest_points));
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) mean += p / static_cast<double>(points.size());
  Mat3 covariance = Mat3::Zero();
  for (const Vec3& p : points) covariance += (p - mean) * (p - mean).transpose() / static_cast<double>(points.size());
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(covariance);
  if (eigen.eigenvalues()(1) < 1e-3 * eigen.eigenvalues()(2))
    throw InputError("annulus: the hinge points lie on a line, as those of a single slice do; expected points around the whole ring");
  EllipseFrame frame;
  frame.normal = eigen.eigenvectors().col(0);
  frame.e1 = eigen.eigenvectors().col(2);
  frame.e2 = frame.normal.cross(frame.e1);
  // Unit size about the mean: the direct fit is not scale-free in floating point.
  const double size = std::sqrt(eigen.eigenvalues()(2));
  std::vector<Vec2> flat;
  Vec2 low = Vec2::Constant(HUGE_VAL), high = -low;
  for (const Vec3& p : points) {
    flat.emplace_back((p - mean).dot(frame.e1) / size, (p - mean).dot(frame.e2) / size);
    low = low.cwiseMin(flat.back());
    high = high.cwiseMax(flat.back());
  }
  Conic conic = direct_ellipse(flat);
  const Vec2 half = 0.5 * (high - low);
  const bool is_sane = conic.a > 0 && conic.a < slenderest * conic.b && conic.b < slenderest * conic.a &&
                       std::max(conic.a, conic.b) < 2 * half.maxCoeff() && (conic.center - 0.5 * (low + high)).norm() < half.maxCoeff();
  if (!is_sane) {
    frame.is_fitted = false;
    conic = {0.5 * (low + high), half.x(), half.y(), 0};
  }
  frame.origin = mean + size * (conic.center.x() * frame.e1 + conic.center.y() * frame.e2);
  const Vec3 e1 = std::cos(conic.tilt) * frame.e1 + std::sin(conic.tilt) * frame.e2;
  frame.e1 = e1.normalized();
  frame.e2 = frame.normal.cross(frame.e1);
  frame.a = conic.a * size;
  frame.b = conic.b * size;
  return frame;
}

HingeAnnulus::HingeAnnulus(const std::vector<Vec3>& points, const AnnulusOptions& options)
    : frame_(fit_ellipse(points)), basis_(options.segments, 2 * pi, true) {
  std::vector<double> angles;
  for (const Vec3& p : points) angles.push_back(frame_.angle(p));
  std::sort(angles.begin(), angles.end());
  double gap = 0, gap_start = 0;
  for (std::size_t i = 0; i < angles.size(); ++i) {
    const double step = i + 1 < angles.size() ? angles[i + 1] - angles[i] : angles[0] + 2 * pi - angles[i];
    if (step > gap) gap = step, gap_start = angles[i];
  }
  report_.largest_gap_degrees = gap * 180 / pi;
  if (report_.largest_gap_degrees > largest_gap_allowed)
    throw InputError(fmt::format("annulus: no hinge point over {:.0f} degrees of the ring (at most {:.0f} can be bridged); curves of one "
                                 "leaflet only, or of one side only? Give curves all around, or the annulus itself",
                                 report_.largest_gap_degrees, largest_gap_allowed));
  std::vector<Vec3> data = points;
  fit(data, options);
  // Where the curve passes a slice that shows no leaflet, it is drawn back onto it.
  const Vec3 m = options.limit_normal;
  if (m.norm() > 0 && !options.limits.empty()) {
    double low = HUGE_VAL, high = -HUGE_VAL, limit_low = -HUGE_VAL, limit_high = HUGE_VAL;
    for (const Vec3& p : points) low = std::min(low, m.dot(p)), high = std::max(high, m.dot(p));
    for (const Vec3& p : options.limits) {
      const double z = m.dot(p);
      if (z <= low) limit_low = std::max(limit_low, z);
      if (z >= high) limit_high = std::min(limit_high, z);
    }
    for (int k = 0; k < 5; ++k) {
      std::vector<Vec3> pulled;
      for (const Vec3& p : this->points(samples / 8)) {
        const double beyond = std::max(0.0, m.dot(p) - limit_high) - std::max(0.0, limit_low - m.dot(p));
        if (std::abs(beyond) > 0.05) pulled.push_back(p - beyond * m);
        report_.pulled_back = std::max(report_.pulled_back, std::abs(beyond));
      }
      if (pulled.empty()) break;
      data.insert(data.end(), pulled.begin(), pulled.end());
      fit(data, options);
    }
  }
  measure(points);
  for (int i = 0; i < samples; ++i)
    report_.largest_gap_mm += (at(gap_start + gap * (i + 1) / samples) - at(gap_start + gap * i / samples)).norm();
}

void HingeAnnulus::fit(const std::vector<Vec3>& points, const AnnulusOptions& options) {
  const auto n = static_cast<Eigen::Index>(points.size());
  Eigen::MatrixXd B = Eigen::MatrixXd::Zero(n, basis_.size()), Y(n, 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Vec3& p = points[static_cast<std::size_t>(i)];
    const SplineValues values = basis_.at(frame_.angle(p));
    for (std::size_t k = 0; k < 4; ++k) B(i, values.index[k]) += values.value[k];
    // The deviation from the ellipse is small, so rounding in the nearly unpenalised directions does not matter.
    Y.row(i) = (p - frame_.at(frame_.angle(p))).transpose();
  }
  coefficients_ = penalized_fit(B, Eigen::VectorXd::Ones(n), Y, basis_.gram({0, 1, 0, 1}), options.smoothing, &report_.fit);
}

void HingeAnnulus::measure(const std::vector<Vec3>& points) {
  report_.residual_mean = report_.residual_max = 0;
  for (const Vec3& p : points) {
    const double d = distance(p);
    report_.residual_mean += d / static_cast<double>(points.size());
    report_.residual_max = std::max(report_.residual_max, d);
  }
}

Vec3 HingeAnnulus::at(double angle) const {
  const SplineValues values = basis_.at(wrapped(angle));
  Vec3 x = frame_.at(angle);
  for (std::size_t k = 0; k < 4; ++k) x += values.value[k] * coefficients_.row(values.index[k]).transpose();
  return x;
}

std::vector<Vec3> HingeAnnulus::points(int n) const {
  std::vector<Vec3> result;
  for (int i = 0; i < n; ++i) result.push_back(at(2 * pi * i / n));
  return result;
}

double HingeAnnulus::distance(const Vec3& x, double* angle) const {
  double best = 0, best_distance = HUGE_VAL;
  for (int i = 0; i < samples; ++i) {
    const double d = (at(2 * pi * i / samples) - x).norm();
    if (d < best_distance) best_distance = d, best = 2 * pi * i / samples;
  }
  double low = best - 2 * pi / samples, high = best + 2 * pi / samples;
  for (int k = 0; k < 40; ++k) {
    const double left = low + 0.382 * (high - low), right = low + 0.618 * (high - low);
    if ((at(left) - x).norm() < (at(right) - x).norm()) high = right;
    else low = left;
  }
  best = 0.5 * (low + high);
  if (angle) *angle = wrapped(best);
  return std::min(best_distance, (at(best) - x).norm());
}

double HingeAnnulus::length() const {
  double sum = 0;
  for (int i = 0; i < samples; ++i) sum += (at(2 * pi * (i + 1) / samples) - at(2 * pi * i / samples)).norm();
  return sum;
}

}  // namespace mv
