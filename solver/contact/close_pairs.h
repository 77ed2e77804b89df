// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Which vertices and triangles, and which edges and edges, of a triangulated surface are near each other: all but what shares a vertex.
//
// Triangles around a vertex need no look where the surface is flat: all normals within 45 degrees of an axis. Seen along the axis they then do not overlap; where all of them
// are still higher than the radius, their parts without a common vertex are so far apart. (Not so at a slit in an open surface; normal cones: Volino & Magnenat-Thalmann 1994.)

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "solver/contact/box_tree.h"
#include "solver/contact/primitive_distance.h"

namespace mv {

/// A vertex and a triangle {vertex, a, b, c}, or two edges {a, b, c, d} (a-b and c-d).
struct ClosePair {
  std::array<int, 4> node;
  bool is_edges;
  float distance;  // m, at the search; rounded down
  auto key() const { return std::pair(is_edges, node); }
};

class ClosePairs {
 public:
  /// `rest`: 3 * vertices (m), where neighbours are neighbours. Throws InputError on an index out of range.
  ClosePairs(std::span<const double> rest, std::span<const std::array<int, 3>> triangles);

  /// All pairs without a common vertex nearer than `radius` (m), nearest first up to a 64th of the radius, then in any order. `x`: 3 *
  /// vertices. The same for every thread count. Throws TrustError when x is not finite. Reuses its memory.
  void update(std::span<const double> x, double radius);

  std::span<const ClosePair> pairs() const { return pairs_; }
  /// Those nearer than `distance` (and perhaps a few more).
  std::span<const ClosePair> pairs_within(double distance) const;
  double radius() const { return radius_; }
  const std::vector<int>& vertices() const { return used_; }  // those of the triangles, ascending
  double longest_edge(std::span<const double> x) const;  // m
  int edge_count() const { return static_cast<int>(edges_.size()); }

 private:
  /// Vertices and edges that a triangle stands for, so that each is met once.
  struct Owned {
    std::array<int, 3> vertex{-1, -1, -1};
    std::array<int, 3> edge{-1, -1, -1};
  };
  void find_flat_vertices(std::span<const double> x);
  unsigned sharing_a_flat_vertex(int f, int leaf) const;
  unsigned far_from(int f, int leaf, std::span<const double> x) const;
  void add_pairs(int f, int g, std::span<const double> x, std::vector<ClosePair>& out) const;
  void add(bool is_edges, const std::array<int, 4>& node, std::span<const double> x, std::vector<ClosePair>& out) const;

  std::vector<std::array<int, 3>> triangles_;
  std::vector<std::array<int, 2>> edges_;
  std::vector<Owned> owned_;
  std::vector<int> used_;
  std::vector<int> star_start_, star_;  // triangles around each vertex
  std::vector<ClosePair> pairs_;
  std::vector<int> shell_start_;  // per shell of distance
  double radius_ = 0;
  // Scratch of update().
  BoxTree tree_;  // of the triangles
  /// The triangles of a leaf.
  struct alignas(32) Lanes {
    std::array<std::array<std::int32_t, BoxTree::width>, 3> vertex;
    std::array<std::array<std::array<float, BoxTree::width>, 3>, 3> corner;  // coordinates of each
  };
  std::vector<Lanes> lanes_;    // per leaf
  float margin_ = 0;            // m, single precision
  std::vector<Eigen::Vector3d> centre_, normal_;
  std::vector<double> height_;  // m, per triangle: least
  std::vector<char> is_flat_;  // per vertex
  std::vector<BoxTree::Box> box_;
  std::vector<std::vector<ClosePair>> found_;
};

}  // namespace mv
