// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Broad phase: which triangles a surface node might touch. A pair is left out for good when node and triangle are neighbours in
// the solid: reference distance below the exclusion radius and joined by the solid's edges within that radius (pairs that already
// face each other across a gap at rest) or twice that radius (all others: the same face, or the back face seen through the
// thickness). A wider radius holds for pairs on different faces, so that a squeezed leaflet does not meet its own back face.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "solver/contact/box_grid.h"
#include "solver/contact/surface.h"

namespace mv {

/// Cosine below which two outward normals count as opposed.
inline constexpr double facing_cosine = -0.2;

class CandidateSearch {
 public:
  /// Keeps a reference to the surface. Radii in m: for pairs on the same face, and (not smaller) for all others.
  CandidateSearch(const ContactSurface& surface, double exclusion_radius, double exclusion_radius_through);

  /// Lists for every surface node all triangles closer than `radius` (m; never misses one, may list some that are further) that
  /// are not excluded, in ascending order. `x`: 3 * solid_nodes. Throws TrustError when x is not finite. Reuses its memory.
  /// Triangles that look the same way as the node are left out, too: those that would need `turn` (length by which unit normals
  /// change) or more, both theirs and that of a triangle at the node, before the scalar product of any two of them is negative.
  void update(std::span<const double> x, double radius, double turn);

  /// Outward unit normals of the triangles at the last update(); zero for a degenerate one.
  std::span<const Eigen::Vector3d> normals() const { return normal_; }

  /// The pair never touches (see above). Pure function of the reference configuration.
  bool is_excluded(int node, int triangle) const;

  std::span<const int> triangles_of(int node) const {
    return {triangle_.data() + start_[node], static_cast<std::size_t>(start_[node + 1] - start_[node])};
  }
  int first_pair(int node) const { return start_[node]; }
  int pair_count() const { return start_.back(); }

 private:
  struct View {
    Eigen::Vector3f axis;
    float cosine;
  };
  View view_of(int node, double turn) const;
  void find_exceptions();
  bool is_exception(int node, int triangle) const;
  bool is_same_face(int node, int triangle) const { return surface_.node_side[static_cast<std::size_t>(node)] == surface_.triangle_side[static_cast<std::size_t>(triangle)]; }

  const ContactSurface& surface_;
  float exclusion_squared_, exclusion_squared_through_;
  double exclusion_radius_, exclusion_radius_through_;
  // Rest positions in single precision: the exclusion rule must give the same answer wherever it is asked.
  std::vector<Eigen::Vector3f> rest_node_, rest_centre_;
  std::vector<int> exception_start_, exception_;  // per node: triangles within the radius that may touch nevertheless
  std::vector<int> start_, triangle_;             // result, per node
  // Scratch of update().
  BoxGrid grid_;
  std::vector<Eigen::Vector3d> centre_, normal_;
  std::vector<double> radius_;
  std::vector<float> cx_, cy_, cz_, reach_squared_, rx_, ry_, rz_, nx_, ny_, nz_;  // by grid position
  std::vector<int> side_;                                           // by grid position
  std::vector<std::vector<int>> found_;                             // per piece of nodes
};

}  // namespace mv
