// SPDX-License-Identifier: BSD-3-Clause
// Chordae: force over extension of the tension-only law, equilibrium of a branched tree, a mass that slackens its chorda.
//   ctest -L verification -V -R Chorda
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

#include "solver/chordae/chordae_tension.h"
#include "verification/solid/box_mesh.h"

namespace mv::test {
namespace {

constexpr double youngs = 20e6;          // Pa
constexpr double area_mm2 = 0.8, length_mm = 20;
constexpr double stiffness = youngs * area_mm2 * 1e-6 / (length_mm * 1e-3);  // N/m, E A / L0

/// One chorda from papillary tip 0 to a leaflet end carried by three nodes.
Chordae single() {
  Chordae c;
  c.points = {Vec3(0, 0, 0), Vec3(0, 0, length_mm)};
  c.muscle_of_point = {0, -1};
  c.segments = {{0, 1, ChordaKind::primary, 0, 1, length_mm, area_mm2}};
  c.insertions = {{1, 0, 0.5}, {1, 1, 0.3}, {1, 2, 0.2}};
  return c;
}

TEST(Chorda, force_over_extension_is_linear_in_tension_and_nothing_in_compression) {
  ChordaeTension chordae(single(), 3, youngs);
  const std::vector<Vec3> tips{Vec3::Zero()};
  const Vec3 along = Vec3(1, -2, 2) / 3;  // any direction
  const double offsets[3] = {0.5e-3, -0.25e-3, -0.875e-3};  // nodes around the end; weighted mean zero
  for (double strain : {-0.2, -0.01, 0.0, 0.01, 0.05, 0.1, 0.3}) {
    std::vector<double> x(9), f(9, 0.0);
    for (std::size_t n = 0; n < 3; ++n)
      Vec3::Map(x.data() + 3 * n) = (1 + strain) * length_mm * 1e-3 * along + offsets[n] * Vec3::UnitX();
    const double energy = chordae.forces(x, tips, f);
    const Vec3 total = node(f, 0) + node(f, 1) + node(f, 2);
    const double stretch = strain * length_mm * 1e-3, reference = strain > 0 ? stiffness * stretch : 0;
    std::printf("chorda at strain %+.2f: tension %.6f N reference %.6f difference %+.1e; energy %.3e J\n", strain, -total.dot(along), reference,
                -total.dot(along) - reference, energy);
    EXPECT_NEAR(-total.dot(along), reference, 1e-10 * stiffness * length_mm * 1e-3);
    EXPECT_NEAR((total + reference * along).norm(), 0, 1e-10 * stiffness * length_mm * 1e-3);
    EXPECT_NEAR((chordae.papillary_forces()[0] - reference * along).norm(), 0, 1e-10 * stiffness * length_mm * 1e-3);
    EXPECT_NEAR(energy, strain > 0 ? 0.5 * stiffness * stretch * stretch : 0, 1e-12);
    for (std::size_t n = 0; n < 3; ++n) {
      EXPECT_NEAR((node(f, static_cast<int>(n)) - single().insertions[n].weight * total).norm(), 0, 1e-12);
    }
  }
}

// A trunk that forks symmetrically into two branches whose ends are held: the depth z of the free fork follows from one equation,
//   k1 (z - l1) = 2 k2 (1 - l2 / s) (h - z),   s = sqrt(w^2 + (h - z)^2).
TEST(Chorda, free_branch_point_comes_to_the_closed_equilibrium) {
  constexpr double w = 4e-3, h = 30e-3, l1 = 18e-3, l2 = 9e-3, a1 = 0.9, a2 = 0.4;
  Chordae c;
  c.points = {Vec3(0, 0, 0), Vec3(0, 0, 18), Vec3(-4, 0, 30), Vec3(4, 0, 30)};
  c.muscle_of_point = {0, -1, -1, -1};
  c.segments = {{0, 1, ChordaKind::primary, 0, 1, 18, a1}, {1, 2, ChordaKind::primary, 0, 1, 9, a2}, {1, 3, ChordaKind::primary, 0, 1, 9, a2}};
  c.insertions = {{2, 0, 1.0}, {3, 1, 1.0}};
  ChordaeTension chordae(c, 2, youngs);
  ASSERT_EQ(chordae.free_points().size(), 1u);
  const std::vector<Vec3> tips{Vec3::Zero()};
  std::vector<double> x{-w, 0, h, w, 0, h, 1e-3, -0.5e-3, 17e-3}, f(9);
  constexpr double k1 = youngs * a1 * 1e-6 / l1, k2 = youngs * a2 * 1e-6 / l2;
  // Damped motion of the fork.
  constexpr double mass = 1e-6;
  const double dt = 0.5 / std::sqrt((k1 + 2 * k2) / mass);
  Vec3 v = Vec3::Zero();
  for (int step = 0; step < 20000; ++step) {
    std::fill(f.begin(), f.end(), 0.0);
    chordae.forces(x, tips, f);
    v = 0.98 * (v + dt / mass * node(f, 2));
    Vec3::Map(x.data() + 6) += dt * v;
  }
  double low = l1, high = h;
  for (int i = 0; i < 200; ++i) {
    const double z = 0.5 * (low + high), s = std::hypot(w, h - z);
    (k1 * (z - l1) < 2 * k2 * (1 - l2 / s) * (h - z) ? low : high) = z;
  }
  const double tension = k1 * (low - l1);
  std::printf("fork: z %.9f mm reference %.9f difference %+.1e mm; trunk %.6f N reference %.6f\n", 1e3 * x[8], 1e3 * low, 1e3 * (x[8] - low),
              chordae.tensions()[0], tension);
  EXPECT_NEAR(x[8], low, 1e-9 * h);
  EXPECT_NEAR(std::hypot(x[6], x[7]), 0, 1e-9 * h);
  EXPECT_NEAR(chordae.tensions()[0], tension, 1e-6 * tension);
}

// A mass on a straight chorda: half a harmonic in tension, free flight of 2 L0 through the slack, half a harmonic on the other side.
TEST(Chorda, mass_flies_free_through_the_slack) {
  Chordae c;
  c.points = {Vec3(0, 0, 0), Vec3(0, 0, length_mm)};
  c.muscle_of_point = {0, -1};
  c.segments = {{0, 1, ChordaKind::primary, 0, 1, length_mm, area_mm2}};
  c.insertions = {{1, 0, 1.0}};
  ChordaeTension chordae(c, 1, youngs);
  const std::vector<Vec3> tips{Vec3::Zero()};
  constexpr double mass = 1e-3, rest = length_mm * 1e-3;
  const double omega = std::sqrt(stiffness / mass), amplitude = 0.1 * rest;
  const double reference = 2 * std::numbers::pi / omega + 4 * rest / (omega * amplitude);
  double coarse = 0;
  for (double share : {0.02, 0.01, 0.005}) {
    const double dt = share / omega;
    // Velocities live half a step before positions: at rest at the start means half a kick back.
    std::vector<double> x{0, 0, rest + amplitude}, v{0, 0, 0.5 * dt / mass * stiffness * amplitude}, f(3);
    double time = 0, energy_error = 0;
    const double energy = 0.5 * stiffness * amplitude * amplitude;
    // Time from the start to the next crossing of x = rest outwards is a whole period less a quarter of a harmonic.
    for (double before = 1;; before = x[2] - rest) {
      std::fill(f.begin(), f.end(), 0.0);
      const double elastic = chordae.forces(x, tips, f);
      const double old = v[2];
      v[2] += dt / mass * f[2];
      energy_error = std::max(energy_error, std::abs(elastic + 0.5 * mass * old * v[2] - energy) / energy);
      x[2] += dt * v[2];
      time += dt;
      if (before < 0 && x[2] >= rest) {
        // v is constant over a step without force: interpolate.
        time -= (x[2] - rest) / v[2];
        break;
      }
    }
    const double period = time + 0.5 * std::numbers::pi / omega;
    std::printf("mass on a chorda, omega dt %.3f: period %.8f s reference %.8f difference %+.2e, energy kept within %.1e", share, period, reference,
                period / reference - 1, energy_error);
    if (coarse != 0) std::printf(", order %.2f", observed_order(coarse, period / reference - 1));
    std::printf("\n");
    EXPECT_LT(std::abs(period / reference - 1), share * share);
    EXPECT_LT(energy_error, share * share);
    coarse = period / reference - 1;
  }
}

}  // namespace
}  // namespace mv::test
