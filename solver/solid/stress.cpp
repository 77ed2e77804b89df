// SPDX-License-Identifier: BSD-3-Clause
#include "solver/solid/stress.h"

#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "geometry/core/parallel.h"
#include "solver/solid/element_blocks.h"

namespace mv {

using namespace solid_kernel;

namespace {

struct PointStress {
  double von_mises = 0, fibre_stress = 0, fibre_strain = 0, J = 0;
};

PointStress point_stress(const Material& material, const Mat3& F, const Vec3& fibre) {
  const Mat3 sigma = cauchy_stress(material, F, fibre);
  const Mat3 deviator = sigma - sigma.trace() / 3 * Mat3::Identity();
  const Vec3 stretched = F * fibre;
  const double stretch = stretched.norm();
  PointStress p;
  p.von_mises = std::sqrt(1.5 * deviator.squaredNorm());
  if (stretch > 0) p.fibre_stress = stretched.dot(sigma * stretched) / (stretch * stretch);
  p.fibre_strain = stretch - 1;
  p.J = F.determinant();
  return p;
}

template <int N>
void fill(const LeafletSolid& solid, std::span<const double> x, ElementStress& out) {
  const SolidMesh& mesh = solid.mesh();
  parallel_for(solid.element_count(), [&](std::ptrdiff_t e) {
    const Vec3 fibre(mesh.fibres[3 * e], mesh.fibres[3 * e + 1], mesh.fibres[3 * e + 2]);
    double total = 0;
    PointStress mean;
    for (int q = 0; q < Shape<N>::points; ++q) {
      Mat3 reference = Mat3::Zero(), current = Mat3::Zero();
      for (int a = 0; a < N; ++a) {
        const long n = 3 * static_cast<long>(mesh.tets[e * N + a]);
        for (int k = 0; k < 3; ++k) {
          reference.col(k) += Eigen::Map<const Vec3>(mesh.points.data() + n) * shape_derivative<N>(q, a, k);
          current.col(k) += Eigen::Map<const Vec3>(x.data() + n) * shape_derivative<N>(q, a, k);
        }
      }
      const double weight = reference.determinant();
      const PointStress p = point_stress(solid.materials()[mesh.material[e]], current * reference.inverse(), fibre);
      total += weight;
      mean.von_mises += weight * p.von_mises;
      mean.fibre_stress += weight * p.fibre_stress;
      mean.fibre_strain += weight * p.fibre_strain;
      mean.J += weight * p.J;
    }
    out.von_mises[e] = mean.von_mises / total;
    out.fibre_stress[e] = mean.fibre_stress / total;
    out.fibre_strain[e] = mean.fibre_strain / total;
    out.J[e] = mean.J / total;
  });
}

}   // namespace

ElementStress element_stress(const LeafletSolid& solid, std::span<const double> x) {
  assert(static_cast<long>(x.size()) == 3 * solid.node_count());
  const auto n = static_cast<std::size_t>(solid.element_count());
  ElementStress out{std::vector<double>(n), std::vector<double>(n), std::vector<double>(n), std::vector<double>(n)};
  if (solid.mesh().nodes_per_tet == 10)
    fill<10>(solid, x, out);
  else
    fill<4>(solid, x, out);
  return out;
}

std::vector<double> average_to_nodes(const LeafletSolid& solid, std::span<const double> element_values) {
  assert(static_cast<long>(element_values.size()) == solid.element_count());
  const SolidMesh& mesh = solid.mesh();
  std::vector<double> sum(static_cast<std::size_t>(solid.node_count()), 0.0), weight(sum.size(), 0.0);
  for (long e = 0; e < solid.element_count(); ++e)
    for (int a = 0; a < mesh.nodes_per_tet; ++a) {
      const int n = mesh.tets[e * mesh.nodes_per_tet + a];
      sum[n] += solid.element_volumes()[e] * element_values[e];
      weight[n] += solid.element_volumes()[e];
    }
  for (std::size_t n = 0; n < sum.size(); ++n)
    if (weight[n] > 0) sum[n] /= weight[n];
  return sum;
}

}   // namespace mv
