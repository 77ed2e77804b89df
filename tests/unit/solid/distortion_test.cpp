// SPDX-License-Identifier: BSD-3-Clause
// Distortion control: silent below its threshold, opposing above it, through inversion and back.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "unit/solid/samples.h"

using namespace mv;
using namespace mv::solid_test;

namespace {

SolidMesh unit_tet(double h) {
  SolidMesh mesh;
  mesh.points = {0, 0, 0, h, 0, 0, 0, h, 0, 0, 0, h};
  mesh.tets = {0, 1, 2, 3};
  mesh.fibres = {1, 0, 0};
  mesh.material = {0};
  return mesh;
}

TEST(distortion_control, does_not_touch_forces_below_the_threshold) {
  Samples samples(1);
  for (Law law : all_laws) {
    Material with = material_of(law), without = with;
    without.distortion_factor = 0;
    int silent = 0;
    for (int n = 0; n < 2000; ++n) {
      const double s = with.distortion_strain;
      const Vec3 l(samples.uniform(0.2, 2), samples.uniform(0.2, 2), samples.uniform(0.2, 2));
      const Mat3 F = samples.stretches(l[0], l[1], l[2]);
      const Vec3 f = samples.direction();
      const bool is_beyond = (l.array() - 1).abs().maxCoeff() > s || std::abs(l.prod() - 1) > s;
      const StressPoint a = evaluate(with, F, f), b = evaluate(without, F, f);
      EXPECT_EQ(a.is_controlled, is_beyond) << l.transpose();
      if (is_beyond) {
        EXPECT_GT(a.energy, b.energy);
      } else {
        ++silent;
        EXPECT_EQ(a.energy, b.energy);
        EXPECT_EQ(a.first_piola, b.first_piola);
      }
    }
    EXPECT_GT(silent, 100);
  }
}

TEST(distortion_control, energy_is_the_stated_penalty) {
  Material with = material_of(Law::neo_hookean), without = with;
  without.distortion_factor = 0;
  Samples samples(2);
  for (const Vec3& l : {Vec3(1.9, 0.8, 0.7), Vec3(0.3, 1.2, 1.5), Vec3(1, 1, -0.4), Vec3(2, 2, 2), Vec3(0.2, 0.3, 0.1)}) {
    double expected = 0;
    for (double e : {l[0] - 1, l[1] - 1, l[2] - 1, l.prod() - 1})
      expected += with.distortion_factor * with.bulk / 2 * std::pow(std::max(std::abs(e) - with.distortion_strain, 0.0), 2);
    const Mat3 F = samples.stretches(l[0], l[1], l[2]);
    const double control = energy_density(with, F, Vec3::UnitX()) - energy_density(without, F, Vec3::UnitX());
    EXPECT_NEAR(control, expected, 1e-8 * expected) << l.transpose();
  }
}

/// The apex of a tetrahedron is pushed down to J = 0.05, through its base and out on the other side.
TEST(distortion_control, compressed_and_inverted_element_is_pushed_back) {
  const double h = 1e-3;
  for (Law law : all_laws) {
    LeafletSolid solid(unit_tet(h), {material_of(law)});
    double previous = -1;
    for (double J : {0.41, 0.39, 0.3, 0.2, 0.1, 0.05, 0.01, 0.0, -0.01, -0.1, -0.3, -0.6, -0.9}) {
      std::vector<double> x = solid.mesh().points, f(12, 0.0);
      x[11] = J * h;
      const double energy = solid.forces(x, f);
      EXPECT_TRUE(std::isfinite(energy) && solid.statistics().is_finite) << name_of(law) << " J = " << J;
      EXPECT_GT(f[11], 0.0) << name_of(law) << " J = " << J;
      EXPECT_GT(energy, previous) << name_of(law) << " J = " << J;
      EXPECT_EQ(solid.statistics().inverted, J <= 0 ? 1 : 0);
      EXPECT_EQ(solid.statistics().controlled_fraction, J < 0.4 ? 1.0 : 0.0) << J;
      EXPECT_NEAR(solid.statistics().J_min, J, 1e-14);
      previous = energy;
      // nodal force against energy differences
      const double step = 1e-9;
      std::vector<double> unused(12, 0.0);
      x[11] = J * h + step;
      const double up = solid.forces(x, unused);
      x[11] = J * h - step;
      const double down = solid.forces(x, unused);
      EXPECT_NEAR(f[11], -(up - down) / (2 * step), 1e-4 * f[11] + 1e-9) << name_of(law) << " J = " << J;
    }
  }
}

/// Damped explicit steps from an inverted state, as a leaflet would take them, end in the undeformed shape.
TEST(distortion_control, inverted_element_recovers) {
  const double h = 1e-3;
  for (Law law : {Law::m1, Law::hgo, Law::ogden, Law::neo_hookean}) {
    LeafletSolid solid(unit_tet(h), {material_of(law)});
    std::vector<double> x = solid.mesh().points, v(12, 0.0), f(12);
    x[11] = -0.3 * h;
    x[9] = 0.1 * h;
    const double dt = 0.2 * solid.critical_step(x);
    for (int n = 0; n < 20000; ++n) {
      std::fill(f.begin(), f.end(), 0.0);
      solid.forces(x, f);
      for (int i = 0; i < 12; ++i) {
        v[i] = 0.95 * v[i] + dt * f[i] / solid.node_masses()[i / 3];
        x[i] += dt * v[i];
      }
    }
    EXPECT_GT(solid.statistics().J_min, 0.9) << name_of(law);
    EXPECT_EQ(solid.statistics().inverted, 0);
    EXPECT_EQ(solid.statistics().controlled_fraction, 0.0);
  }
}

TEST(distortion_control, fraction_counts_elements_once) {
  for (bool is_quadratic : {false, true}) {
    const SolidMesh mesh = block_mesh(3, 3, 2, 1e-3, is_quadratic);
    LeafletSolid solid(mesh, {material_of(Law::m1), material_of(Law::m1)});
    std::vector<double> x = mesh.points, f(x.size(), 0.0);
    for (std::size_t n = 0; n < x.size(); n += 3)
      if (x[n] > 2e-3 + 1e-9) x[n] = 2e-3 + 0.3 * (x[n] - 2e-3);   // the last third of the block is squeezed
    solid.forces(x, f);
    EXPECT_NEAR(solid.statistics().controlled_fraction, 1.0 / 3, 1e-12);
    EXPECT_GT(solid.statistics().control_energy, 0.0);
    EXPECT_LT(solid.statistics().control_energy, solid.statistics().energy);
  }
}

}   // namespace
