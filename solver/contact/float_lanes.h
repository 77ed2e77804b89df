// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Eight floats side by side, through the compiler's vector types. Compared, they give a mask of bits. (Loops of eight the compiler unrolls before it could vectorise them.)

#include <cmath>
#include <cstdint>
#include <cstring>
#if defined(__AVX__)
#include <immintrin.h>
#endif

namespace mv {

using Floats = float __attribute__((vector_size(32)));
using FloatMask = std::int32_t __attribute__((vector_size(32)));  // of a comparison: 0 or -1 in each lane

inline __attribute__((always_inline)) Floats load_floats(const float* p) {
  Floats r;
  std::memcpy(&r, p, sizeof r);
  return r;
}

inline __attribute__((always_inline)) FloatMask load_ints(const std::int32_t* p) {
  FloatMask r;
  std::memcpy(&r, p, sizeof r);
  return r;
}

inline __attribute__((always_inline)) Floats square_root(Floats x) {
#if defined(__AVX__)
  __m256 m;
  std::memcpy(&m, &x, sizeof m);
  m = _mm256_sqrt_ps(m);
  std::memcpy(&x, &m, sizeof m);
#else
  for (int l = 0; l < 8; ++l) x[l] = std::sqrt(x[l]);
#endif
  return x;
}

/// Bit l: lane l holds.
inline __attribute__((always_inline)) unsigned bits(const FloatMask& mask) {
#if defined(__AVX__)
  __m256 m;
  std::memcpy(&m, &mask, sizeof m);
  return static_cast<unsigned>(_mm256_movemask_ps(m));
#else
  unsigned b = 0;
  for (unsigned l = 0; l < 8; ++l) b |= static_cast<unsigned>(mask[l] & 1) << l;
  return b;
#endif
}

}  // namespace mv
