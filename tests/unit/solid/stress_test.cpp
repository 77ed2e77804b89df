// SPDX-License-Identifier: BSD-3-Clause
#include "solver/solid/stress.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "unit/solid/samples.h"

using namespace mv;
using namespace mv::solid_test;

namespace {

TEST(stress, homogeneous_uniaxial_state_is_reported_everywhere) {
  for (bool is_quadratic : {false, true}) {
    SolidMesh mesh = block_mesh(2, 2, 1, 1e-3, is_quadratic);
    for (std::size_t e = 0; e < mesh.material.size(); ++e)
      for (int i = 0; i < 3; ++i) mesh.fibres[3 * e + i] = i == 0;
    Material m = material_of(Law::m1);
    LeafletSolid solid(mesh, {m, m});
    const double l = 1.08;
    Samples samples(1);
    const Mat3 stretch = Vec3(l, 1 / std::sqrt(l), 1 / std::sqrt(l)).asDiagonal();
    const std::vector<double> x = deformed(mesh, samples.rotation() * stretch, 0, 1);
    const ElementStress s = element_stress(solid, x);
    const double E = l * l - 1;
    const double matrix = 2 * m.m1_c * (l * l - 1 / l), fibre = 2 * m.m1_a * E * std::exp(m.m1_b * E * E) * l * l;
    const double difference = matrix + fibre;
    for (std::size_t e = 0; e < s.J.size(); ++e) {
      EXPECT_NEAR(s.von_mises[e], difference, 1e-8 * difference);                    // |s11 - s22|
      EXPECT_NEAR(s.fibre_stress[e], 2.0 / 3 * matrix + fibre, 1e-8 * difference);   // deviator of the matrix, whole fibre stress
      EXPECT_NEAR(s.fibre_strain[e], l - 1, 1e-12);
      EXPECT_NEAR(s.J[e], 1, 1e-12);
    }
    for (double v : average_to_nodes(solid, s.von_mises)) EXPECT_NEAR(v, difference, 1e-8 * difference);
  }
}

TEST(stress, pressure_changes_fibre_stress_but_not_von_mises) {
  const SolidMesh mesh = block_mesh(1, 1, 1, 1e-3, false);
  Material m = material_of(Law::neo_hookean);
  LeafletSolid solid(mesh, {m, m});
  const double scale = 1.02;
  const ElementStress s = element_stress(solid, deformed(mesh, scale * Mat3::Identity(), 0, 1));
  const double J = std::pow(scale, 3);
  for (std::size_t e = 0; e < s.J.size(); ++e) {
    EXPECT_LT(s.von_mises[e], 1e-6 * m.bulk);
    EXPECT_NEAR(s.fibre_stress[e], m.bulk * std::log(J) / J, 1e-9 * m.bulk);
    EXPECT_NEAR(s.J[e], J, 1e-12);
  }
}

TEST(stress, nodal_mean_is_weighted_by_volume) {
  const SolidMesh mesh = block_mesh(2, 1, 1, 1e-3, false);
  LeafletSolid solid(mesh, {Material{}, Material{}});
  std::vector<double> values(static_cast<std::size_t>(solid.element_count()));
  for (std::size_t e = 0; e < values.size(); ++e) values[e] = static_cast<double>(e);
  const std::vector<double> mean = average_to_nodes(solid, values);
  std::vector<double> sum(mean.size(), 0.0), weight(mean.size(), 0.0);
  for (std::size_t i = 0; i < mesh.tets.size(); ++i) {
    sum[mesh.tets[i]] += solid.element_volumes()[i / 4] * values[i / 4];
    weight[mesh.tets[i]] += solid.element_volumes()[i / 4];
  }
  for (std::size_t n = 0; n < mean.size(); ++n) EXPECT_DOUBLE_EQ(mean[n], sum[n] / weight[n]);
}

}   // namespace
