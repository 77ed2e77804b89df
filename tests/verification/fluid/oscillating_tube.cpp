// SPDX-License-Identifier: BSD-3-Clause
#include "verification/fluid/oscillating_tube.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

namespace mv::test {
namespace {

using Complex = std::complex<double>;

/// Values and derivatives of T_0, T_2, ... up to `degree` at s.
struct EvenChebyshev {
  std::vector<double> value, slope;
  EvenChebyshev(int degree, double s) {
    double t0 = 1, t1 = s, d0 = 0, d1 = 1;
    for (int n = 0; n <= degree; ++n) {
      if (n % 2 == 0) {
        value.push_back(t0);
        slope.push_back(d0);
      }
      const double t2 = 2 * s * t1 - t0, d2 = 2 * t1 + 2 * s * d1 - d0;
      t0 = t1, t1 = t2, d0 = d1, d1 = d2;
    }
  }
};

/// Gauss-Legendre points and weights on [0, 1] (Golub & Welsch 1969).
void gauss_points(int n, Eigen::VectorXd& points, Eigen::VectorXd& weights) {
  Eigen::MatrixXd jacobi = Eigen::MatrixXd::Zero(n, n);
  for (int i = 1; i < n; ++i) jacobi(i, i - 1) = jacobi(i - 1, i) = i / std::sqrt(4.0 * i * i - 1.0);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(jacobi);
  points = 0.5 * (eigen.eigenvalues().array() + 1.0);
  weights = eigen.eigenvectors().row(0).cwiseAbs2().transpose();
}

/// Basis functions (columns: value, d/dx, d/dy) at (x, y).
Eigen::MatrixX3d basis(double a, double b, int degree, double x, double y) {
  const EvenChebyshev tx(degree, x / a), ty(degree, y / b);
  const double bubble = 1 - x * x / (a * a) - y * y / (b * b);
  const int half = degree / 2;
  Eigen::MatrixX3d rows((half + 1) * (half + 2) / 2, 3);
  Eigen::Index row = 0;
  for (int m = 0; m <= half; ++m)
    for (int n = 0; m + n <= half; ++n, ++row) {
      const auto i = static_cast<std::size_t>(m), j = static_cast<std::size_t>(n);
      const double t = tx.value[i] * ty.value[j];
      rows(row, 0) = bubble * t;
      rows(row, 1) = -2 * x / (a * a) * t + bubble * tx.slope[i] * ty.value[j] / a;
      rows(row, 2) = -2 * y / (b * b) * t + bubble * tx.value[i] * ty.slope[j] / b;
    }
  return rows;
}

Complex wave_number(const OscillatingTube& tube) { return std::sqrt(Complex(0, -tube.frequency * tube.density / tube.viscosity)); }

}  // namespace

Complex bessel_j(int n, Complex z) {
  const Complex quarter = -0.25 * z * z;
  Complex term = n == 0 ? Complex(1) : 0.5 * z, sum = term;
  for (int k = 1; k < 200; ++k) {
    term *= quarter / static_cast<double>(k * (k + n));
    sum += term;
    if (std::abs(term) < 1e-17 * std::abs(sum)) break;
  }
  return sum;
}

Complex womersley_velocity(const OscillatingTube& tube, double radius) {
  const Complex k = wave_number(tube);
  return tube.gradient / Complex(0, tube.frequency * tube.density) * (1.0 - bessel_j(0, k * radius) / bessel_j(0, k * tube.half_axis_x));
}

Complex womersley_flow(const OscillatingTube& tube) {
  const double r = tube.half_axis_x;
  const Complex kr = wave_number(tube) * r;
  return M_PI * r * r * tube.gradient / Complex(0, tube.frequency * tube.density) * (1.0 - 2.0 * bessel_j(1, kr) / (kr * bessel_j(0, kr)));
}

EllipseReference::EllipseReference(const OscillatingTube& tube, int degree) : a_(tube.half_axis_x), b_(tube.half_axis_y), degree_(degree) {
  Eigen::VectorXd radii, weights;
  gauss_points(degree + 4, radii, weights);
  const int angles = 4 * degree + 16;
  const Eigen::Index size = basis(a_, b_, degree, 0, 0).rows();
  Eigen::MatrixXd mass = Eigen::MatrixXd::Zero(size, size), stiffness = mass;
  Eigen::VectorXd load = Eigen::VectorXd::Zero(size);
  for (Eigen::Index q = 0; q < radii.size(); ++q)
    for (int t = 0; t < angles; ++t) {
      const double angle = 2 * M_PI * t / angles;
      const Eigen::MatrixX3d f = basis(a_, b_, degree, a_ * radii[q] * std::cos(angle), b_ * radii[q] * std::sin(angle));
      const double area = a_ * b_ * radii[q] * weights[q] * 2 * M_PI / angles;
      mass += area * f.col(0) * f.col(0).transpose();
      stiffness += area * (f.col(1) * f.col(1).transpose() + f.col(2) * f.col(2).transpose());
      load += area * f.col(0);
    }
  const Eigen::MatrixXcd matrix = Complex(0, tube.frequency * tube.density) * mass.cast<Complex>() + tube.viscosity * stiffness.cast<Complex>();
  coefficients_ = matrix.fullPivLu().solve(tube.gradient * load.cast<Complex>());
  flow_ = load.cast<Complex>().dot(coefficients_);
}

Complex EllipseReference::velocity(double x, double y) const {
  return basis(a_, b_, degree_, x, y).col(0).cast<Complex>().dot(coefficients_);
}

}  // namespace mv::test
