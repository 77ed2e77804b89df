// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Adjoint transfer between Lagrangian points and the staggered grid (Peskin 2002):
//   interpolate: U_q = sum_x u(x) phi_h(x - X_q) ,   spread: f(x) = sum_q F_q phi_h(x - X_q) / h^3 ,
// so that sum_q F_q . U_q = h^3 sum_x f . u to round-off. Faces outside the tube take no part in either direction.

#include <span>
#include <vector>

#include "solver/coupling/kernel.h"
#include "solver/fluid/grid.h"
#include "solver/fluid/tube_wall.h"

namespace mv {

class Transfer {
 public:
  Transfer(const FluidGrid& grid, const TubeWall& wall, Kernel kernel);

  /// Sorts the points into rows of cells along x; must be called when positions changed. `positions`: xyz interleaved (m, tube frame), only the
  /// points listed in `active` take part. Points whose kernel leaves the box are skipped; their number is returned.
  int bind(std::span<const double> positions, std::span<const int> active);

  /// New positions of the bound points for interpolate() alone: they keep their order, spread() needs another bind(). Returns the number of points whose kernel
  /// leaves the box now; they keep their old positions.
  int move_bound(std::span<const double> positions);

  /// velocities[3*i..] of the bound points from the grid (m/s); other entries are left alone.
  void interpolate(const FaceField& velocity, std::span<double> velocities) const;

  /// Adds the point forces (N) of the bound points to the force density (N/m3). The result does not depend on the thread count.
  void spread(std::span<const double> forces, FaceField& force_density) const;

  const FluidGrid& grid() const { return grid_; }

  /// Cells over which the kernel reaches at most.
  double kernel_reach() const;

  /// The velocity max(s, 0) (s in cells) as the kernel interpolates it at s, mean over the places of the grid.
  double smeared_ramp(double s) const;

 private:
  template <Kernel K>
  static double smeared_ramp_with(double s);
  template <Kernel K>
  void interpolate_with(const FaceField& velocity, std::span<double> velocities) const;
  template <Kernel K>
  void spread_with(std::span<const double> forces, FaceField& force_density) const;

  FluidGrid grid_;
  std::array<std::vector<double>, 3> open_;  // per component, 2-D masks
  bool has_wall_;
  Kernel kernel_;
  std::vector<int> order_;                   // bound points sorted by row of cells: neighbours share cache lines
  std::vector<int> row_end_;                 // of each row of cells (y + ny z): where its points end in order_
  std::vector<int> row_of_;                  // scratch of bind()
  std::vector<double> scaled_;               // positions of order_ in cells, xyz interleaved
};

}  // namespace mv
