// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Material response at a point, written once for one point (T = double) and for `lanes` of them (T = Pack). Pure functions.
//
// Isochoric laws are functions of I1b = m I1 and I4b = m4 I4 with m = J^(-2/3) (m4 = m, or 1 without the modified fibre
// invariant), so
//   P = 2 m W1 F + 2 m4 W4 (F f) (x) f + (W1 I1 m' + W4 I4 m4' + U') cof F,       W1 = dW/dI1b, W4 = dW/dI4b, cof F = dJ/dF.
// Nothing is divided by J, which keeps every term finite for flat and inverted elements.

#include "geometry/core/pack.h"
#include "solver/solid/material.h"
#include "solver/solid/principal.h"

namespace mv::solid_kernel {

/// M1, HGO and neo-Hookean are one form:  c (I1b - 3) + a/(2b) (exp(b <E>^2) - 1),  E = k1 (I1b - 3) + k4 (I4b - 1).
enum class Form { fibre_exponential, ogden, m2, m3 };

/// Material turned into the numbers the kernels need.
struct LawConstants {
  Form form = Form::fibre_exponential;
  bool has_modified_fibre_invariant = true;
  double bulk = 0;
  double c = 0, a = 0, b = 1, k1 = 0, k4 = 1, e_limit = 0;                                             // fibre_exponential
  double c0 = 0, c1 = 0, c2 = 0, exponent_limit = 0;                                                   // m2, m3
  double twice_mu_over_alpha[3] = {0, 0, 0}, alpha[3] = {1, 1, 1}, stretch_min = 0, stretch_max = 0;   // ogden
  double control_strain = 0, control_stiffness = 0;
};

LawConstants law_constants(const Material& material);

template <class T>
struct Deformation {
  Tensor<T> F, cof;
  T J, I1, I2;
};

template <class T>
MV_INLINE Deformation<T> deformation(const Tensor<T>& F) {
  Deformation<T> d;
  d.F = F;
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      d.cof(i, j) = F(i1, j1) * F(i2, j2) - F(i1, j2) * F(i2, j1);
    }
  }
  d.J = F(0, 0) * d.cof(0, 0) + F(0, 1) * d.cof(0, 1) + F(0, 2) * d.cof(0, 2);
  d.I1 = squared_norm(F);
  d.I2 = squared_norm(d.cof);
  return d;
}

/// m(J) = J^(-2/3) and U(J)/bulk = (ln J)^2 / 2 with derivatives; below volume_floor the tangent of m and the parabola of U.
template <class T>
struct Volumetric {
  T m, dm, U, dU;
};

template <class T>
MV_INLINE Volumetric<T> volumetric(T J) {
  Volumetric<T> v;
  const T Jc = maximum(J, broadcast<T>(volume_floor));
  const T below = J - Jc;
  const T inverse = 1.0 / Jc;
  const T log_J = logarithm(Jc);
  const T mc = exponential((-2.0 / 3.0) * log_J);
  v.dm = (-2.0 / 3.0) * mc * inverse;
  v.m = mc + v.dm * below;
  const T slope = log_J * inverse;
  const T curvature = (1.0 - log_J) * inverse * inverse;
  v.U = 0.5 * log_J * log_J + (slope + 0.5 * curvature * below) * below;
  v.dU = slope + curvature * below;
  return v;
}

template <class T>
struct Isochoric {
  T W, W1, W4;
};

template <class T>
MV_INLINE Isochoric<T> fibre_exponential(const LawConstants& k, T I1b, T I4b) {
  Isochoric<T> r{k.c * (I1b - 3.0), broadcast<T>(k.c), T{}};
  if (k.a == 0) return r;
  const T E = maximum(k.k1 * (I1b - 3.0) + k.k4 * (I4b - 1.0), T{});
  if (!any(E > T{})) return r;
  const T e = minimum(E, broadcast<T>(k.e_limit));
  const T above = E - e;
  const T q = k.b * e * e;
  const T scale = k.a * exponential(q);
  const T slope = scale * e;
  const T curvature = scale * (1.0 + 2.0 * q);
  const T dW = slope + curvature * above;
  r.W = r.W + (scale - k.a) * (0.5 / k.b) + (slope + 0.5 * curvature * above) * above;
  r.W1 = r.W1 + k.k1 * dW;
  r.W4 = k.k4 * dW;
  return r;
}

/// c0 (exp(Q) - 1) with the exponential continued as its tangent above the limit; dQ1, dQ4 are the derivatives of Q.
template <class T>
MV_INLINE Isochoric<T> exponential_of(const LawConstants& k, T Q, T dQ1, T dQ4) {
  const T q = minimum(Q, broadcast<T>(k.exponent_limit));
  const T scale = k.c0 * exponential(q);
  return {scale * (1.0 + (Q - q)) - k.c0, scale * dQ1, scale * dQ4};
}

template <class T>
MV_INLINE Isochoric<T> m2_law(const LawConstants& k, T I1b, T I4b) {
  const T i1 = I1b - 3.0;
  const T stretch = square_root(maximum(I4b, broadcast<T>(1.0)));
  const T e = stretch - 1.0;
  return exponential_of<T>(k, k.c1 * i1 * i1 + k.c2 * e * e * e * e, 2.0 * k.c1 * i1, 2.0 * k.c2 * e * e * e / stretch);
}

template <class T>
MV_INLINE Isochoric<T> m3_law(const LawConstants& k, T I1b, T I4b) {
  const T i1 = I1b - 3.0;
  const T e = maximum(I4b - 1.0, T{});
  return exponential_of<T>(k, k.c1 * i1 * i1 + k.c2 * e * e, 2.0 * k.c1 * i1, 2.0 * k.c2 * e);
}

/// psi(l) = sum_i 2 mu_i/alpha_i^2 (l^alpha_i - 1) of a modified stretch l, and psi'. Outside [stretch_min, stretch_max] a
/// parabola in l, which goes on through l = 0: as a function of the signed stretch the law has no trap on the inverted side.
template <class T>
struct OgdenTerm {
  T psi, dpsi;
};

template <class T>
MV_INLINE OgdenTerm<T> ogden_term(const LawConstants& k, T stretch) {
  const T inside = minimum(maximum(stretch, broadcast<T>(k.stretch_min)), broadcast<T>(k.stretch_max));
  const T outside = stretch - inside;
  const T log_stretch = logarithm(inside);
  const T inverse = 1.0 / inside;
  T psi = T{}, dpsi = T{}, ddpsi = T{};
  for (int i = 0; i < 3; ++i) {
    const T power = k.twice_mu_over_alpha[i] * exponential(k.alpha[i] * log_stretch);
    psi = psi + (power - k.twice_mu_over_alpha[i]) * (1.0 / k.alpha[i]);
    dpsi = dpsi + power;
    ddpsi = ddpsi + (k.alpha[i] - 1.0) * power;
  }
  dpsi = dpsi * inverse;
  ddpsi = ddpsi * inverse * inverse;
  return {psi + (dpsi + 0.5 * ddpsi * outside) * outside, dpsi + ddpsi * outside};
}

template <class T>
struct Response {
  T W;           // J/m3, distortion control not yet in it
  Tensor<T> P;   // Pa
};

template <class T>
struct CubeRootFactor {
  T r, dr;   // J^(-1/3) and its derivative
};

/// Below stretch_min and for J <= 0, with signed stretches F = sum_a l_a n_a (x) N_a. Rare, and long: kept out of the hot loop.
template <class T>
__attribute__((noinline)) void ogden_signed_terms(const LawConstants& k, const Deformation<T>& d, const CubeRootFactor<T>& v,
                                                  const Spectrum<T>& spectrum, Response<T>& response) {
  const SignedStretches<T> s = signed_stretches(d.F, d.cof, d.J, spectrum);
  T volume_slope{};
  response.W = T{};
  for (int a = 0; a < 3; ++a) {
    const OgdenTerm<T> t = ogden_term(k, v.r * s.stretch[a]);
    response.W = response.W + t.psi;
    volume_slope = volume_slope + t.dpsi * s.stretch[a] * v.dr;
    const T stress = v.r * t.dpsi;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const T term = stress * s.current[a][i] * s.reference[a][j];
        response.P(i, j) = a == 0 ? term : response.P(i, j) + term;
      }
  }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) response.P(i, j) = response.P(i, j) + volume_slope * d.cof(i, j);
}

/// P = r sum_a psi'(r l_a) n_a (x) N_a + (sum_a psi'(r l_a) l_a r' + U') cof F,  r = J^(-1/3),  n_a = F N_a / l_a.
template <class T>
MV_INLINE Response<T> ogden_response(const LawConstants& k, const Deformation<T>& d) {
  const Volumetric<T> v = volumetric(d.J);
  const T r = square_root(v.m);
  const CubeRootFactor<T> factor{r, 0.5 * v.dm / r};
  const Spectrum<T> s = principal_values(right_cauchy_green(d.F));
  const T smallest = v.m * minimum(s.value[0], minimum(s.value[1], s.value[2]));
  Response<T> response;
  if (any((smallest < broadcast<T>(k.stretch_min * k.stretch_min)) | (d.J < broadcast<T>(volume_floor)))) {
    ogden_signed_terms(k, d, factor, s, response);
  } else {
    Tensor<T> S{};
    T volume_slope{};
    response.W = T{};
    for (int a = 0; a < 3; ++a) {
      const T inverse_stretch = inverse_square_root(s.value[a]);
      const T stretch = s.value[a] * inverse_stretch;
      const OgdenTerm<T> t = ogden_term(k, r * stretch);
      response.W = response.W + t.psi;
      volume_slope = volume_slope + t.dpsi * stretch * factor.dr;
      const T weight = r * t.dpsi * inverse_stretch;
      for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j) S(i, j) = S(i, j) + weight * s.vector[a][i] * s.vector[a][j];
    }
    S(1, 0) = S(0, 1), S(2, 0) = S(0, 2), S(2, 1) = S(1, 2);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        response.P(i, j) = d.F(i, 0) * S(0, j) + d.F(i, 1) * S(1, j) + d.F(i, 2) * S(2, j) + volume_slope * d.cof(i, j);
  }
  response.W = response.W + k.bulk * v.U;
  const T pressure = k.bulk * v.dU;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) response.P(i, j) = response.P(i, j) + pressure * d.cof(i, j);
  return response;
}

template <class T>
MV_INLINE Response<T> invariant_response(const LawConstants& k, const Deformation<T>& d, const T (&fibre)[3]) {
  const Volumetric<T> v = volumetric(d.J);
  const T m4 = k.has_modified_fibre_invariant ? v.m : broadcast<T>(1.0);
  const T dm4 = k.has_modified_fibre_invariant ? v.dm : T{};
  T g[3];
  for (int i = 0; i < 3; ++i) g[i] = d.F(i, 0) * fibre[0] + d.F(i, 1) * fibre[1] + d.F(i, 2) * fibre[2];
  const T I4 = g[0] * g[0] + g[1] * g[1] + g[2] * g[2];
  Isochoric<T> w;
  if (k.form == Form::fibre_exponential)
    w = fibre_exponential<T>(k, v.m * d.I1, m4 * I4);
  else if (k.form == Form::m2)
    w = m2_law<T>(k, v.m * d.I1, m4 * I4);
  else
    w = m3_law<T>(k, v.m * d.I1, m4 * I4);
  Response<T> r{w.W + k.bulk * v.U, {}};
  const T volume_slope = w.W1 * d.I1 * v.dm + w.W4 * I4 * dm4 + k.bulk * v.dU;
  const T w1 = 2.0 * v.m * w.W1, w4 = 2.0 * m4 * w.W4;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) r.P(i, j) = w1 * d.F(i, j) + w4 * g[i] * fibre[j] + volume_slope * d.cof(i, j);
  return r;
}

/// True where a nominal strain, of a principal stretch or the volume, may pass the control strain. Exact but for a slack of 1e-6: never false where control
/// must act.
template <class T>
MV_INLINE Mask<T> may_be_distorted(const LawConstants& k, const Deformation<T>& d) {
  constexpr double slack = 1e-6;
  const double least = 1 - k.control_strain + slack, most = 1 + k.control_strain - slack;
  const double low = least * least, high = most * most;
  // The squared stretches are the roots of c(s) = s^3 - I1 s^2 + I2 s - J^2, all real: all lie below s when c, c' and c'' are positive there, all above
  // when -c, c' and -c'' are.
  const T J2 = d.J * d.J;
  const auto value = [&](double s) { return ((s - d.I1) * s + d.I2) * s - J2; };
  const auto slope = [&](double s) { return (3 * s - 2 * d.I1) * s + d.I2; };
  const auto is_below = (value(high) > T{}) & (slope(high) > T{}) & (d.I1 < broadcast<T>(3 * high));
  const auto is_above = (value(low) < T{}) & (slope(low) > T{}) & (d.I1 > broadcast<T>(3 * low));
  return (is_below & is_above & (d.J > broadcast<T>(least)) & (d.J < broadcast<T>(most))) == Mask<T>{};
}

/// Adds distortion control to P, returns its energy density; `is_active` where it is not zero.
template <class T>
MV_INLINE T add_distortion_control(const LawConstants& k, const Deformation<T>& d, Tensor<T>& P, Mask<T>& is_active) {
  const SignedStretches<T> s = signed_stretches(d.F, d.cof, d.J, principal_values(right_cauchy_green(d.F)));
  T energy = T{}, active_measure = T{};
  auto excess = [&](T nominal) {
    const T over = maximum(absolute(nominal) - k.control_strain, T{});
    energy = energy + 0.5 * k.control_stiffness * over * over;
    active_measure = active_measure + over;
    return k.control_stiffness * select(nominal < T{}, -over, over);
  };
  for (int a = 0; a < 3; ++a) {
    const T stress = excess(s.stretch[a] - 1.0);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) P(i, j) = P(i, j) + stress * s.current[a][i] * s.reference[a][j];
  }
  const T pressure = excess(d.J - 1.0);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) P(i, j) = P(i, j) + pressure * d.cof(i, j);
  is_active = active_measure > T{};
  return energy;
}

template <class T>
MV_INLINE Response<T> law_response(const LawConstants& k, const Deformation<T>& d, const T (&fibre)[3]) {
  return k.form == Form::ogden ? ogden_response<T>(k, d) : invariant_response<T>(k, d, fibre);
}

}   // namespace mv::solid_kernel
