// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Penalised least squares: minimise  sum_i w_i |y_i - (B c)_i|^2 + lambda c^T P c  with the weight lambda of the penalty chosen from the data.

#include <Eigen/Core>

namespace mv {

/// How lambda is chosen.
/// gcv: generalised cross-validation (Craven & Wahba 1979): the minimum of n RSS / (n - gamma tr H)^2. gamma = 1.4 (Kim & Gu 2004), which
///      protects against following noise that neighbouring points share.
/// discrepancy: Morozov's principle: the largest lambda with a root mean square residual of at most `noise`.
/// fixed: `lambda` as given.
enum class SmoothingRule { gcv, discrepancy, fixed };

struct Smoothing {
  SmoothingRule rule = SmoothingRule::gcv;
  double noise = 0;   // in units of y, for discrepancy
  double lambda = 0;  // for fixed
};

struct FitReport {
  double lambda = 0;
  double score = 0;               // GCV score at lambda, y^2
  double degrees_of_freedom = 0;  // tr H
  double rms = 0;                 // weighted root mean square residual per data row
  bool is_at_limit = false;       // lambda ended at the end of the range that is searched
};

/// B: rows = data, columns = coefficients; w: positive, one per row; Y: one column per component, all smoothed alike. lambda is searched
/// over 10^-7 .. 10^5 times tr(B^T W B) / tr(P).
/// Throws InputError when data and penalty together do not determine the coefficients.
Eigen::MatrixXd penalized_fit(const Eigen::MatrixXd& B, const Eigen::VectorXd& w, const Eigen::MatrixXd& Y, const Eigen::MatrixXd& P,
                              const Smoothing& smoothing, FitReport* report = nullptr);

}  // namespace mv
