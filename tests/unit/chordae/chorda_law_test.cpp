// SPDX-License-Identifier: BSD-3-Clause
#include "solver/chordae/chorda_law.h"

#include <gtest/gtest.h>

#include <cmath>

#include "solver/chordae/chordae_tension.h"

namespace {

using namespace mv;

ChordaLaw ogden(std::array<double, 3> mu, std::array<double, 3> alpha) {
  ChordaLaw law;
  law.is_ogden = true;
  law.mu = mu;
  law.alpha = alpha;
  limit_stiffening(law);
  return law;
}

/// The laws of the Texas TriValve deck: anterior, posterior, septal (two exponents near zero).
const ChordaLaw measured[] = {ogden({18.884e6, 22.683e6, 19.503e6}, {98.2537, 98.2519, 98.2532}), ogden({4.24155e6, 2.7248e6, 37.27}, {55.9149, 55.9155, 70.7151}),
                              ogden({33.7535e6, 14.6, 20343}, {1.5317e-4, 3.488e-4, 113.447})};

TEST(chorda_law, stress_is_the_slope_of_energy_and_tangent_that_of_stress) {
  constexpr double h = 1e-6;
  for (const ChordaLaw& law : measured)
    for (const double l : {1.0005, 1.003, 1.01, 1.02, 1.2, 1.5}) {
      const ChordaResponse at = chorda_response(law, l), up = chorda_response(law, l + h), down = chorda_response(law, l - h);
      EXPECT_NEAR((up.energy - down.energy) / (2 * h), at.stress, 1e-6 * at.stress + 1) << l;
      EXPECT_NEAR((up.stress - down.stress) / (2 * h), at.tangent, 1e-5 * at.tangent) << l;
    }
}

TEST(chorda_law, closed_forms) {
  // alpha = 2: neo-Hookean, P = mu (l - 1/l^2), W = mu/2 (l^2 + 2/l - 3)
  const ChordaLaw neo = ogden({1e6, 0, 0}, {2, 1, 1});
  for (const double l : {1.0, 1.01, 1.3, 1.9}) {
    EXPECT_NEAR(chorda_response(neo, l).stress, 1e6 * (l - 1 / (l * l)), 1e-6);
    EXPECT_NEAR(chorda_response(neo, l).energy, 0.5e6 * (l * l + 2 / l - 3), 1e-6);
  }
  // alpha -> 0: P = 3 mu ln(l) / l, W = 3/2 mu ln(l)^2
  const ChordaLaw logarithmic = ogden({1e6, 0, 0}, {1e-9, 1, 1});
  for (const double l : {1.001, 1.1}) {
    EXPECT_NEAR(chorda_response(logarithmic, l).stress, 3e6 * std::log(l) / l, 1e-3);
    EXPECT_NEAR(chorda_response(logarithmic, l).energy, 1.5e6 * std::pow(std::log(l), 2), 1e-3);
  }
  EXPECT_NEAR(chorda_response(measured[0], 1).tangent, 3 * (18.884e6 + 22.683e6 + 19.503e6), 1);
}

TEST(chorda_law, stiffening_is_bounded_where_chordae_tear) {
  for (const ChordaLaw& law : measured) {
    const double rest = chorda_response(law, 1).tangent;
    for (double l = 1; l < 1.6; l += 0.01) EXPECT_LE(chorda_response(law, l).tangent, stiffening_limit * rest * (1 + 1e-9));
    EXPECT_TRUE(defects(law).empty());
  }
  // 2 (alpha - 1)/alpha l^(alpha - 2) = 3 * 10 with alpha = 98.25 (the second term has died out)
  EXPECT_NEAR(measured[0].limit_stretch, std::exp(std::log(15 * 98.25 / 97.25) / 96.25), 1e-3);
  std::printf("anterior: followed to a strain of %.3f and %.1f MPa\n", measured[0].limit_stretch - 1, 1e-6 * chorda_response(measured[0], measured[0].limit_stretch).stress);
}

TEST(chorda_law, unusable_laws_are_named) {
  EXPECT_FALSE(defects(ogden({-1e6, 0, 0}, {2, 1, 1})).empty());
  EXPECT_FALSE(defects(ogden({1e6, 0, 0}, {0, 1, 1})).empty());
  EXPECT_FALSE(defects(ogden({2e6, -1.5e6, 0}, {2, 8, 1})).empty());  // softens
  ChordaLaw linear;
  linear.youngs_modulus = 0;
  EXPECT_FALSE(defects(linear).empty());
}

/// A branched tree under any deformation: force = -dE/dx, K v = -dF/dx v.
TEST(chorda_law, tree_forces_are_slopes_of_its_energy) {
  Chordae c;
  c.points = {Vec3(0, 0, 0), Vec3(0, 0, 10), Vec3(3, 0, 15), Vec3(-3, 0, 15)};
  c.muscle_of_point = {0, -1, -1, -1};
  auto segment = [](int a, int b, int leaflet, double rest) {
    ChordaSegment s;
    s.a = a, s.b = b, s.leaflet = leaflet, s.rest_length = rest, s.area = 0.3;
    return s;
  };
  c.segments = {segment(0, 1, 1, 9.95), segment(1, 2, 2, 5.8), segment(1, 3, 3, 5.82)};
  c.insertions = {{2, 0, 0.5}, {2, 1, 0.5}, {3, 2, 1.0}};
  ChordaeTension tree(c, 3, [](int leaflet) { return measured[leaflet % 3]; });
  std::vector<double> x{3.05e-3, 1e-4, 15e-3, 2.95e-3, 0, 15.02e-3, -3e-3, 0, 15.01e-3, 1e-5, 2e-5, 10.01e-3}, f(12, 0.0);
  const std::vector<Eigen::Vector3d> tips{Vec3::Zero()};
  tree.forces(x, tips, f);
  double stretched = 0;
  for (const double t : tree.tensions()) stretched += t;
  ASSERT_GT(stretched, 0.1);
  constexpr double h = 1e-9;
  for (std::size_t a = 0; a < x.size(); ++a) {
    auto moved = x;
    moved[a] += h;
    const double up = tree.energy(moved, tips);
    moved[a] -= 2 * h;
    EXPECT_NEAR(-(up - tree.energy(moved, tips)) / (2 * h), f[a], 1e-4 * std::abs(f[a]) + 1e-4) << a;
  }
  std::vector<double> v(12), kv(12, 0.0), up(12, 0.0), down(12, 0.0);
  for (std::size_t a = 0; a < 12; ++a) v[a] = std::sin(1.0 + static_cast<double>(a));
  tree.stiffness_times(x, tips, v, kv);
  auto shifted = [&](double s) {
    auto y = x;
    for (std::size_t a = 0; a < 12; ++a) y[a] += s * v[a];
    return y;
  };
  tree.forces(shifted(h), tips, up);
  tree.forces(shifted(-h), tips, down);
  for (std::size_t a = 0; a < 12; ++a) EXPECT_NEAR(-(up[a] - down[a]) / (2 * h), kv[a], 1e-4 * std::abs(kv[a]) + 1) << a;
  std::vector<double> k(4, 0.0);
  tree.add_rest_stiffness(k);
  EXPECT_NEAR(k[0], k[1], 1e-9 * k[0]);  // both halves of one end
  EXPECT_NEAR(k[3], 0.3e-6 * (chorda_response(measured[1], 1).tangent / 9.95e-3 + chorda_response(measured[2], 1).tangent / 5.8e-3 + chorda_response(measured[0], 1).tangent / 5.82e-3), 1e-6 * k[3]);
}

}  // namespace
