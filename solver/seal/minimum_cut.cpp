// SPDX-License-Identifier: BSD-3-Clause
#include "solver/seal/minimum_cut.h"

#include <algorithm>
#include <cmath>

namespace mv::seal {

namespace {

/// One active cell with its neighbours in the packed list; -1 where there is none.
struct Cell {
  std::array<int, 3> next, previous;
  std::array<float, 3> weight, weight_previous;
  CutState state;
};

}  // namespace

CutProblem::CutProblem(std::array<int, 3> cells) : n(cells) {
  const std::size_t total = static_cast<std::size_t>(n[0]) * static_cast<std::size_t>(n[1]) * static_cast<std::size_t>(n[2]);
  state.assign(total, cut_empty);
  for (auto& w : weight) w.assign(total, 0.0f);
  start.assign(total, 0.0f);
}

CutResult solve_minimum_cut(const CutProblem& problem, double gap, int max_iterations) {
  std::vector<int> packed(problem.size(), -1);
  std::vector<std::size_t> cell_of;
  for (std::size_t c = 0; c < problem.size(); ++c)
    if (problem.state[c] != cut_empty) {
      packed[c] = static_cast<int>(cell_of.size());
      cell_of.push_back(c);
    }
  const std::array<std::size_t, 3> stride{1, static_cast<std::size_t>(problem.n[0]),
                                          static_cast<std::size_t>(problem.n[0]) * static_cast<std::size_t>(problem.n[1])};
  const std::size_t count = cell_of.size();
  std::vector<Cell> cells(count);
  for (std::size_t a = 0; a < count; ++a) {
    const std::size_t c = cell_of[a];
    cells[a].state = static_cast<CutState>(problem.state[c]);
    for (std::size_t k = 0; k < 3; ++k) {
      const int index = static_cast<int>(c / stride[k]) % problem.n[k];
      const int next = index + 1 < problem.n[k] ? packed[c + stride[k]] : -1;
      const int previous = index > 0 ? packed[c - stride[k]] : -1;
      cells[a].weight[k] = next >= 0 ? problem.weight[k][c] : 0.0f;
      cells[a].weight_previous[k] = previous >= 0 ? problem.weight[k][c - stride[k]] : 0.0f;
      cells[a].next[k] = cells[a].weight[k] > 0 ? next : -1;
      cells[a].previous[k] = cells[a].weight_previous[k] > 0 ? previous : -1;
    }
  }

  std::vector<float> u(count), ahead(count);
  for (std::size_t a = 0; a < count; ++a)
    u[a] = cells[a].state == cut_one ? 1.0f : cells[a].state == cut_zero ? 0.0f : problem.start[cell_of[a]];
  ahead = u;
  std::vector<std::array<float, 3>> p(count, {0, 0, 0});
  const float step = 1.0f / std::sqrt(12.0f);  // |K|^2 <= 12 for unit spacing and weights up to one

  const auto gradient = [&](std::size_t a, const std::vector<float>& f) {
    std::array<float, 3> g{0, 0, 0};
    for (std::size_t k = 0; k < 3; ++k)
      if (cells[a].next[k] >= 0) g[k] = cells[a].weight[k] * (f[static_cast<std::size_t>(cells[a].next[k])] - f[a]);
    return g;
  };
  const auto adjoint = [&](std::size_t a) {  // (K^T p) at a
    float s = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      s -= cells[a].weight[k] * p[a][k];
      if (cells[a].previous[k] >= 0) s += cells[a].weight_previous[k] * p[static_cast<std::size_t>(cells[a].previous[k])][k];
    }
    return s;
  };

  CutResult result;
  for (;; ++result.iterations) {
    if (result.iterations % 50 == 0) {
      result.area = result.lower = 0;
      for (std::size_t a = 0; a < count; ++a) {
        const auto g = gradient(a, u);
        result.area +=
            std::sqrt(static_cast<double>(g[0]) * g[0] + static_cast<double>(g[1]) * g[1] + static_cast<double>(g[2]) * g[2]);
        const double d = adjoint(a);
        if (cells[a].state == cut_one) result.lower += d;
        if (cells[a].state == cut_free) result.lower += std::min(0.0, d);
      }
      result.lower = std::max(0.0, result.lower);
      if (result.area - result.lower <= gap * result.area || result.iterations >= max_iterations) break;
    }
    for (std::size_t a = 0; a < count; ++a) {
      const auto g = gradient(a, ahead);
      std::array<float, 3>& q = p[a];
      for (std::size_t k = 0; k < 3; ++k) q[k] += step * g[k];
      const float length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2]);
      if (length > 1)
        for (float& x : q) x /= length;
    }
    for (std::size_t a = 0; a < count; ++a) {
      if (cells[a].state != cut_free) continue;
      const float fresh = std::clamp(u[a] - step * adjoint(a), 0.0f, 1.0f);
      ahead[a] = 2 * fresh - u[a];
      u[a] = fresh;
    }
  }
  result.density.assign(problem.size(), 0.0f);
  for (std::size_t a = 0; a < count; ++a) {
    const auto g = gradient(a, u);
    result.density[cell_of[a]] = std::sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
  }
  return result;
}

CutProblem coarsen(const CutProblem& fine) {
  CutProblem coarse({(fine.n[0] + 1) / 2, (fine.n[1] + 1) / 2, (fine.n[2] + 1) / 2});
  std::vector<float> members(coarse.size(), 0.0f);
  for (int k = 0; k < fine.n[2]; ++k)
    for (int j = 0; j < fine.n[1]; ++j)
      for (int i = 0; i < fine.n[0]; ++i) {
        const std::size_t f = fine.at(i, j, k), c = coarse.at(i / 2, j / 2, k / 2);
        const auto state = fine.state[f];
        if (state == cut_empty) continue;
        // A fixed cell fixes its group.
        if (coarse.state[c] < state) coarse.state[c] = state;
        coarse.start[c] += state == cut_one ? 1.0f : state == cut_zero ? 0.0f : fine.start[f];
        members[c] += 1;
        const std::array<int, 3> at{i, j, k};
        for (std::size_t d = 0; d < 3; ++d)
          if (at[d] % 2 == 1) coarse.weight[d][c] += 0.25f * fine.weight[d][f];
      }
  for (std::size_t c = 0; c < coarse.size(); ++c)
    if (members[c] > 0) coarse.start[c] /= members[c];
  return coarse;
}

}  // namespace mv::seal
