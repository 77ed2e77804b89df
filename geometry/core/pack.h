// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Eight doubles in one vector register (AVX-512), or four in one (AVX2) or two (SSE2), through the compiler's vector types, and the few
// functions the material kernels need, each with the same meaning for double and for Pack. Values and masks are lane by lane. exp
// and log are our own, from argument reduction and series; their error against std:: is below 4e-16 relative (tested).

#include <cmath>
#include <cstdint>
#include <cstring>
#if defined(__AVX512F__) || defined(__AVX2__)
#include <immintrin.h>
#endif

// Not wider than a register: the compiler takes selections of wider vectors apart, value by value (tissue took 2.2 times as long).
#if defined(__AVX512F__)
#define MV_LANES 8
#else
#define MV_LANES 4
#endif

namespace mv {

inline constexpr int lanes = MV_LANES;

using Pack = double __attribute__((vector_size(8 * lanes)));
using PackInt = std::int64_t __attribute__((vector_size(8 * lanes)));   // result of comparing packs: 0 or -1 in each lane
using PackUnsigned = std::uint64_t __attribute__((vector_size(8 * lanes)));

#define MV_INLINE inline __attribute__((always_inline))

template <class T>
struct MaskOf {
  using type = bool;
};
template <>
struct MaskOf<Pack> {
  using type = PackInt;
};
template <class T>
using Mask = typename MaskOf<T>::type;

template <class T>
MV_INLINE T broadcast(double value) {
  return T{} + value;
}

MV_INLINE Pack load(const double* p) {
  Pack r;
  std::memcpy(&r, p, sizeof r);
  return r;
}
/// p[index[0]], p[index[1]], ... Filled value by value into memory and loaded from there it would take several times as long.
MV_INLINE Pack gather(const double* p, const std::int32_t* index) {
#if MV_LANES == 8
  return Pack{p[index[0]], p[index[1]], p[index[2]], p[index[3]], p[index[4]], p[index[5]], p[index[6]], p[index[7]]};
#else
  return Pack{p[index[0]], p[index[1]], p[index[2]], p[index[3]]};
#endif
}
MV_INLINE void store(double* p, Pack v) { std::memcpy(p, &v, sizeof v); }

MV_INLINE double select(bool mask, double a, double b) { return mask ? a : b; }
MV_INLINE Pack select(PackInt mask, Pack a, Pack b) { return mask ? a : b; }

MV_INLINE bool any(bool mask) { return mask; }
MV_INLINE bool any(PackInt mask) {
#if defined(__AVX512DQ__)
  return _mm512_movepi64_mask((__m512i)mask) != 0;
#elif defined(__AVX2__) && MV_LANES == 4
  return _mm256_movemask_pd((__m256d)mask) != 0;
#else
  std::int64_t r = 0;
  for (int i = 0; i < lanes; ++i) r |= mask[i];
  return r != 0;
#endif
}

/// Bit l: lane l holds.
MV_INLINE unsigned bits(PackInt mask) {
#if defined(__AVX512DQ__)
  return static_cast<unsigned>(_mm512_movepi64_mask((__m512i)mask));
#elif defined(__AVX2__) && MV_LANES == 4
  return static_cast<unsigned>(_mm256_movemask_pd((__m256d)mask));
#else
  unsigned r = 0;
  for (int i = 0; i < lanes; ++i) r |= static_cast<unsigned>(mask[i] & 1) << i;
  return r;
#endif
}

MV_INLINE double maximum(double a, double b) { return a > b ? a : b; }
MV_INLINE double minimum(double a, double b) { return a < b ? a : b; }
MV_INLINE Pack maximum(Pack a, Pack b) { return a > b ? a : b; }
MV_INLINE Pack minimum(Pack a, Pack b) { return a < b ? a : b; }
MV_INLINE Pack maximum(Pack a, double b) { return maximum(a, broadcast<Pack>(b)); }
MV_INLINE Pack minimum(Pack a, double b) { return minimum(a, broadcast<Pack>(b)); }

/// Over the lanes, always in the same order.
MV_INLINE double sum_of(Pack a) {
#if MV_LANES == 8
  const auto half = __builtin_shufflevector(a, a, 0, 1, 2, 3) + __builtin_shufflevector(a, a, 4, 5, 6, 7);
  return (half[0] + half[2]) + (half[1] + half[3]);
#else
  return (a[0] + a[2]) + (a[1] + a[3]);
#endif
}
MV_INLINE double least_of(Pack a) {
  double least = a[0];
  for (int i = 1; i < lanes; ++i) least = minimum(a[i], least);
  return least;
}
MV_INLINE double most_of(Pack a) { return -least_of(-a); }

template <class T>
MV_INLINE T absolute(T a) {
  return maximum(a, -a);
}

MV_INLINE double square_root(double a) { return std::sqrt(a); }
MV_INLINE Pack square_root(Pack a) {
#if defined(__AVX512F__)
  return (Pack)_mm512_maskz_sqrt_pd((__mmask8)-1, (__m512d)a);
#elif defined(__AVX2__)
  return (Pack)_mm256_sqrt_pd((__m256d)a);
#else
  Pack r;
  for (int i = 0; i < lanes; ++i) r[i] = __builtin_sqrt(a[i]);
  return r;
#endif
}

/// 1/sqrt(a) for a in [1e-300, 1e300], to 3e-16 relative: estimate of 14 bits, one cubic and one quadratic Newton step.
MV_INLINE double inverse_square_root(double a) { return 1 / std::sqrt(a); }
MV_INLINE Pack inverse_square_root(Pack a) {
#if defined(__AVX512F__)
  Pack y = (Pack)_mm512_maskz_rsqrt14_pd((__mmask8)-1, (__m512d)a);
  Pack e = 1.0 - (a * y) * y;
  y += y * (e * (0.5 + 0.375 * e));
  e = 1.0 - (a * y) * y;
  return y + y * (0.5 * e);
#else
  return 1.0 / square_root(a);
#endif
}

MV_INLINE double exponential(double a) { return std::exp(a); }
/// a is cut to [-700, 700]. exp(a) = 2^n exp(r), |r| <= ln 2 / 2, Taylor series of degree 13.
MV_INLINE Pack exponential(Pack a) {
  constexpr double shifter = 0x1.8p52;   // adding it leaves the nearest integer in the low bits
  constexpr double ln2_high = 0x1.62e42fee00000p-1, ln2_low = 0x1.a39ef35793c76p-33;
  constexpr double inverse_factorial[] = {
      1.0,        1.0,         1.0 / 2,      1.0 / 6,       1.0 / 24,       1.0 / 120,       1.0 / 720,
      1.0 / 5040, 1.0 / 40320, 1.0 / 362880, 1.0 / 3628800, 1.0 / 39916800, 1.0 / 479001600, 1.0 / 6227020800};
  a = minimum(maximum(a, -700.0), 700.0);
  const Pack shifted = a * 1.4426950408889634 + shifter;
  const Pack n = shifted - shifter;
  const Pack r = (a - n * ln2_high) - n * ln2_low;
  Pack p = broadcast<Pack>(inverse_factorial[13]);
  for (int k = 12; k >= 0; --k) p = p * r + inverse_factorial[k];
  return (Pack)((PackInt)p + ((PackInt)shifted << 52));
}

MV_INLINE double logarithm(double a) { return std::log(a); }
/// a must be positive and normal. a = 2^e m, m in [sqrt(1/2), sqrt 2); ln m = 2 artanh((m - 1)/(m + 1)) by its series.
MV_INLINE Pack logarithm(Pack a) {
  constexpr double shifter = 0x1.8p52;
  constexpr std::int64_t root_half_bits = 0x3fe6a09e667f3bcd, shifter_bits = 0x4338000000000000;
  constexpr double ln2_high = 0x1.62e42fee00000p-1, ln2_low = 0x1.a39ef35793c76p-33;
  const PackInt bits = (PackInt)a;
  // AVX2 shifts 64 bits without sign only: an offset of 1024 keeps what is shifted positive.
  const PackInt e = (PackInt)((PackUnsigned)(bits - root_half_bits + (std::int64_t{1024} << 52)) >> 52) - 1024;
  const Pack m = (Pack)(bits - (e << 52));
  const Pack exponent = (Pack)(e + shifter_bits) - shifter;
  const Pack f = m - 1.0;
  const Pack s = f / (f + 2.0);
  const Pack z = s * s;
  Pack p = broadcast<Pack>(2.0 / 23);
  for (int k = 21; k >= 3; k -= 2) p = p * z + 2.0 / k;
  // ln m = 2 s + s z p, and 2 s = f - s f keeps the leading term exact
  const Pack ln_m = f - s * (f - z * p);
  return exponent * ln2_high + (ln_m + exponent * ln2_low);
}

}   // namespace mv
