// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Distortion control costs more than the law and concerns few elements, two or three of a block: its points are collected until a pack is full.

#include <bit>

#include "solver/solid/element_kernel.h"

namespace mv::solid_kernel {

static_assert(lanes <= 8);

/// Points of a tile's elements that distortion control may act on.
template <int N>
class DistortedPoints {
 public:
  /// `force`: 4 for each node of the tile. Energies and counts of elements go to `sums`.
  DistortedPoints(const ElementBlocks& blocks, const Tile& tile, double* force, BlockSums& sums)
      : blocks_(blocks), first_block_(tile.block_begin), force_(force), sums_(sums) {}

  /// The lanes of block `b`, quadrature point `q`, that `which` marks.
  void add(const LawConstants& law, std::int64_t b, int q, const Tensor<Pack>& F, PackInt which) {
    if (law_ != &law) flush();
    law_ = &law;
    for (int lane = 0; lane < lanes; ++lane) {
      if (!which[lane] || blocks_.element[static_cast<std::size_t>(b * lanes + lane)] < 0) continue;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) gradient_[3 * i + j][count_] = F(i, j)[lane];
      place_[count_] = {b, q, lane};
      if (++count_ == lanes) flush();
    }
  }

  /// After the tile's last block.
  void finish() {
    flush();
    for (int b = 0; b < tile_blocks_max; ++b) {
      sums_.controlled += std::popcount(controlled_[b]);
      sums_.inverted += std::popcount(inverted_[b]);
    }
  }

 private:
  struct Place {
    std::int64_t block;
    int point, lane;
  };

  void flush() {
    if (count_ == 0) return;
    for (int l = count_; l < lanes; ++l)
      for (int a = 0; a < 9; ++a) gradient_[a][l] = a % 4 == 0;
    Tensor<Pack> F, P{};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) F(i, j) = load(gradient_[3 * i + j]);
    const Deformation<Pack> d = deformation(F);
    PackInt is_active;
    const Pack density = distortion_control(*law_, d, P, is_active);
    for (int l = 0; l < count_; ++l) add_forces(place_[l], l, P, density[l], is_active[l] != 0, d.J[l] <= 0);
    count_ = 0;
  }

  void add_forces(const Place& at, int l, const Tensor<Pack>& P, double density, bool is_active, bool is_inverted) {
    const double* point = blocks_.block(at.block) + at.point * 10 * lanes + at.lane;
    const double weight = point[9 * lanes];
    sums_.energy[at.lane] += weight * density;
    sums_.control_energy[at.lane] += weight * density;
    controlled_[at.block - first_block_] |= static_cast<std::uint8_t>(is_active << at.lane);
    inverted_[at.block - first_block_] |= static_cast<std::uint8_t>(is_inverted << at.lane);
    const std::int32_t* index = blocks_.local_node.data() + at.block * N * lanes + at.lane;
    for (int k = 0; k < 3; ++k) {
      double t[3];
      for (int i = 0; i < 3; ++i) {
        t[i] = 0;
        for (int j = 0; j < 3; ++j) t[i] += weight * P(i, j)[l] * point[(3 * k + j) * lanes];
      }
      for (int a = 0; a < N; ++a) {
        double* f = force_ + 4 * static_cast<std::ptrdiff_t>(index[a * lanes]);
        const double slope = shape_derivative<N>(at.point, a, k);
        for (int i = 0; i < 3; ++i) f[i] -= slope * t[i];
      }
    }
  }

  const ElementBlocks& blocks_;
  std::int64_t first_block_;
  double* force_;
  BlockSums& sums_;
  const LawConstants* law_ = nullptr;
  int count_ = 0;
  std::uint8_t controlled_[tile_blocks_max] = {}, inverted_[tile_blocks_max] = {};   // bit l: element in lane l of the block
  Place place_[lanes];
  alignas(64) double gradient_[9][lanes];
};

}   // namespace mv::solid_kernel
