// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Broad phase: which triangles a surface node might touch. A pair is left out for good when node and triangle are neighbours in
// the solid: reference distance below the exclusion radius and joined by the solid's edges within that radius (pairs that already
// face each other across a gap at rest) or twice that radius (all others: the same face, or the back face seen through the
// thickness). A wider radius holds for pairs on different faces, so that a squeezed leaflet does not meet its own back face.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "solver/contact/box_tree.h"
#include "solver/contact/surface.h"

namespace mv {

/// Cosine below which two outward normals count as opposed.
inline constexpr double facing_cosine = -0.2;

class CandidateSearch {
 public:
  /// Keeps a reference to the surface. Radii in m: for pairs on the same face, and (not smaller) for all others.
  CandidateSearch(const ContactSurface& surface, double exclusion_radius, double exclusion_radius_through);

  /// Finds for every surface node all triangles closer than `radius` (m; never misses one, may list some that are further) that
  /// are not excluded. `x`: 3 * solid_nodes. Throws TrustError when x is not finite. Reuses its memory.
  /// Triangles that look the same way as the node are left out, too: those that would need `turn` (length by which unit normals
  /// change) or more, both theirs and that of a triangle at the node, before the scalar product of any two of them is negative.
  void update(std::span<const double> x, double radius, double turn);

  /// Outward unit normals of the triangles at the last update(); zero for a degenerate one.
  std::span<const Eigen::Vector3d> normals() const { return normal_; }

  /// The pair never touches (see above). Pure function of the reference configuration.
  bool is_excluded(int node, int triangle) const;

  /// Candidates of a node in one leaf of the tree of triangles: bit l of `lanes` stands for the triangle tree().item(8 * leaf + l).
  struct Block {
    std::int32_t leaf;
    std::uint32_t lanes;
  };
  std::span<const Block> blocks_of(int node) const { return blocks_at(slot_of(node)); }
  /// Nodes in an order in which neighbours follow each other: node_at(slot) is -1 for an empty one of `slot_count()`.
  int slot_count() const { return node_tree_.slot_count(); }
  int node_at(int slot) const { return node_tree_.item(slot); }
  int slot_of(int node) const { return node_slot_[static_cast<std::size_t>(node)]; }
  std::span<const Block> blocks_at(int node_slot) const {
    const auto slot = static_cast<std::size_t>(node_slot);
    return {block_.data() + start_[slot], static_cast<std::size_t>(start_[slot + 1] - start_[slot])};
  }
  const BoxTree& tree() const { return tree_; }
  /// The same as a list, ascending.
  std::vector<int> triangles_of(int node) const { return triangles_in(blocks_of(node)); }
  std::vector<int> triangles_in(std::span<const Block> blocks) const;
  long pair_count() const;

 private:
  struct View {
    Eigen::Vector3f axis;
    float cosine;
  };
  /// What eight nodes that are neighbours have in common.
  struct Group {
    BoxTree::Box box;
    Eigen::Vector3f axis;
    float cosine, sine;  // of the angle to `axis` within which no node of the group can face a triangle; cosine 2: nothing is left out
  };
  View view_of(int node, double turn) const;
  Group group_of(int leaf, std::span<const double> x, std::span<const View> views) const;
  void fit_leaves(double radius, float margin);
  unsigned candidates_in(int leaf, int node, const Eigen::Vector3f& p, const View& view) const;
  void find_exceptions();
  bool is_exception(int node, int triangle) const;
  bool is_same_face(int node, int triangle) const { return surface_.node_side[static_cast<std::size_t>(node)] == surface_.triangle_side[static_cast<std::size_t>(triangle)]; }

  const ContactSurface& surface_;
  float exclusion_squared_, exclusion_squared_through_;
  double exclusion_radius_, exclusion_radius_through_;
  // Rest positions in single precision: the exclusion rule must give the same answer wherever it is asked.
  std::vector<Eigen::Vector3f> rest_node_, rest_centre_;
  std::vector<int> exception_start_, exception_;  // per node: triangles within the radius that may touch nevertheless
  BoxTree tree_, node_tree_;                      // of the triangles, of the nodes
  std::vector<int> node_slot_;                    // per node: its slot of node_tree_
  std::vector<int> start_;                        // result, per slot of node_tree_
  std::vector<Block> block_;
  // Scratch of update().
  /// The triangles of a leaf.
  struct alignas(32) Lanes {
    std::array<float, BoxTree::width> cx, cy, cz, reach_squared, rx, ry, rz, nx, ny, nz;
    std::array<std::int32_t, BoxTree::width> side;
  };
  /// A cone around their normals.
  struct Cone {
    Eigen::Vector3f axis;
    float cosine, sine;  // of its half angle; cosine -2: some triangle has no normal
  };
  std::vector<Eigen::Vector3d> centre_, normal_;
  std::vector<double> radius_;
  std::vector<Lanes> lanes_;                // per leaf
  std::vector<Cone> cone_;                  // per leaf
  std::vector<std::vector<Block>> found_;   // per piece of nodes
};

}  // namespace mv
