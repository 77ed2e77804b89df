// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Smallest surface that separates two sets of cells (continuous minimum cut; Strang 1983, Appleton & Talbot 2006):
//     minimise  sum over cells |grad u|,  (grad u)_k = w_k (u(next along k) - u),  u = 1 on one set, 0 on the other,
// with w_k the open share of the face. By the coarea formula the minimum is the least area of a separating surface, in units of a
// cell's face. Solved by the primal-dual method of Chambolle and Pock (2011). Internal to solver/seal.

#include <array>
#include <cstdint>
#include <vector>

namespace mv::seal {

enum CutState : std::uint8_t { cut_empty = 0, cut_free = 1, cut_one = 2, cut_zero = 3 };

struct CutProblem {
  std::array<int, 3> n{0, 0, 0};
  std::vector<std::uint8_t> state;           // CutState per cell, x fastest
  std::array<std::vector<float>, 3> weight;  // open share of the face towards the next cell, per direction
  std::vector<float> start;                  // first guess of u

  explicit CutProblem(std::array<int, 3> cells);
  std::size_t size() const { return state.size(); }
  std::size_t at(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * static_cast<std::size_t>(n[1]) + static_cast<std::size_t>(j)) *
               static_cast<std::size_t>(n[0]) +
           static_cast<std::size_t>(i);
  }
};

struct CutResult {
  double area = 0;             // primal value: the area of a separating surface, an upper bound of the least one (cell faces)
  double lower = 0;            // dual value: no surface is smaller
  std::vector<float> density;  // |grad u| per cell: where the surface lies
  int iterations = 0;
};

/// Stops when (area - lower) <= gap * area or after max_iterations; the caller judges the gap.
CutResult solve_minimum_cut(const CutProblem& problem, double gap, int max_iterations);

/// Pairs of cells, so that a problem too large is solved on cells twice as wide; face weights are averaged.
CutProblem coarsen(const CutProblem& problem);

}  // namespace mv::seal
