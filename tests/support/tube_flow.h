// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Set-up shared by the tests of flow in straight tubes with elliptic cross-section.

#include <algorithm>
#include <cmath>
#include <vector>

#include "solver/fluid/navier_stokes.h"

namespace mv::test {

/// Grid with `cells_across` cells over the width 2 a of the tube, its axis `offset` cells (0.7 `offset` in y) off a grid corner.
inline FluidGrid tube_grid(double a, int cells_across, double offset, int cells_along) {
  FluidGrid grid;
  grid.h = 2 * a / cells_across;
  grid.n = {cells_across + 6, cells_across + 6, cells_along};
  grid.lower = {-0.5 * grid.n[0] * grid.h + offset * grid.h, -0.5 * grid.n[1] * grid.h + 0.7 * offset * grid.h, 0};
  return grid;
}

/// Polygon of the ellipse's area: with corners on the ellipse, its smaller width alone would cost 5e-6 of the velocity.
inline std::vector<Eigen::Vector2d> ellipse_section(double a, double b) {
  constexpr int corners = 1440;
  const double angle = 2 * M_PI / corners, scale = std::sqrt(angle / std::sin(angle));
  std::vector<Eigen::Vector2d> section;
  for (int i = 0; i < corners; ++i) section.emplace_back(scale * a * std::cos(angle * i), scale * b * std::sin(angle * i));
  return section;
}

/// Calls body(x, y, index) for the w faces of plane k that are open.
template <class Body>
void for_open_faces(const NavierStokes& solver, int k, Body&& body) {
  const FluidGrid& grid = solver.grid();
  for (int j = 0; j < grid.n[1]; ++j)
    for (int i = 0; i < grid.n[0]; ++i)
      if (solver.wall().stencil[2].open[static_cast<std::size_t>((i + FluidGrid::ghosts) + grid.padded(0) * (j + FluidGrid::ghosts))] > 0)
        body(grid.lower.x() + (i + 0.5) * grid.h, grid.lower.y() + (j + 0.5) * grid.h, static_cast<std::size_t>(grid.index(i, j, k)));
}

/// Sets the velocity to w(x, y) inside the tube and the pressure to fall linearly from `drop` to zero.
template <class Profile>
void start_from(const NavierStokes& solver, FlowState& state, double drop, Profile&& w) {
  const FluidGrid& grid = solver.grid();
  for (int k = 0; k <= grid.n[2]; ++k) for_open_faces(solver, k, [&](double x, double y, std::size_t p) { state.velocity.c[2][p] = w(x, y); });
  for (int k = 0; k < grid.n[2]; ++k)
    for (int j = 0; j < grid.n[1]; ++j)
      for (int i = 0; i < grid.n[0]; ++i) state.pressure[static_cast<std::size_t>(grid.index(i, j, k))] = drop * (1 - (k + 0.5) / grid.n[2]);
  state.boundary_pressure[2][0] = drop;
}

/// Volume flow (m3/s) through the open faces of plane k.
inline double open_flow(const NavierStokes& solver, const FlowState& state, int k) {
  double sum = 0;
  for_open_faces(solver, k, [&](double, double, std::size_t p) { sum += state.velocity.c[2][p]; });
  return sum * solver.grid().h * solver.grid().h;
}

inline double observed_order(double coarse, double fine, double ratio = 2.0) { return std::log(coarse / fine) / std::log(ratio); }

}  // namespace mv::test
