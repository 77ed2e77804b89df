// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Sparse>
#include <Eigen/SparseLU>
#include <array>

#include "support/tube_flow.h"
#include "verification/fluid/oscillating_tube.h"

// The viscous stencil at the embedded wall alone: steady or periodic flow along the tube from one direct solve of the discrete equations, so that grids fine enough
// for the asymptotic order cost little.
namespace {

struct Errors {
  double velocity = 0, flow = 0;  // relative: root mean square, volume flow
};

// Solves sum of weights (neighbour - centre)/h2 - shift w = -source, with w = `exact` as the answer of the continuous problem; real, or complex amplitudes.
template <class Scalar, class Exact, class Source>
Errors solve_errors(double a, double b, int cells_across, double offset, Scalar exact_flow, Scalar shift, Exact&& exact, Source&& source) {
  const mv::FluidGrid grid = mv::test::tube_grid(a, cells_across, offset, 1);
  const mv::TubeWall wall = mv::make_tube_wall(grid, mv::test::ellipse_section(a, b));
  const mv::WallStencil& stencil = wall.stencil[2];
  const std::array<std::ptrdiff_t, 4> step{-1, 1, -grid.padded(0), grid.padded(0)};
  std::vector<int> unknown(stencil.open.size(), -1);
  int count = 0;
  for (std::size_t p = 0; p < unknown.size(); ++p)
    if (stencil.open[p] > 0) unknown[p] = count++;
  std::vector<Eigen::Triplet<Scalar>> entries;
  Eigen::Matrix<Scalar, Eigen::Dynamic, 1> rhs(count), answer(count);
  for (std::size_t p = 0; p < unknown.size(); ++p) {
    if (unknown[p] < 0) continue;
    Scalar diagonal = -shift;
    for (std::size_t d = 0; d < 4; ++d) {
      const double weight = stencil.weight[d][p] / (grid.h * grid.h);
      diagonal -= weight;
      const int other = unknown[static_cast<std::size_t>(static_cast<std::ptrdiff_t>(p) + step[d])];
      if (other >= 0) entries.emplace_back(unknown[p], other, Scalar(weight));
    }
    entries.emplace_back(unknown[p], unknown[p], diagonal);
    const int i = static_cast<int>(p) % grid.padded(0) - mv::FluidGrid::ghosts, j = static_cast<int>(p) / grid.padded(0) - mv::FluidGrid::ghosts;
    const double x = grid.lower.x() + (i + 0.5) * grid.h, y = grid.lower.y() + (j + 0.5) * grid.h;
    rhs[unknown[p]] = -source(x, y);
    answer[unknown[p]] = exact(x, y);
  }
  Eigen::SparseMatrix<Scalar> matrix(count, count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SparseLU<Eigen::SparseMatrix<Scalar>> lu(matrix);
  const Eigen::Matrix<Scalar, Eigen::Dynamic, 1> w = lu.solve(rhs);
  return {(w - answer).norm() / answer.norm(), std::abs(w.sum() * (grid.h * grid.h) / exact_flow - 1.0)};
}

constexpr std::array<int, 5> cells{8, 16, 32, 64, 128};
constexpr std::array<double, 5> offsets{0.0, 0.13, 0.31, 0.47, 0.5};

// Largest error over the offsets, on each grid.
template <class Run>
std::array<Errors, 5> worst_of_offsets(Run&& run) {
  std::array<Errors, 5> worst;
  for (std::size_t level = 0; level < cells.size(); ++level)
    for (double offset : offsets) {
      const Errors e = run(cells[level], offset);
      worst[level].velocity = std::max(worst[level].velocity, e.velocity);
      worst[level].flow = std::max(worst[level].flow, e.flow);
    }
  return worst;
}

void print(const char* name, double b, const std::array<Errors, 5>& e) {
  std::printf("%s, half axes 1 and %.1f, worst of %zu offsets:", name, b, offsets.size());
  for (std::size_t level = 0; level < cells.size(); ++level)
    std::printf(" %d across %.2e (flow %.2e)%s", cells[level], e[level].velocity, e[level].flow, level + 1 < cells.size() ? "," : "\n");
  std::printf("  order of the velocity");
  for (std::size_t level = 0; level + 1 < cells.size(); ++level) std::printf(" %.2f", mv::test::observed_order(e[level].velocity, e[level + 1].velocity));
  std::printf(", of the flow over all %.2f\n", mv::test::observed_order(e.front().flow, e.back().flow, 16));
}

TEST(WallStencil, quartic_profile_converges_with_second_order) {
  for (double b : {1.0, 0.8}) {
    const auto e = worst_of_offsets([&](int cells_across, double offset) {
      return solve_errors(
          1.0, b, cells_across, offset, M_PI * b * 2 / 3, 0.0, [&](double x, double y) { return 1 - std::pow(x * x + y * y / (b * b), 2); },
          [&](double x, double y) { return 8 * (x * x + y * y / std::pow(b, 4)) + 4 * (x * x + y * y / (b * b)) * (1 + 1 / (b * b)); });
    });
    print("quartic profile", b, e);
    // The error is c2 h2 - c3 h3, the second term from the wall, where the third difference is not exact: the order rises towards two from below.
    EXPECT_GT(mv::test::observed_order(e[0].velocity, e[2].velocity, 4), 1.75);
    EXPECT_GT(mv::test::observed_order(e[2].velocity, e[4].velocity, 4), 1.93);
    EXPECT_GT(mv::test::observed_order(e[0].flow, e[4].flow, 16), 1.9);
    EXPECT_LT(e[4].velocity, 3e-4);
  }
}

TEST(WallStencil, parabola_is_exact_but_for_faces_within_a_few_hundredths_of_a_cell_of_the_wall) {
  for (double b : {1.0, 0.8}) {
    const double peak = b * b / (2 * (1 + b * b));
    const auto e = worst_of_offsets([&](int cells_across, double offset) {
      return solve_errors(
          1.0, b, cells_across, offset, M_PI * b * peak / 2, 0.0, [&](double x, double y) { return peak * (1 - x * x - y * y / (b * b)); }, [](double, double) { return 1.0; });
    });
    print("parabola", b, e);
    EXPECT_LT(e[0].velocity, 3e-3);
    EXPECT_LT(e[1].velocity, 7e-4);
    EXPECT_LT(e[4].velocity, 3e-5);
    EXPECT_LT(e[4].flow, 1e-4);
  }
}

// The frequency domain of tests/verification/fluid/oscillating_tube_test.cpp, on grids its time steps could not afford.
TEST(WallStencil, womersley_flow_converges_with_second_order) {
  for (double alpha : {3.0, 10.0})
    for (double offset : {0.13, 0.31}) {
      mv::test::OscillatingTube tube;
      tube.frequency = alpha * alpha;
      constexpr std::array<int, 5> finer{16, 32, 64, 128, 256};
      std::array<Errors, 5> e;
      for (std::size_t level = 0; level < finer.size(); ++level)
        e[level] = solve_errors(
            1.0, 1.0, finer[level], offset, mv::test::womersley_flow(tube), std::complex<double>(0, tube.frequency),
            [&](double x, double y) { return mv::test::womersley_velocity(tube, std::hypot(x, y)); }, [](double, double) { return 1.0; });
      std::printf("Womersley, alpha %g, offset %.2f: relative velocity error", alpha, offset);
      for (const Errors& error : e) std::printf(" %.2e", error.velocity);
      std::printf(" (16 to 256 cells across), order");
      for (std::size_t level = 0; level + 1 < e.size(); ++level) std::printf(" %.2f", mv::test::observed_order(e[level].velocity, e[level + 1].velocity));
      std::printf("; flow %.2e .. %.2e, order %.2f over all\n", e.front().flow, e.back().flow, mv::test::observed_order(e.front().flow, e.back().flow, 16));
      // The thinner the layer at the wall, sqrt(2 mu / (rho omega)), the later the asymptotic order.
      EXPECT_GT(mv::test::observed_order(e[3].velocity, e[4].velocity), alpha < 5 ? 1.95 : 1.9);
    }
}

}  // namespace
