// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// How far vertices that are near each other have moved relative to each other: leaflets that swing together keep their distances.

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "solver/contact/box_grid.h"

namespace mv {

class RelativeMotion {
 public:
  /// Sorts `vertices` by where they are in x (3 coordinates a vertex, m) into cells of at least `cell` (m).
  void place(std::span<const double> x, std::span<const int> vertices, double cell);

  /// A bound on |u_i - u_j| for every two vertices i, j that were closer than the cell's size; `u`: in the order of `vertices` (m).
  double bound(std::span<const Eigen::Vector3d> u);

 private:
  struct Box {
    Eigen::Array3d lower, upper;
  };
  BoxGrid grid_;
  std::vector<int> start_, item_;  // of the cells: positions in `vertices`
  std::vector<Box> box_, wide_;
};

}  // namespace mv
