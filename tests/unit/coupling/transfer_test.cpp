// SPDX-License-Identifier: BSD-3-Clause
#include "solver/coupling/transfer.h"

#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "geometry/core/parallel.h"

namespace {

using mv::Kernel;

mv::FluidGrid grid() {
  mv::FluidGrid g;
  g.n = {12, 10, 14};
  g.h = 0.5e-3;
  return g;
}

std::vector<double> points_inside(const mv::FluidGrid& g, int count, double margin = 2.6) {
  std::mt19937 random(5);
  std::vector<double> x;
  for (int q = 0; q < count; ++q)
    for (std::size_t a = 0; a < 3; ++a) {
      std::uniform_real_distribution<double> u(margin * g.h, (g.n[a] - margin) * g.h);
      x.push_back(u(random));
    }
  return x;
}

TEST(Kernel, moments_hold_at_every_offset) {
  for (int step = 0; step <= 100; ++step) {
    const double s = 3.0 + 0.01 * step;
    for (const auto& k : {mv::ib3_weights(s), mv::ib4_weights(s), mv::bspline2_weights(s), mv::bspline3_weights(s)}) {
      double zeroth = 0, first = 0;
      for (int i = 0; i < k.width; ++i) {
        zeroth += k.w[i];
        first += k.w[i] * (k.first + i - s);
        EXPECT_GE(k.w[i], -1e-15);
      }
      EXPECT_NEAR(zeroth, 1.0, 1e-14);
      EXPECT_NEAR(first, 0.0, 1e-13);
    }
    const auto k = mv::ib4_weights(s);
    EXPECT_NEAR(k.w[0] + k.w[2], 0.5, 1e-14);  // even-odd condition
    double squares4 = 0, squares3 = 0;
    for (int i = 0; i < 4; ++i) squares4 += k.w[i] * k.w[i];
    const auto k3 = mv::ib3_weights(s);
    for (int i = 0; i < 4; ++i) squares3 += k3.w[i] * k3.w[i];
    EXPECT_NEAR(squares4, 0.375, 1e-13);
    EXPECT_NEAR(squares3, 0.5, 1e-13);
  }
}

TEST(Transfer, spread_is_the_adjoint_of_interpolate_and_conserves_total_force) {
  const auto g = grid();
  std::vector<Eigen::Vector2d> circle;
  for (int i = 0; i < 60; ++i) circle.emplace_back(3e-3 + 2.4e-3 * std::cos(2 * M_PI * i / 60), 2.5e-3 + 2.1e-3 * std::sin(2 * M_PI * i / 60));
  for (bool has_wall : {false, true}) {
    const auto wall = mv::make_tube_wall(g, has_wall ? circle : std::vector<Eigen::Vector2d>{});
    for (Kernel kernel : {Kernel::ib3, Kernel::ib4, Kernel::cbs32}) {
      mv::Transfer transfer(g, wall, kernel);
      const auto x = points_inside(g, 400);
      std::vector<int> active(400);
      std::iota(active.begin(), active.end(), 0);
      ASSERT_EQ(transfer.bind(x, active), 0);
      std::mt19937 random(7);
      std::normal_distribution<double> normal;
      mv::FaceField u(g), f(g);
      for (auto& c : u.c)
        for (double& v : c) v = normal(random);
      std::vector<double> force(1200), velocity(1200);
      for (double& v : force) v = normal(random);
      transfer.interpolate(u, velocity);
      transfer.spread(force, f);
      const double points = std::inner_product(force.begin(), force.end(), velocity.begin(), 0.0);
      double cells = 0;
      for (std::size_t c = 0; c < 3; ++c) cells += std::inner_product(f.c[c].begin(), f.c[c].end(), u.c[c].begin(), 0.0);
      EXPECT_NEAR(cells * g.h * g.h * g.h, points, 1e-10 * std::abs(points) + 1e-10);
      if (!has_wall)
        for (std::size_t c = 0; c < 3; ++c) {
          double total = 0, given = 0;
          for (double v : f.c[c]) total += v * g.h * g.h * g.h;
          for (std::size_t q = c; q < 1200; q += 3) given += force[q];
          EXPECT_NEAR(total, given, 1e-10);
        }
    }
  }
}

TEST(Transfer, interpolates_linear_fields_exactly) {
  const auto g = grid();
  const auto wall = mv::make_tube_wall(g, {});
  for (Kernel kernel : {Kernel::ib3, Kernel::ib4, Kernel::cbs32}) {
    mv::Transfer transfer(g, wall, kernel);
    const auto x = points_inside(g, 50);
    std::vector<int> active(50);
    std::iota(active.begin(), active.end(), 0);
    transfer.bind(x, active);
    mv::FaceField u(g);
    const double slope[3] = {2, -3, 5};
    for (int c = 0; c < 3; ++c)
      for (int k = -2; k <= g.n[2] + 2; ++k)
        for (int j = -2; j <= g.n[1] + 2; ++j)
          for (int i = -2; i <= g.n[0] + 2; ++i) {
            const double p[3] = {i + (c == 0 ? 0 : 0.5), j + (c == 1 ? 0 : 0.5), k + (c == 2 ? 0 : 0.5)};
            u.c[static_cast<std::size_t>(c)][static_cast<std::size_t>(g.index(i, j, k))] = 1 + g.h * (slope[0] * p[0] + slope[1] * p[1] + slope[2] * p[2]);
          }
    std::vector<double> v(150);
    transfer.interpolate(u, v);
    for (std::size_t q = 0; q < 50; ++q) {
      const double expected = 1 + slope[0] * x[3 * q] + slope[1] * x[3 * q + 1] + slope[2] * x[3 * q + 2];
      for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(v[3 * q + c], expected, 1e-12);
    }
  }
}

TEST(Transfer, moved_points_interpolate_as_if_bound_anew_and_those_that_leave_are_counted) {
  const auto g = grid();
  for (Kernel kernel : {Kernel::ib3, Kernel::ib4, Kernel::cbs32}) {
    mv::Transfer moved(g, mv::make_tube_wall(g, {}), kernel), anew = moved;
    auto x = points_inside(g, 300);
    std::vector<int> active(300);
    std::iota(active.begin(), active.end(), 0);
    moved.bind(x, active);
    for (std::size_t a = 0; a < x.size(); ++a) x[a] += 0.7 * g.h * std::sin(static_cast<double>(a));  // into other rows and slabs
    EXPECT_EQ(moved.move_bound(x), 0);
    anew.bind(x, active);
    mv::FaceField u(g);
    for (auto& c : u.c)
      for (std::size_t q = 0; q < c.size(); ++q) c[q] = std::cos(0.1 * static_cast<double>(q * q % 1000));
    std::vector<double> by_move(900), by_bind(900);
    moved.interpolate(u, by_move);
    anew.interpolate(u, by_bind);
    EXPECT_EQ(by_move, by_bind);
    x[3] = -g.h;
    x[300] = std::nan("");
    EXPECT_EQ(moved.move_bound(x), 2);
  }
}

TEST(Transfer, spread_does_not_depend_on_the_thread_count) {
  const auto g = grid();
  const auto wall = mv::make_tube_wall(g, {});
  const auto x = points_inside(g, 3000);
  std::vector<int> active(3000);
  std::iota(active.begin(), active.end(), 0);
  std::vector<double> force(9000);
  for (std::size_t i = 0; i < force.size(); ++i) force[i] = std::sin(static_cast<double>(i));
  std::vector<double> first;
  for (int threads : {1, 2, 3}) {
    mv::set_thread_count(threads);
    mv::Transfer transfer(g, wall, Kernel::ib4);
    transfer.bind(x, active);
    mv::FaceField f(g);
    transfer.spread(force, f);
    if (first.empty()) first = f.c[1];
    else EXPECT_EQ(first, f.c[1]);
  }
  mv::set_thread_count(2);
}

TEST(Transfer, points_outside_the_box_are_counted_and_skipped) {
  const auto g = grid();
  mv::Transfer transfer(g, mv::make_tube_wall(g, {}), Kernel::ib4);
  const std::vector<double> x{-1, 0, 0, 3e-3, 2e-3, 3e-3, std::nan(""), 0, 0};
  EXPECT_EQ(transfer.bind(x, std::vector<int>{0, 1, 2}), 2);
}

}  // namespace
