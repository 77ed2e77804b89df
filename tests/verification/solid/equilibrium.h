// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Static equilibrium of the solver's own nodal forces under linear constraints, by Newton's method with a direct solve.
//
//   x_n = base_n + sum over shares of node n  direction q_unknown,        T^T f(x(q)) = 0.
//
// The tangent is taken from central differences of the forces, many columns at once (those that share no row), so that nothing but the
// forces of the solver enters.

#include <functional>
#include <span>
#include <vector>

#include "verification/solid/box_mesh.h"

namespace mv::test {

class Constraints {
 public:
  /// No node moves until unknowns are given. `base`: 3 n, where the nodes are when all unknowns are zero.
  explicit Constraints(std::vector<double> base);

  int add_unknown() { return unknowns_++; }
  void share(int node, int unknown, const Vec3& direction) { shares_[static_cast<std::size_t>(node)].push_back({unknown, direction}); }
  /// Node moves freely but not along any of the `normals` (any number, need not be orthogonal).
  void free_except(int node, std::span<const Vec3> normals);
  /// Nodes of the same (x, z) lattice position move together in x and z and keep their y: plane strain of a slab.
  void plane_strain(const BoxMesh& box, const std::function<std::vector<Vec3>(int)>& normals_of_node);

  int count() const { return unknowns_; }
  std::vector<double> positions(std::span<const double> q) const;
  std::vector<double> reduced(std::span<const double> f) const;
  std::vector<std::vector<int>> unknowns_of_elements(const SolidMesh& mesh) const;

 private:
  struct Share {
    int unknown;
    Vec3 direction;
  };
  std::vector<double> base_;
  std::vector<std::vector<Share>> shares_;
  int unknowns_ = 0;
};

struct Equilibrium {
  std::vector<double> q, x;
  double residual = 0;   // N, largest entry of T^T f
  int iterations = 0;
  bool is_converged = false;
};

/// `forces` adds all nodal forces at x (those of loads, too). `length`: m, size of the smallest elements (sets the difference step);
/// `tolerance`: N, on the largest entry of the residual.
Equilibrium solve(const Constraints& constraints, const SolidMesh& mesh,
                  const std::function<void(std::span<const double>, std::span<double>)>& forces, double length, double tolerance,
                  std::vector<double> start = {});

}  // namespace mv::test
