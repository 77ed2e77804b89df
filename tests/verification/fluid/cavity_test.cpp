// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "solver/fluid/navier_stokes.h"

// Lid-driven square cavity in the x-z plane, one periodic cell deep; side, lid speed and density are one. The lid slides along +x on top (z = 1).
namespace {

// Ghia, Ghia & Shin, J. Comput. Phys. 48 (1982) 387-411, tables I and II: u on x = 1/2 and w on z = 1/2. Computed there on 129 x 129 points, so they carry an error of
// their own: at Re 100 their extrema are 1.5 to 3.3 % short of the spectral ones below.
constexpr int ghia_count = 15;
constexpr std::array<double, ghia_count> ghia_z{0.9766, 0.9688, 0.9609, 0.9531, 0.8516, 0.7344, 0.6172, 0.5, 0.4531, 0.2813, 0.1719, 0.1016, 0.0703, 0.0625, 0.0547};
constexpr std::array<double, ghia_count> ghia_u_100{0.84123,  0.78871,  0.73722,  0.68717,  0.23151,  0.00332,  -0.13641, -0.20581,
                                                    -0.21090, -0.15662, -0.10150, -0.06434, -0.04775, -0.04192, -0.03717};
constexpr std::array<double, ghia_count> ghia_u_400{0.75837,  0.68439,  0.61756,  0.55892,  0.29093,  0.16256,  0.02135, -0.11477,
                                                    -0.17119, -0.32726, -0.24299, -0.14612, -0.10338, -0.09266, -0.08186};
constexpr std::array<double, ghia_count> ghia_x{0.9688, 0.9609, 0.9531, 0.9453, 0.9063, 0.8594, 0.8047, 0.5, 0.2344, 0.2266, 0.1563, 0.0938, 0.0781, 0.0703, 0.0625};
constexpr std::array<double, ghia_count> ghia_w_100{-0.05906, -0.07391, -0.08864, -0.10313, -0.16914, -0.22445, -0.24533, 0.05454,
                                                    0.17527,  0.17507,  0.16077,  0.12317,  0.10890,  0.10091,  0.09233};
// The entry at x = 0.9063 (-0.23827 in print) breaks the smoothness of the table by 0.1 and is left out here (NaN).
constexpr std::array<double, ghia_count> ghia_w_400{-0.12146, -0.15663, -0.19254, -0.22847, NAN,     -0.44993, -0.38598, 0.05186,
                                                    0.30174,  0.30203,  0.28124,  0.22965,  0.20920, 0.19713,  0.18360};
// Botella & Peyret, Comput. Fluids 27 (1998) 421-433, Re 100, Chebyshev collocation: extrema of u on x = 1/2 and of w on z = 1/2.
constexpr double spectral_u_min = -0.2140424, spectral_w_max = 0.1795728, spectral_w_min = -0.2538030;

struct Profile {
  std::vector<double> at, value;  // ends included

  // Cubic through the four nearest points.
  double operator()(double s) const {
    std::size_t first = 0;
    while (first + 4 < at.size() && at[first + 2] < s) ++first;
    if (first > 0 && at[first + 1] > s) --first;
    double sum = 0;
    for (std::size_t a = first; a < first + 4; ++a) {
      double weight = 1;
      for (std::size_t b = first; b < first + 4; ++b)
        if (b != a) weight *= (s - at[b]) / (at[a] - at[b]);
      sum += weight * value[a];
    }
    return sum;
  }
  double extremum(double sign) const {
    double best = -1e300;
    for (int i = 1; i < 4000; ++i) best = std::max(best, sign * (*this)(i / 4000.0));
    return sign * best;
  }
};

class Cavity {
 public:
  Cavity(int n, double reynolds) : solver_(make(n, reynolds)), state_(solver_.make_state()) {}

  // Runs until the velocity changes by less than `tolerance` a unit of time; returns the time it took.
  double run_until_steady(double tolerance) {
    const mv::FaceField no_force(solver_.grid());
    // The lid moves every wave; cells beside it are as fast as it is.
    const double h = solver_.grid().h;
    const double dt = 1 / (solver_.viscosity() * 6 / (0.4 * h * h) + 1 / (0.3 * h));
    double time = 0, rate = 1;
    std::array<std::vector<double>, 3> before = state_.velocity.c;
    constexpr double interval = 0.5;
    while (rate > tolerance && time < 120) {
      const int steps = static_cast<int>(std::ceil(interval / dt));
      for (int s = 0; s < steps; ++s) solver_.advance(state_, no_force, dt, {});
      time += steps * dt;
      rate = 0;
      for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t q = 0; q < before[c].size(); ++q) rate = std::max(rate, std::abs(state_.velocity.c[c][q] - before[c][q]) / (steps * dt));
      before = state_.velocity.c;
    }
    return time;
  }

  // Starts from the steady state of a coarser grid.
  void start_from(const Cavity& coarse) {
    const mv::FluidGrid &grid = solver_.grid(), &source = coarse.solver_.grid();
    const int ratio = grid.n[0] / source.n[0];
    for (int k = 0; k <= grid.n[2]; ++k)
      for (int i = 0; i <= grid.n[0]; ++i) {
        const auto to = static_cast<std::size_t>(grid.index(i, 0, k)), from = static_cast<std::size_t>(source.index(i / ratio, 0, k / ratio));
        for (std::size_t c : {0, 2}) state_.velocity.c[c][to] = coarse.state_.velocity.c[c][from];
        state_.pressure[to] = coarse.state_.pressure[from];
      }
  }

  Profile u_on_vertical() const {
    const mv::FluidGrid& grid = solver_.grid();
    Profile profile{{0}, {0}};
    for (int k = 0; k < grid.n[2]; ++k) {
      profile.at.push_back((k + 0.5) * grid.h);
      profile.value.push_back(state_.velocity.c[0][static_cast<std::size_t>(grid.index(grid.n[0] / 2, 0, k))]);
    }
    profile.at.push_back(1);
    profile.value.push_back(1);
    return profile;
  }
  Profile w_on_horizontal() const {
    const mv::FluidGrid& grid = solver_.grid();
    Profile profile{{0}, {0}};
    for (int i = 0; i < grid.n[0]; ++i) {
      profile.at.push_back((i + 0.5) * grid.h);
      profile.value.push_back(state_.velocity.c[2][static_cast<std::size_t>(grid.index(i, 0, grid.n[2] / 2))]);
    }
    profile.at.push_back(1);
    profile.value.push_back(0);
    return profile;
  }

 private:
  static mv::NavierStokes make(int n, double reynolds) {
    mv::FluidGrid grid;
    grid.n = {n, 1, n};
    grid.h = 1.0 / n;
    mv::FluidBoundary boundary;
    boundary.side = {{{mv::BoundaryKind::wall, mv::BoundaryKind::wall}, {mv::BoundaryKind::periodic, mv::BoundaryKind::periodic}, {mv::BoundaryKind::wall, mv::BoundaryKind::wall}}};
    boundary.wall_velocity[2][1] = {1, 0, 0};
    return mv::NavierStokes(grid, boundary, mv::make_tube_wall(grid, {}), 1.0, 1.0 / reynolds);
  }

  mv::NavierStokes solver_;
  mv::FlowState state_;
};

struct Lines {
  Profile u, w;
};

// Steady states on coarsest, twice and four times as many cells a side, each started from the one before.
std::array<Lines, 3> solve(double reynolds, int coarsest, double tolerance) {
  std::array<Lines, 3> lines;
  std::vector<Cavity> cavities;
  for (std::size_t level = 0; level < 3; ++level) {
    cavities.emplace_back(coarsest << level, reynolds);
    if (level > 0) cavities[level].start_from(cavities[level - 1]);
    const double time = cavities[level].run_until_steady(tolerance);
    std::printf("cavity, Re %g, %d cells a side: steady after a time of %.1f\n", reynolds, coarsest << level, time);
    lines[level] = {cavities[level].u_on_vertical(), cavities[level].w_on_horizontal()};
  }
  return lines;
}

// Root mean square difference of two solutions over both centre lines.
double difference(const Lines& a, const Lines& b) {
  double sum = 0;
  constexpr int points = 50;
  for (int i = 0; i < points; ++i) {
    const double s = (i + 0.5) / points;
    sum += std::pow(a.u(s) - b.u(s), 2) + std::pow(a.w(s) - b.w(s), 2);
  }
  return std::sqrt(sum / (2 * points));
}

double largest_difference(const Profile& profile, const std::array<double, ghia_count>& at, const std::array<double, ghia_count>& value) {
  double worst = 0;
  for (std::size_t i = 0; i < at.size(); ++i)
    if (!std::isnan(value[i])) worst = std::max(worst, std::abs(profile(at[i]) - value[i]));
  return worst;
}

double report_order(double reynolds, const std::array<Lines, 3>& lines) {
  const double coarse = difference(lines[0], lines[1]), fine = difference(lines[1], lines[2]);
  const double order = std::log2(coarse / fine);
  std::printf("cavity, Re %g: change of the centre lines from grid to grid %.2e %.2e, observed order %.2f; error left on the finest about %.1e\n", reynolds, coarse, fine, order, fine / 3);
  return order;
}

TEST(Cavity, re_100_reaches_the_spectral_extrema_with_second_order) {
  const auto lines = solve(100, 16, 2e-6);
  EXPECT_GT(report_order(100, lines), 1.8);
  const auto report = [&](const char* name, double reference, auto&& value) {
    std::array<double, 3> error{};
    for (std::size_t level = 0; level < 3; ++level) error[level] = std::abs(value(lines[level]) - reference);
    const double order = std::log2(error[0] / error[2]) / 2;
    std::printf("cavity, Re 100, %s: computed %.6f, reference %.6f, difference %.1e %.1e %.1e, order %.2f\n", name, value(lines[2]), reference, error[0], error[1], error[2], order);
    EXPECT_GT(order, 1.8) << name;
    EXPECT_LT(error[2], 2e-3) << name;
  };
  report("least u", spectral_u_min, [](const Lines& l) { return l.u.extremum(-1); });
  report("largest w", spectral_w_max, [](const Lines& l) { return l.w.extremum(1); });
  report("least w", spectral_w_min, [](const Lines& l) { return l.w.extremum(-1); });
  const double u = largest_difference(lines[2].u, ghia_z, ghia_u_100), w = largest_difference(lines[2].w, ghia_x, ghia_w_100);
  std::printf("cavity, Re 100, 64 cells a side: largest difference to Ghia et al. %.4f (u) %.4f (w)\n", u, w);
  EXPECT_LT(u, 0.01);
  EXPECT_LT(w, 0.01);
}

void expect_re_400(int coarsest, double tolerance, double least_order, double largest) {
  const auto lines = solve(400, coarsest, tolerance);
  EXPECT_GT(report_order(400, lines), least_order);
  const double u = largest_difference(lines[2].u, ghia_z, ghia_u_400), w = largest_difference(lines[2].w, ghia_x, ghia_w_400);
  std::printf("cavity, Re 400, %d cells a side: largest difference to Ghia et al. %.4f (u) %.4f (w); w at 0.9063 %.4f (printed -0.23827)\n", 4 * coarsest, u, w, lines[2].w(0.9063));
  std::printf("cavity, Re 400: least u %.5f (Ghia -0.32726), largest w %.5f (0.30203), least w %.5f (-0.44993)\n", lines[2].u.extremum(-1), lines[2].w.extremum(1), lines[2].w.extremum(-1));
  EXPECT_LT(u, largest);
  EXPECT_LT(w, largest);
}

// Sixteen cells do not resolve the shear layers of Re 400: the order of two shows on the finer grids of the long test.
TEST(Cavity, re_400_follows_the_published_centre_lines) { expect_re_400(16, 1e-5, 1.0, 0.007); }

TEST(Cavity, DISABLED_re_400_converges_with_second_order) { expect_re_400(32, 5e-6, 1.8, 0.01); }

}  // namespace
