// SPDX-License-Identifier: BSD-3-Clause
#include "solver/chordae/chordae_tension.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

namespace {

using mv::Vec3;

// Two roots, one branch point, two leaflet ends that share three nodes each.
mv::Chordae tree() {
  mv::Chordae c;
  c.points = {Vec3(0, 0, -30), Vec3(10, 0, -30), Vec3(0, 0, -10), Vec3(-2, 0, 0), Vec3(2, 0, 0), Vec3(8, 0, 0)};
  c.muscle_of_point = {0, 1, -1, -1, -1, -1};
  c.segments = {{0, 2, mv::ChordaKind::primary, 0, 1, 20, 0.4}, {2, 3, mv::ChordaKind::primary, 0, 1, 10, 0.2},
                {2, 4, mv::ChordaKind::primary, 0, 1, 10, 0.2}, {1, 5, mv::ChordaKind::secondary, 1, 2, 29, 0.8}};
  c.insertions = {{3, 0, 0.5}, {3, 1, 0.5}, {4, 1, 0.25}, {4, 2, 0.75}, {5, 3, 1.0}};
  return c;
}

// Nodes 0..3 of the leaflet, node 4 the branch point (m).
std::vector<double> positions(double lift) {
  std::vector<double> x{-3e-3, 0, 0, -1e-3, 0, 0, 3e-3, 0, 0, 8e-3, 0, 0, 0, 0, -10e-3};
  for (std::size_t i = 2; i < 12; i += 3) x[i] += lift;
  return x;
}
const std::vector<Vec3> tips{Vec3(0, 0, -30e-3), Vec3(10e-3, 0, -30e-3)};

TEST(ChordaeTension, one_straight_chorda_pulls_as_hooke_says_and_bears_no_compression) {
  mv::ChordaeTension chordae(tree(), 4, 20e6);
  std::vector<double> f(15, 0.0);
  chordae.forces(positions(2e-3), tips, f);
  const double length = std::hypot(2e-3, 32e-3);
  EXPECT_NEAR(chordae.tensions()[3], 20e6 * 0.8e-6 / 29e-3 * (length - 29e-3), 1e-12);
  EXPECT_NEAR(Vec3::Map(f.data() + 9).norm(), chordae.tensions()[3], 1e-12);
  EXPECT_LT(f[11], 0);
  f.assign(15, 0.0);
  chordae.forces(positions(-5e-3), tips, f);
  EXPECT_EQ(chordae.tensions()[3], 0.0);
  EXPECT_EQ(Vec3::Map(f.data() + 9).norm(), 0.0);
}

TEST(ChordaeTension, forces_balance_with_the_papillary_pull_and_moments_do_too) {
  mv::ChordaeTension chordae(tree(), 4, 20e6);
  const auto x = positions(3e-3);
  std::vector<double> f(15, 0.0);
  chordae.forces(x, tips, f);
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
  for (std::size_t i = 0; i < 5; ++i) {
    force += Vec3::Map(f.data() + 3 * i);
    moment += Vec3::Map(x.data() + 3 * i).cross(Vec3(Vec3::Map(f.data() + 3 * i)));
  }
  double scale = 0;
  for (std::size_t m = 0; m < 2; ++m) {
    force += chordae.papillary_forces()[m];
    moment += tips[m].cross(chordae.papillary_forces()[m]);
    scale += chordae.papillary_forces()[m].norm();
  }
  EXPECT_GT(scale, 1.0);
  EXPECT_LT(force.norm(), 1e-12 * scale);
  EXPECT_LT(moment.norm(), 1e-13 * scale);
}

TEST(ChordaeTension, force_is_minus_the_energy_gradient_and_stiffness_its_derivative) {
  mv::ChordaeTension chordae(tree(), 4, 20e6);
  auto x = positions(3e-3);
  x[12] = 0.4e-3;
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  std::vector<double> v(15), f(15, 0.0), kv(15, 0.0), ignored(15), plus(15, 0.0), minus(15, 0.0);
  for (double& a : v) a = normal(random);
  chordae.forces(x, tips, f);
  chordae.stiffness_times(x, tips, v, kv);
  const double step = 1e-8;
  auto moved = [&](double s) {
    auto y = x;
    for (std::size_t a = 0; a < 15; ++a) y[a] += s * v[a];
    return y;
  };
  const double e1 = chordae.forces(moved(step), tips, plus), e0 = chordae.forces(moved(-step), tips, minus);
  double power = 0, scale = 0;
  for (std::size_t a = 0; a < 15; ++a) power += f[a] * v[a];
  EXPECT_NEAR((e1 - e0) / (2 * step), -power, 1e-5 * std::abs(power));
  for (std::size_t a = 0; a < 15; ++a) scale = std::max(scale, std::abs(kv[a]));
  for (std::size_t a = 0; a < 15; ++a) EXPECT_NEAR((minus[a] - plus[a]) / (2 * step), kv[a], 1e-5 * scale);
}

}  // namespace
