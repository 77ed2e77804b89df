// SPDX-License-Identifier: BSD-3-Clause
#include "solver/solid/element_blocks.h"

#include <Eigen/LU>
#include <algorithm>
#include <numeric>
#include <string>

#include "geometry/core/errors.h"

namespace mv::solid_kernel {

namespace {

Vec3 point(const SolidMesh& mesh, int node) { return Eigen::Map<const Vec3>(mesh.points.data() + 3 * static_cast<long>(node)); }

/// Interleaves 20 bits of each coordinate, so that elements near each other in space are near in the list.
std::uint64_t morton_code(const Vec3& unit) {
  constexpr double cells = 1 << 20;
  std::uint64_t code = 0;
  for (int d = 0; d < 3; ++d) {
    const auto cell = static_cast<std::uint64_t>(std::clamp(unit[d], 0.0, 1.0) * (cells - 1));
    for (int bit = 0; bit < 20; ++bit) code |= ((cell >> bit) & 1u) << (3 * bit + d);
  }
  return code;
}

/// Elements by material, then along a space-filling curve.
std::vector<std::int32_t> element_order(const SolidMesh& mesh, long count) {
  const int n = mesh.nodes_per_tet;
  Vec3 lower = Vec3::Constant(1e300), upper = Vec3::Constant(-1e300);
  std::vector<Vec3> centre(static_cast<std::size_t>(count));
  for (long e = 0; e < count; ++e) {
    Vec3 c = Vec3::Zero();
    for (int a = 0; a < 4; ++a) c += 0.25 * point(mesh, mesh.tets[e * n + a]);
    centre[e] = c;
    lower = lower.cwiseMin(c);
    upper = upper.cwiseMax(c);
  }
  const double extent = std::max((upper - lower).maxCoeff(), 1e-300);
  std::vector<std::uint64_t> code(static_cast<std::size_t>(count));
  for (long e = 0; e < count; ++e) code[e] = morton_code((centre[e] - lower) / extent);
  std::vector<std::int32_t> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
    return std::tuple(mesh.material[a], code[a], a) < std::tuple(mesh.material[b], code[b], b);
  });
  return order;
}

template <int N>
void fill_lane(const SolidMesh& mesh, std::int32_t e, bool is_padding, double* block, int lane) {
  constexpr int points = Shape<N>::points;
  for (int q = 0; q < points; ++q) {
    Mat3 jacobian = Mat3::Zero();   // dX/dxi
    for (int a = 0; a < N; ++a) {
      const Vec3 X = point(mesh, mesh.tets[static_cast<long>(e) * N + a]);
      for (int k = 0; k < 3; ++k) jacobian.col(k) += X * shape_derivative<N>(q, a, k);
    }
    const double det = jacobian.determinant();
    if (!(det > 0))
      throw InputError("leaflet element " + std::to_string(e) + " has a reference Jacobian of " + std::to_string(det * 1e9) +
                       " mm3 at quadrature point " + std::to_string(q) + "; it must be positive");
    const Mat3 inverse = jacobian.inverse();
    double* data = block + q * 10 * lanes + lane;
    for (int k = 0; k < 3; ++k)
      for (int j = 0; j < 3; ++j) data[(3 * k + j) * lanes] = inverse(k, j);
    data[9 * lanes] = is_padding ? 0.0 : det / (6.0 * points);
  }
  for (int i = 0; i < 3; ++i) block[(points * 10 + i) * lanes + lane] = mesh.fibres[static_cast<long>(e) * 3 + i];
}

/// Cuts the blocks into tiles and numbers the nodes of each.
void build_tiles(ElementBlocks& blocks, const std::vector<std::int32_t>& node) {
  const int N = blocks.nodes;
  std::vector<std::int32_t> local(static_cast<std::size_t>(blocks.node_count), -1);
  blocks.local_node.resize(node.size());
  Tile tile;
  auto close = [&] {
    for (std::int32_t i = 0; i < tile.node_count; ++i) local[blocks.tile_nodes[tile.node_begin + i]] = -1;
    blocks.tiles.push_back(tile);
  };
  for (std::int32_t b = 0; b < blocks.block_count; ++b) {
    const bool is_full = tile.node_count + N * lanes > tile_nodes_max || b - tile.block_begin >= tile_blocks_max;
    if (b > tile.block_begin && is_full) {
      close();
      tile = {b, b, static_cast<std::int32_t>(blocks.tile_nodes.size()), 0};
    }
    tile.block_end = b + 1;
    for (long i = static_cast<long>(b) * N * lanes; i < static_cast<long>(b + 1) * N * lanes; ++i) {
      std::int32_t& l = local[node[i]];
      if (l < 0) {
        l = tile.node_count++;
        blocks.tile_nodes.push_back(node[i]);
      }
      blocks.local_node[i] = l;
    }
  }
  close();
}

void build_node_lists(ElementBlocks& blocks) {
  blocks.node_begin.assign(static_cast<std::size_t>(blocks.node_count) + 1, 0);
  for (std::int32_t n : blocks.tile_nodes) ++blocks.node_begin[n + 1];
  std::partial_sum(blocks.node_begin.begin(), blocks.node_begin.end(), blocks.node_begin.begin());
  std::vector<std::int32_t> next(blocks.node_begin.begin(), blocks.node_begin.end() - 1);
  blocks.node_slot.resize(blocks.tile_nodes.size());
  for (std::size_t slot = 0; slot < blocks.tile_nodes.size(); ++slot)
    blocks.node_slot[next[blocks.tile_nodes[slot]]++] = static_cast<std::int32_t>(slot);
}

template <int N>
ElementBlocks build(const SolidMesh& mesh) {
  ElementBlocks blocks;
  blocks.nodes = N;
  blocks.points = Shape<N>::points;
  blocks.node_count = static_cast<long>(mesh.points.size()) / 3;
  blocks.element_count = static_cast<long>(mesh.tets.size()) / N;
  const std::vector<std::int32_t> order = element_order(mesh, blocks.element_count);

  // blocks of one material, the last one of each padded
  for (std::size_t i = 0; i < order.size(); ++i) {
    const int material = mesh.material[order[i]];
    if (blocks.element.size() % lanes == 0) blocks.block_material.push_back(material);
    blocks.element.push_back(order[i]);
    const bool is_last = i + 1 == order.size() || mesh.material[order[i + 1]] != material;
    while (is_last && blocks.element.size() % lanes != 0) blocks.element.push_back(-1);
  }
  blocks.block_count = static_cast<long>(blocks.block_material.size());
  blocks.data.assign(static_cast<std::size_t>(blocks.block_count * blocks.stride()), 0.0);

  std::vector<std::int32_t> node(static_cast<std::size_t>(blocks.block_count) * N * lanes);
  for (long b = 0; b < blocks.block_count; ++b) {
    std::int32_t filler = -1;
    for (int lane = 0; lane < lanes; ++lane) {
      const std::int32_t e = blocks.element[b * lanes + lane];
      if (e >= 0) filler = e;
      fill_lane<N>(mesh, filler, e < 0, blocks.data.data() + b * blocks.stride(), lane);
      for (int a = 0; a < N; ++a) node[(b * N + a) * lanes + lane] = mesh.tets[static_cast<long>(filler) * N + a];
    }
  }
  build_tiles(blocks, node);
  build_node_lists(blocks);
  return blocks;
}

}   // namespace

ElementBlocks build_element_blocks(const SolidMesh& mesh) { return mesh.nodes_per_tet == 10 ? build<10>(mesh) : build<4>(mesh); }

}   // namespace mv::solid_kernel
