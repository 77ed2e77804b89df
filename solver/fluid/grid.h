// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "geometry/core/parallel.h"

namespace mv {

/// Uniform staggered (MAC) grid of cubes. Cell (i,j,k), 0 <= i < n[0] ..., has its lower corner at lower + h (i,j,k).
/// All fields share one padded layout with `ghosts` layers on every side: component 0 of velocity at index (i,j,k) sits on the lower
/// x-face of cell (i,j,k), so that faces 0..n[0] exist; likewise for y and z. Pressure sits at cell centres. SI units, tube frame.
struct FluidGrid {
  static constexpr int ghosts = 2;

  std::array<int, 3> n{0, 0, 0};
  double h = 0;                                     // m
  Eigen::Vector3d lower = Eigen::Vector3d::Zero();  // m

  /// Padded extent along an axis (one more than the cells, for the last face).
  int padded(int axis) const { return n[static_cast<std::size_t>(axis)] + 1 + 2 * ghosts; }
  std::ptrdiff_t stride_y() const { return padded(0); }
  std::ptrdiff_t stride_z() const { return static_cast<std::ptrdiff_t>(padded(0)) * padded(1); }
  std::size_t padded_size() const { return static_cast<std::size_t>(stride_z()) * static_cast<std::size_t>(padded(2)); }
  std::ptrdiff_t index(int i, int j, int k) const {
    return (i + ghosts) + stride_y() * (j + ghosts) + stride_z() * (k + ghosts);
  }
  std::size_t cells() const {
    return static_cast<std::size_t>(n[0]) * static_cast<std::size_t>(n[1]) * static_cast<std::size_t>(n[2]);
  }
};

/// Three face-centred components in the padded layout of a FluidGrid.
struct FaceField {
  std::array<std::vector<double>, 3> c;

  FaceField() = default;
  explicit FaceField(const FluidGrid& grid) {
    for (auto& component : c) component.assign(grid.padded_size(), 0.0);
  }
  void set_zero() {
    for (auto& component : c)
      parallel_ranges(static_cast<std::ptrdiff_t>(component.size()), [&](std::ptrdiff_t begin, std::ptrdiff_t end, int) {
        std::fill(component.begin() + begin, component.begin() + end, 0.0);
      });
  }
};

/// What bounds the box on each side.
enum class BoundaryKind : int {
  wall,      // no slip, normal velocity zero; tangential velocity of the wall given
  open,      // pressure given, velocity free
  symmetry,  // normal velocity zero, no shear
  periodic,  // both sides of the axis
  inflow     // normal velocity given per face, may change in time (NavierStokes::set_inflow); tangential velocity zero
};

struct FluidBoundary {
  // [axis][0 lower, 1 upper]
  std::array<std::array<BoundaryKind, 2>, 3> side{{{BoundaryKind::wall, BoundaryKind::wall}, {BoundaryKind::wall, BoundaryKind::wall}, {BoundaryKind::open, BoundaryKind::open}}};
  std::array<std::array<Eigen::Vector3d, 2>, 3> wall_velocity{};  // m/s, used on walls
  FluidBoundary() {
    for (auto& axis : wall_velocity) axis = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  }
};

}  // namespace mv
