// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Keeps leaflets inside the tube. Near the wall kernels are cut off and what leaflets do unseen by the blood (relaxation, slip) is not held back by it, so that blood
// alone does not stop a leaflet that is pressed to the wall: coarse open valves went 3 mm into it within two beats. Nodes may touch the wall, frictionless, not pass it.

#include <Eigen/Core>
#include <span>
#include <vector>

namespace mv {

class WallLimit {
 public:
  /// `section`: closed polygon of the tube (m, tube frame, either orientation, at least three points), extruded along z. `rest`: 3 per node (m); a node that lies outside at
  /// rest (the thickness of a leaflet at the annulus) may stay as far outside as there. Nodes with `is_fixed` are left alone. Throws InputError on sizes that do not match.
  WallLimit(std::vector<Eigen::Vector2d> section, std::span<const double> rest, std::span<const char> is_fixed);

  /// Moves nodes that are further outside than they may be straight back to their limit (x: 3 per node, m, finite).
  void apply(std::span<double> x);

  /// Nodes moved by the last apply(), ascending, and by how much (m).
  std::span<const int> moved() const { return moved_; }
  std::span<const Eigen::Vector3d> shifts() const { return shifts_; }

 private:
  struct Nearest {
    double outside = 0;       // m, positive outside the section, negative inside
    Eigen::Vector2d on_wall = Eigen::Vector2d::Zero();
  };
  Nearest nearest(const Eigen::Vector2d& p) const;
  /// Index of the cell with p, -1 outside the cells.
  std::ptrdiff_t cell_of(const Eigen::Vector2d& p) const;

  std::vector<Eigen::Vector2d> section_;
  Eigen::Vector2d lower_ = Eigen::Vector2d::Zero();
  double width_ = 0;                           // m, of a cell
  Eigen::Vector2i cells_ = Eigen::Vector2i::Zero();
  std::vector<std::vector<int>> edges_;        // per cell: edges that can be the nearest of a point in it; none when all of the cell is inside
  std::vector<int> all_edges_;
  std::vector<double> allowed_;                // m, per node; infinite when fixed
  std::vector<char> is_beyond_;                // per node, of the last apply()
  std::vector<int> moved_;
  std::vector<Eigen::Vector3d> shifts_;
};

}  // namespace mv
