// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Fully developed oscillating flow along a straight tube with elliptic cross-section: rho dw/dt = G e^(i omega t) + mu lap w, w = 0 on the wall,
// G = pressure drop over length. Complex amplitudes; the real part of w e^(i omega t) is the velocity. SI units.

#include <Eigen/Core>
#include <complex>

namespace mv::test {

struct OscillatingTube {
  double half_axis_x = 1, half_axis_y = 1;  // m
  double density = 1, viscosity = 1;        // kg/m3, Pa s
  double frequency = 1;                     // rad/s
  double gradient = 1;                      // Pa/m
};

/// Bessel function of the first kind and order n (0 or 1) of a complex argument by its power series; |z| below about 20.
std::complex<double> bessel_j(int n, std::complex<double> z);

/// Velocity amplitude (m/s) in a circular tube (Womersley 1955): G/(i omega rho) (1 - J0(k r)/J0(k R)), k = sqrt(-i omega rho / mu).
std::complex<double> womersley_velocity(const OscillatingTube& tube, double radius);
/// Amplitude of its volume flow (m3/s).
std::complex<double> womersley_flow(const OscillatingTube& tube);

/// Reference for any ellipse, independent of the solver's grid: Galerkin's method with (1 - x2/a2 - y2/b2) times even Chebyshev polynomials in
/// x/a and y/b up to a total degree, integrated by Gauss points along the radius and equal angles. The solution is analytic: errors fall
/// exponentially with the degree.
class EllipseReference {
 public:
  EllipseReference(const OscillatingTube& tube, int degree);
  std::complex<double> velocity(double x, double y) const;
  std::complex<double> flow() const { return flow_; }

 private:
  double a_, b_;
  int degree_;
  Eigen::VectorXcd coefficients_;
  std::complex<double> flow_;
};

}  // namespace mv::test
