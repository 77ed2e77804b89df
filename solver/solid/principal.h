// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Principal values of symmetric 3x3 tensors for T = double or Pack: cyclic Jacobi rotations. Unlike the closed form with the
// arccosine it keeps full accuracy, and orthonormal vectors, for repeated and nearly repeated values.

#include "geometry/core/pack.h"

namespace mv::solid_kernel {

template <class T>
struct Tensor {
  T a[3][3];
  MV_INLINE T& operator()(int i, int j) { return a[i][j]; }
  MV_INLINE const T& operator()(int i, int j) const { return a[i][j]; }
};

template <class T>
MV_INLINE T squared_norm(const Tensor<T>& A) {
  T s = A(0, 0) * A(0, 0);
  for (int n = 1; n < 9; ++n) s = s + A(n / 3, n % 3) * A(n / 3, n % 3);
  return s;
}

template <class T>
MV_INLINE Tensor<T> right_cauchy_green(const Tensor<T>& F) {
  Tensor<T> C;
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) {
      C(i, j) = F(0, i) * F(0, j) + F(1, i) * F(1, j) + F(2, i) * F(2, j);
      C(j, i) = C(i, j);
    }
  return C;
}

template <class T>
struct Spectrum {
  T value[3];
  T vector[3][3];   // vector[a] belongs to value[a]; orthonormal, right-handed, in no particular order
};

/// Rotation in the plane p q by the angle of at most 45 degrees that makes C(p, q) zero.
template <class T>
MV_INLINE void rotate(Tensor<T>& C, Spectrum<T>& s, int p, int q) {
  constexpr double tiny = 1e-150;   // makes the angle zero where C(p, p) = C(q, q) and C(p, q) = 0
  const int r = 3 - p - q;
  const T difference = C(q, q) - C(p, p);
  const T twice = 2.0 * C(p, q);
  const T size = absolute(difference) + tiny;
  const T inverse_root = inverse_square_root(size * size + twice * twice);
  const T cosine2 = size * inverse_root;
  const T sine2 = select(difference < T{}, -twice, twice) * inverse_root;
  const T cosine_squared = 0.5 + 0.5 * cosine2;
  const T inverse_cosine = inverse_square_root(cosine_squared);
  const T cosine = cosine_squared * inverse_cosine;
  const T sine = 0.5 * sine2 * inverse_cosine;
  const T t = sine * inverse_cosine;
  C(p, p) = C(p, p) - t * C(p, q);
  C(q, q) = C(q, q) + t * C(p, q);
  C(p, q) = T{};
  const T pr = cosine * C(p, r) - sine * C(q, r);
  C(q, r) = sine * C(p, r) + cosine * C(q, r);
  C(p, r) = pr;
  C(r, p) = C(p, r);
  C(r, q) = C(q, r);
  C(q, p) = C(p, q);
  for (int i = 0; i < 3; ++i) {
    const T vp = cosine * s.vector[p][i] - sine * s.vector[q][i];
    s.vector[q][i] = sine * s.vector[p][i] + cosine * s.vector[q][i];
    s.vector[p][i] = vp;
  }
}

/// At most `sweeps_max` sweeps of three rotations; convergence is quadratic at least; four usually reach round-off, six leave a
/// margin.
template <class T>
MV_INLINE Spectrum<T> principal_values(Tensor<T> C) {
  constexpr int sweeps_max = 6;
  constexpr double negligible = 1e-30;   // squared ratio of off-diagonal to diagonal: vectors then err by 1e-15
  Spectrum<T> s;
  for (int a = 0; a < 3; ++a)
    for (int i = 0; i < 3; ++i) s.vector[a][i] = broadcast<T>(a == i ? 1.0 : 0.0);
  for (int sweep = 0; sweep < sweeps_max; ++sweep) {
    const T off = C(0, 1) * C(0, 1) + C(0, 2) * C(0, 2) + C(1, 2) * C(1, 2);
    const T trace = C(0, 0) + C(1, 1) + C(2, 2);
    if (!any(off > negligible * trace * trace)) break;
    rotate(C, s, 0, 1);
    rotate(C, s, 0, 2);
    rotate(C, s, 1, 2);
  }
  for (int a = 0; a < 3; ++a) s.value[a] = C(a, a);
  return s;
}

/// F = sum_a stretch_a current_a (x) reference_a with the last stretch the smallest and carrying the sign of J = det F, so that
/// it passes smoothly through zero when the element inverts. `cof` is the cofactor tensor of F, `s` the spectrum of F^T F.
template <class T>
struct SignedStretches {
  T stretch[3];
  T current[3][3], reference[3][3];
};

template <class T>
MV_INLINE SignedStretches<T> signed_stretches(const Tensor<T>& F, const Tensor<T>& cof, T J, Spectrum<T> s) {
  for (int a = 0; a < 2; ++a) {
    const auto is_smaller = s.value[a] < s.value[2];
    const T value = s.value[a];
    s.value[a] = select(is_smaller, s.value[2], s.value[a]);
    s.value[2] = select(is_smaller, value, s.value[2]);
    for (int i = 0; i < 3; ++i) {
      const T component = s.vector[a][i];
      s.vector[a][i] = select(is_smaller, s.vector[2][i], s.vector[a][i]);
      s.vector[2][i] = select(is_smaller, component, s.vector[2][i]);
    }
  }
  SignedStretches<T> r;
  // an element collapsed to a line has no direction of its own in current[1]; the floor keeps it bounded
  const T floor = 1e-7 * square_root(maximum(maximum(s.value[0], s.value[1]), T{})) + 1e-100;
  for (int a = 0; a < 2; ++a) {
    r.stretch[a] = maximum(square_root(maximum(s.value[a], T{})), floor);
    for (int i = 0; i < 3; ++i) {
      r.reference[a][i] = s.vector[a][i];
      r.current[a][i] = (F(i, 0) * s.vector[a][0] + F(i, 1) * s.vector[a][1] + F(i, 2) * s.vector[a][2]) / r.stretch[a];
    }
  }
  // cof F N = stretch_0 stretch_1 n for the remaining pair: accurate where its own stretch vanishes
  const T inverse = 1.0 / (r.stretch[0] * r.stretch[1]);
  r.stretch[2] = J * inverse;
  for (int i = 0; i < 3; ++i) {
    r.reference[2][i] = s.vector[2][i];
    r.current[2][i] = (cof(i, 0) * s.vector[2][0] + cof(i, 1) * s.vector[2][1] + cof(i, 2) * s.vector[2][2]) * inverse;
  }
  return r;
}

}   // namespace mv::solid_kernel
