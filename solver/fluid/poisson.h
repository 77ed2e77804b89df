// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Pressure Poisson equation on the whole box by fast diagonalisation (Lynch, Rice & Thomas 1964): the one-dimensional operators in x
// and y are diagonalised once; every solve is two dense products a slab each way and one tridiagonal solve along z for every pair of
// modes. Exact to round-off for any mixture of Neumann, Dirichlet and periodic sides, any sizes, no transform library.

#include <Eigen/Core>
#include <array>
#include <vector>

#include "solver/fluid/grid.h"

namespace mv {

/// Condition on one side of an axis, for the cell-centred Laplacian.
enum class PoissonSide { neumann, dirichlet_at_face, periodic };

class PoissonSolver {
 public:
  /// `cells` cells of edge h (m); sides[axis] = {lower, upper}. Periodic must be given on both sides of an axis.
  PoissonSolver(std::array<int, 3> cells, double h, std::array<std::array<PoissonSide, 2>, 3> sides);

  /// Solves lap(phi) = rhs in place: `values` holds rhs (unpadded, x fastest) on entry and phi on return. Dirichlet values are
  /// homogeneous: move given values to the right-hand side with dirichlet_weight() first. Without a Dirichlet side the mean of
  /// phi is zero and the mean of rhs is ignored. No allocation.
  void solve(std::vector<double>& values);

  /// Coefficient of a boundary value at a Dirichlet face in the Laplacian of the adjacent cell: 2/h^2.
  double dirichlet_weight() const { return 2.0 / (h_ * h_); }

 private:
  std::array<int, 3> n_;
  double h_;
  bool is_singular_ = false;
  bool z_periodic_ = false;
  Eigen::MatrixXd qx_, qy_;         // eigenvectors, columns
  std::vector<double> lambda_;      // nx*ny, eigenvalue sums (1/m2)
  std::vector<double> pivot_;       // nz*nx*ny, inverse pivots of the tridiagonal solve
  std::vector<double> lower_z_;     // sub/super-diagonal is 1/h^2 everywhere
  Eigen::MatrixXd qz_;              // used instead of the tridiagonal solve when z is periodic
  Eigen::VectorXd lambda_z_;
  std::vector<Eigen::MatrixXd> scratch_;  // one a thread
  std::vector<double> work_;
};

}  // namespace mv
