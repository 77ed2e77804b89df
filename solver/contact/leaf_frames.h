// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The triangles of a contact surface as one step needs them: of each leaf of a tree (box_tree.h) eight side by side, and outward normals by triangle.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/core/pack.h"
#include "solver/contact/leaf_heads.h"
#include "solver/contact/surface.h"

namespace mv {

/// Triangles (a, a + e1, a + e2) with unit normals n and the metric g of their edges (m); inverse_det = 1 / (4 area^2). A triangle without area has n = 0, or what rounding leaves.
struct alignas(64) LeafFrames {
  using Eight = std::array<double, BoxTree::width>;
  std::array<Eight, 3> a, e1, e2, n;
  Eight g11, g12, g22, inverse_det;
};

/// Outward unit normal (zero for a degenerate triangle) and twice the area (m2).
struct alignas(32) FaceNormal {
  Eigen::Vector3d n;
  double area2;
};

class SurfaceFrames {
 public:
  /// `tree`: of the surface's triangles, kept by reference; `radius` (m, per triangle) is added to the size in a triangle's head.
  SurfaceFrames(const ContactSurface& surface, const BoxTree& tree, std::span<const double> radius);

  /// Of x (3 * solid_nodes, m). Same bytes for every thread count.
  void update(std::span<const double> x);

  const LeafFrames& frames(int leaf) const { return frames_[static_cast<std::size_t>(leaf)]; }
  std::span<const LeafHeads> heads() const { return heads_; }
  const FaceNormal& normal(int triangle) const { return normals_[static_cast<std::size_t>(triangle)]; }
  /// Of a triangle by its slot in the tree.
  Eigen::Vector3d n(int slot) const { return vector(frames(slot / BoxTree::width).n, slot); }
  Eigen::Vector3d e1(int slot) const { return vector(frames(slot / BoxTree::width).e1, slot); }
  Eigen::Vector3d e2(int slot) const { return vector(frames(slot / BoxTree::width).e2, slot); }

 private:
  static Eigen::Vector3d vector(const std::array<LeafFrames::Eight, 3>& v, int slot) {
    const auto lane = static_cast<std::size_t>(slot % BoxTree::width);
    return {v[0][lane], v[1][lane], v[2][lane]};
  }
  void fit(int leaf, std::span<const double> x);

  const BoxTree& tree_;
  std::vector<std::array<std::array<std::int32_t, BoxTree::width>, 3>> corner_;  // by leaf: where the corners' coordinates begin in x; 0 where a lane is empty
  std::vector<double> radius_;              // by slot, m
  std::vector<LeafFrames> frames_;
  std::vector<LeafHeads> heads_;
  std::vector<FaceNormal> normals_;
};

}  // namespace mv
