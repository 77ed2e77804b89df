// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Forces of a block of `lanes` elements at once: gather, compute, scatter.

#include "solver/solid/element_blocks.h"
#include "solver/solid/material_kernel.h"

namespace mv::solid_kernel {

using Quad = double __attribute__((vector_size(32)));   // x y z and one unused

/// Positions or forces of the nodes of a block's elements.
template <int N>
struct ElementVectors {
  Pack a[N][3];
};

/// Transposes a block's (x, y, z, -) records into three packs.
MV_INLINE void load_corner(const double* records, const std::int32_t* index, Pack (&v)[3]) {
  Quad q[lanes];
  for (int l = 0; l < lanes; ++l) std::memcpy(&q[l], records + 4 * static_cast<std::ptrdiff_t>(index[l]), sizeof(Quad));
#if MV_LANES == 8
  const Pack a = __builtin_shufflevector(q[0], q[4], 0, 1, 2, 3, 4, 5, 6, 7);
  const Pack b = __builtin_shufflevector(q[1], q[5], 0, 1, 2, 3, 4, 5, 6, 7);
  const Pack c = __builtin_shufflevector(q[2], q[6], 0, 1, 2, 3, 4, 5, 6, 7);
  const Pack d = __builtin_shufflevector(q[3], q[7], 0, 1, 2, 3, 4, 5, 6, 7);
  const Pack xz_ab = __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14);
  const Pack xz_cd = __builtin_shufflevector(c, d, 0, 8, 2, 10, 4, 12, 6, 14);
  const Pack y_ab = __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
  const Pack y_cd = __builtin_shufflevector(c, d, 1, 9, 3, 11, 5, 13, 7, 15);
  v[0] = __builtin_shufflevector(xz_ab, xz_cd, 0, 1, 8, 9, 4, 5, 12, 13);
  v[1] = __builtin_shufflevector(y_ab, y_cd, 0, 1, 8, 9, 4, 5, 12, 13);
  v[2] = __builtin_shufflevector(xz_ab, xz_cd, 2, 3, 10, 11, 6, 7, 14, 15);
#else
  const Quad xz_ab = __builtin_shufflevector(q[0], q[1], 0, 4, 2, 6), xz_cd = __builtin_shufflevector(q[2], q[3], 0, 4, 2, 6);
  const Quad y_ab = __builtin_shufflevector(q[0], q[1], 1, 5, 3, 7), y_cd = __builtin_shufflevector(q[2], q[3], 1, 5, 3, 7);
  v[0] = __builtin_shufflevector(xz_ab, xz_cd, 0, 1, 4, 5);
  v[1] = __builtin_shufflevector(y_ab, y_cd, 0, 1, 4, 5);
  v[2] = __builtin_shufflevector(xz_ab, xz_cd, 2, 3, 6, 7);
#endif
}

/// Adds three packs to a block's (x, y, z, -) records, lane after lane: elements of a block share nodes.
MV_INLINE void add_corner(double* records, const std::int32_t* index, const Pack (&v)[3]) {
  const Pack zero{};
#if MV_LANES == 8
  const Pack xy_even = __builtin_shufflevector(v[0], v[1], 0, 8, 2, 10, 4, 12, 6, 14);
  const Pack xy_odd = __builtin_shufflevector(v[0], v[1], 1, 9, 3, 11, 5, 13, 7, 15);
  const Pack z_even = __builtin_shufflevector(v[2], zero, 0, 8, 2, 10, 4, 12, 6, 14);
  const Pack z_odd = __builtin_shufflevector(v[2], zero, 1, 9, 3, 11, 5, 13, 7, 15);
  const Quad q[lanes] = {
      __builtin_shufflevector(xy_even, z_even, 0, 1, 8, 9),   __builtin_shufflevector(xy_odd, z_odd, 0, 1, 8, 9),
      __builtin_shufflevector(xy_even, z_even, 2, 3, 10, 11), __builtin_shufflevector(xy_odd, z_odd, 2, 3, 10, 11),
      __builtin_shufflevector(xy_even, z_even, 4, 5, 12, 13), __builtin_shufflevector(xy_odd, z_odd, 4, 5, 12, 13),
      __builtin_shufflevector(xy_even, z_even, 6, 7, 14, 15), __builtin_shufflevector(xy_odd, z_odd, 6, 7, 14, 15)};
#else
  const Pack xy_even = __builtin_shufflevector(v[0], v[1], 0, 4, 2, 6), xy_odd = __builtin_shufflevector(v[0], v[1], 1, 5, 3, 7);
  const Pack z_even = __builtin_shufflevector(v[2], zero, 0, 4, 2, 6), z_odd = __builtin_shufflevector(v[2], zero, 1, 5, 3, 7);
  const Quad q[lanes] = {__builtin_shufflevector(xy_even, z_even, 0, 1, 4, 5), __builtin_shufflevector(xy_odd, z_odd, 0, 1, 4, 5),
                         __builtin_shufflevector(xy_even, z_even, 2, 3, 6, 7), __builtin_shufflevector(xy_odd, z_odd, 2, 3, 6, 7)};
#endif
  for (int l = 0; l < lanes; ++l) {
    double* record = records + 4 * static_cast<std::ptrdiff_t>(index[l]);
    Quad sum;
    std::memcpy(&sum, record, sizeof sum);
    sum += q[l];
    std::memcpy(record, &sum, sizeof sum);
  }
}

struct BlockSums {
  Pack energy{}, control_energy{}, volume{};
  Pack J_min = broadcast<Pack>(1e300), J_max = broadcast<Pack>(-1e300);
  PackInt J_min_block{};
  long controlled = 0, inverted = 0;
};

/// A[i][k] = sum_a x_a[i] dN_a/dxi_k
template <int N>
MV_INLINE Tensor<Pack> parametric_gradient(const ElementVectors<N>& x, int q) {
  Tensor<Pack> A;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      if constexpr (N == 4) {
        A(i, k) = x.a[k + 1][i] - x.a[0][i];
      } else {
        // relative to node 0, whose derivative is minus the sum of the others: rigid motions then cancel to round-off of the
        // element
        Pack sum = shape_derivative<N>(q, 1, k) * (x.a[1][i] - x.a[0][i]);
        for (int a = 2; a < N; ++a) sum += shape_derivative<N>(q, a, k) * (x.a[a][i] - x.a[0][i]);
        A(i, k) = sum;
      }
    }
  return A;
}

/// F = A dxi/dX at quadrature point data `point`.
MV_INLINE Tensor<Pack> deformation_gradient(const Tensor<Pack>& A, const double* point) {
  Tensor<Pack> F;
  for (int j = 0; j < 3; ++j) {
    const Pack d0 = load(point + j * lanes), d1 = load(point + (3 + j) * lanes), d2 = load(point + (6 + j) * lanes);
    for (int i = 0; i < 3; ++i) F(i, j) = A(i, 0) * d0 + A(i, 1) * d1 + A(i, 2) * d2;
  }
  return F;
}

/// Rarely needed, and long: kept out of the hot loop.
Pack distortion_control(const LawConstants& k, const Deformation<Pack>& d, Tensor<Pack>& P, PackInt& is_active);

/// Forces -dW/dx of one block into `f` (overwritten), but for distortion control: points where that may act are handed to `on_distorted(q, deformation, which, P)`, which may add to P.
/// `data` as in ElementBlocks.
template <int N, class OnDistorted>
MV_INLINE void block_forces(const LawConstants& k, const double* data, const ElementVectors<N>& x, ElementVectors<N>& f,
                            BlockSums& sums, std::int64_t block_index, const OnDistorted& on_distorted) {
  constexpr int points = Shape<N>::points;
  const Pack fibre[3] = {load(data + points * 10 * lanes), load(data + (points * 10 + 1) * lanes),
                         load(data + (points * 10 + 2) * lanes)};
  if constexpr (points > 1)
    for (int a = 0; a < N; ++a)
      for (int i = 0; i < 3; ++i) f.a[a][i] = Pack{};
  for (int q = 0; q < points; ++q) {
    const double* point = data + q * 10 * lanes;
    const Pack weight = load(point + 9 * lanes);
    const Deformation<Pack> d = deformation(deformation_gradient(parametric_gradient<N>(x, q), point));
    Response<Pack> r = law_response<Pack>(k, d, fibre);

    sums.energy += weight * r.W;
    sums.volume += weight * d.J;
    sums.J_min_block = d.J < sums.J_min ? PackInt{} + block_index : sums.J_min_block;
    sums.J_min = minimum(d.J, sums.J_min);
    sums.J_max = maximum(d.J, sums.J_max);
    if (k.control_stiffness > 0)
      if (const PackInt which = may_be_distorted(k, d); any(which)) on_distorted(q, d, which, r.P);

    for (int k2 = 0; k2 < 3; ++k2) {
      const Pack d0 = load(point + (3 * k2) * lanes), d1 = load(point + (3 * k2 + 1) * lanes),
                 d2 = load(point + (3 * k2 + 2) * lanes);
      for (int i = 0; i < 3; ++i) {
        const Pack t = weight * (r.P(i, 0) * d0 + r.P(i, 1) * d1 + r.P(i, 2) * d2);
        if constexpr (N == 4)
          f.a[k2 + 1][i] = -t;
        else
          for (int a = 0; a < N; ++a) f.a[a][i] -= shape_derivative<N>(q, a, k2) * t;
      }
    }
  }
  if constexpr (N == 4)
    for (int i = 0; i < 3; ++i) f.a[0][i] = -(f.a[1][i] + f.a[2][i] + f.a[3][i]);
}

}   // namespace mv::solid_kernel
