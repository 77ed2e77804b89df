// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/loft/penalized_fit.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <algorithm>

#include "geometry/core/errors.h"

namespace mv {
namespace {

constexpr double gcv_gamma = 1.4;
constexpr double lowest = -7, highest = 5;  // decades of the search
constexpr int coarse_steps = 24;

/// Normal equations for any lambda.
class Fit {
 public:
  Fit(const Eigen::MatrixXd& B, const Eigen::VectorXd& w, const Eigen::MatrixXd& Y, const Eigen::MatrixXd& P)
      : B_(B), w_(w), Y_(Y), A_(B.transpose() * w.asDiagonal() * B), b_(B.transpose() * w.asDiagonal() * Y), P_(P) {
    scale_ = A_.trace() / std::max(P_.trace(), 1e-300);
    // A trace of the penalty keeps the matrix regular where there are no data; far below the search range.
    A_ += 1e-12 * scale_ * P_;
  }

  double scale() const { return scale_; }

  Eigen::MatrixXd solve(double lambda, FitReport& report, bool with_trace) const {
    const Eigen::LLT<Eigen::MatrixXd> factor(A_ + lambda * P_);
    if (factor.info() != Eigen::Success) throw InputError("spline fit: the points do not determine a surface; expected more curves or points");
    Eigen::MatrixXd c = factor.solve(b_);
    const Eigen::MatrixXd r = Y_ - B_ * c;
    const double rss = (w_.asDiagonal() * r.cwiseAbs2()).sum();
    const double n = static_cast<double>(B_.rows());
    report.lambda = lambda;
    report.rms = std::sqrt(rss / w_.sum());
    if (with_trace) {
      report.degrees_of_freedom = factor.solve(A_).trace();
      const double left = n - gcv_gamma * report.degrees_of_freedom;
      report.score = left > 0 ? n * (rss / w_.mean()) / (left * left) : HUGE_VAL;
    }
    return c;
  }

 private:
  const Eigen::MatrixXd& B_;
  const Eigen::VectorXd& w_;
  const Eigen::MatrixXd& Y_;
  Eigen::MatrixXd A_, b_;
  const Eigen::MatrixXd& P_;
  double scale_ = 1;
};

double gcv_decade(const Fit& fit) {
  const auto score = [&](double decade) {
    FitReport report;
    fit.solve(fit.scale() * std::pow(10.0, decade), report, true);
    return report.score;
  };
  double best = highest, best_score = HUGE_VAL;
  // From smooth to rough, so that ties (all scores near zero for exact data) fall to the smoother side only when truly equal.
  for (int k = coarse_steps; k >= 0; --k) {
    const double decade = lowest + (highest - lowest) * k / coarse_steps;
    const double s = score(decade);
    if (s < best_score) best_score = s, best = decade;
  }
  double a = best - (highest - lowest) / coarse_steps, b = best + (highest - lowest) / coarse_steps;
  for (int k = 0; k < 6; ++k) {
    const double left = a + 0.382 * (b - a), right = a + 0.618 * (b - a);
    if (score(left) < score(right)) b = right;
    else a = left;
  }
  return std::clamp(0.5 * (a + b), lowest, highest);
}

double discrepancy_decade(const Fit& fit, double noise) {
  double a = lowest, b = highest;
  for (int k = 0; k < 30; ++k) {
    const double middle = 0.5 * (a + b);
    FitReport report;
    fit.solve(fit.scale() * std::pow(10.0, middle), report, false);
    if (report.rms > noise) b = middle;
    else a = middle;
  }
  return a;
}

}  // namespace

Eigen::MatrixXd penalized_fit(const Eigen::MatrixXd& B, const Eigen::VectorXd& w, const Eigen::MatrixXd& Y, const Eigen::MatrixXd& P,
                              const Smoothing& smoothing, FitReport* report) {
  if (!Y.allFinite() || !B.allFinite()) throw InputError("spline fit: a point is not finite");
  const Fit fit(B, w, Y, P);
  double lambda = smoothing.lambda;
  bool is_at_limit = false;
  if (smoothing.rule != SmoothingRule::fixed) {
    const double decade = smoothing.rule == SmoothingRule::gcv ? gcv_decade(fit) : discrepancy_decade(fit, smoothing.noise);
    is_at_limit = decade < lowest + 0.05 || decade > highest - 0.05;
    lambda = fit.scale() * std::pow(10.0, decade);
  }
  FitReport local;
  Eigen::MatrixXd c = fit.solve(lambda, local, true);
  local.is_at_limit = is_at_limit;
  if (report) *report = local;
  return c;
}

}  // namespace mv
