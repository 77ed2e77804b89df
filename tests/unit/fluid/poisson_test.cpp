// SPDX-License-Identifier: BSD-3-Clause
#include "solver/fluid/poisson.h"

#include <gtest/gtest.h>

#include <random>

namespace {

using mv::PoissonSide;
using Sides = std::array<std::array<PoissonSide, 2>, 3>;

// Residual of the discrete Laplacian, applied the slow obvious way.
double residual(const std::array<int, 3>& n, double h, const Sides& sides, const std::vector<double>& phi, const std::vector<double>& rhs) {
  auto at = [&](int i, int j, int k) { return phi[static_cast<std::size_t>(i + n[0] * (j + n[1] * k))]; };
  double worst = 0, largest = 0;
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i) {
        const std::array<int, 3> here{i, j, k};
        double lap = 0;
        for (std::size_t axis = 0; axis < 3; ++axis)
          for (std::size_t side = 0; side < 2; ++side) {
            std::array<int, 3> next = here;
            next[axis] += side == 0 ? -1 : 1;
            const bool is_outside = next[axis] < 0 || next[axis] >= n[axis];
            if (!is_outside) lap += at(next[0], next[1], next[2]) - at(i, j, k);
            else if (sides[axis][side] == PoissonSide::dirichlet_at_face) lap -= 2 * at(i, j, k);
            else if (sides[axis][side] == PoissonSide::periodic) {
              next[axis] = (next[axis] + n[axis]) % n[axis];
              lap += at(next[0], next[1], next[2]) - at(i, j, k);
            }
          }
        const double r = rhs[static_cast<std::size_t>(i + n[0] * (j + n[1] * k))];
        worst = std::max(worst, std::abs(lap / (h * h) - r));
        largest = std::max(largest, std::abs(r));
      }
  return worst / largest;
}

TEST(Poisson, solves_to_round_off_for_every_mixture_of_sides) {
  const auto N = PoissonSide::neumann, D = PoissonSide::dirichlet_at_face, P = PoissonSide::periodic;
  const std::vector<Sides> cases{Sides{{{N, N}, {N, N}, {D, D}}}, Sides{{{N, N}, {N, N}, {N, N}}}, Sides{{{P, P}, {N, D}, {D, N}}},
                                 Sides{{{P, P}, {P, P}, {P, P}}}, Sides{{{D, D}, {D, N}, {P, P}}}};
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (const auto& sides : cases) {
    for (const std::array<int, 3> n : {std::array<int, 3>{7, 9, 11}, std::array<int, 3>{16, 2, 5}}) {
      const double h = 1e-3;
      mv::PoissonSolver solver(n, h, sides);
      std::vector<double> rhs(static_cast<std::size_t>(n[0] * n[1] * n[2]));
      for (double& r : rhs) r = normal(random);
      bool is_singular = true;
      for (const auto& axis : sides)
        for (auto side : axis) is_singular = is_singular && side != D;
      if (is_singular) {
        double mean = 0;
        for (double r : rhs) mean += r / static_cast<double>(rhs.size());
        for (double& r : rhs) r -= mean;
      }
      std::vector<double> phi = rhs;
      solver.solve(phi);
      EXPECT_LT(residual(n, h, sides, phi, rhs), 1e-10);
    }
  }
}

}  // namespace
