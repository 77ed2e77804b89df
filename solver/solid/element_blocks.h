// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Elements laid out for the kernels: blocks of `lanes` (pack.h) of one material (structure of arrays), blocks gathered into tiles of
// neighbouring elements. A tile works on its own copies of its nodes, then every node sums the tiles it belongs to in fixed
// order: no atomics, and the same sum whatever the number of threads.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "geometry/core/pack.h"
#include "solver/solid/leaflet_solid.h"

namespace mv::solid_kernel {

template <class T>
using Aligned = std::vector<T, Eigen::aligned_allocator<T>>;

/// Derivatives of the shape functions with respect to the barycentric coordinates 1, 2, 3 at the quadrature points.
/// order[q][a][k] = dN_a/dxi_k; every point has the same weight.
template <int N>
struct Shape;

template <>
struct Shape<4> {
  static constexpr int points = 1;
  static constexpr double derivative[1][4][3] = {{{-1, -1, -1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  static constexpr double mass_share(int) { return 1.0 / 4; }
};

struct QuadraticTable {
  double d[4][10][3];
};

/// Four points (5 + 3 sqrt 5)/20, (5 - sqrt 5)/20 in barycentric coordinates, degree 2.
constexpr QuadraticTable quadratic_table() {
  constexpr double far = 0.58541019662496845446, near = 0.13819660112501051518;
  constexpr double dL[4][3] = {{-1, -1, -1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  constexpr int edges[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};
  QuadraticTable t{};
  for (int q = 0; q < 4; ++q) {
    double L[4] = {near, near, near, near};
    L[q] = far;
    for (int k = 0; k < 3; ++k) {
      for (int a = 0; a < 4; ++a) t.d[q][a][k] = (4 * L[a] - 1) * dL[a][k];
      for (int e = 0; e < 6; ++e) {
        const int a = edges[e][0], b = edges[e][1];
        t.d[q][4 + e][k] = 4 * (L[a] * dL[b][k] + L[b] * dL[a][k]);
      }
    }
  }
  return t;
}

template <>
struct Shape<10> {
  static constexpr int points = 4;
  static constexpr QuadraticTable derivatives = quadratic_table();
  /// HRZ lumping: the diagonal of the consistent mass is 6 at corners, 32 at midpoints (of 420), 216 in all.
  static constexpr double mass_share(int a) { return a < 4 ? 1.0 / 36 : 4.0 / 27; }
};

template <int N>
constexpr double shape_derivative(int q, int a, int k) {
  if constexpr (N == 4)
    return Shape<4>::derivative[q][a][k];
  else
    return Shape<10>::derivatives.d[q][a][k];
}

struct Tile {
  std::int32_t block_begin = 0, block_end = 0;
  std::int32_t node_begin = 0, node_count = 0;   // range in tile_nodes and in the partial forces
};

inline constexpr int tile_blocks_max = 64;
inline constexpr int tile_nodes_max = 512;

struct ElementBlocks {
  int nodes = 4, points = 1;
  long node_count = 0, element_count = 0, block_count = 0;
  // per block: points x (9 components of dxi/dX, row k, then the weight in m3), then 3 components of the fibre; `lanes` values each.
  // Lanes that pad the last block of a material repeat its last element with weight 0.
  Aligned<double> data;
  Aligned<std::int32_t> local_node;   // per block: nodes x lanes, index within the tile
  std::vector<int> block_material;
  std::vector<std::int32_t> element;   // per block and lane: index in the mesh, -1 for padding
  std::vector<Tile> tiles;
  std::vector<std::int32_t> tile_nodes;   // mesh node of each tile node
  // node n sums the partial forces node_slot[node_begin[n]] ... node_slot[node_begin[n + 1] - 1]
  std::vector<std::int32_t> node_begin, node_slot;

  long stride() const { return (points * 10 + 3) * lanes; }
  const double* block(long b) const { return data.data() + b * stride(); }
};

/// Throws InputError for a non-positive Jacobian, naming the element.
ElementBlocks build_element_blocks(const SolidMesh& mesh);

}   // namespace mv::solid_kernel
