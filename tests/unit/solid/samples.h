// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Deformation gradients and small meshes the solid tests share.

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "solver/solid/leaflet_solid.h"

namespace mv::solid_test {

inline const Law all_laws[] = {Law::m1, Law::ogden, Law::hgo, Law::neo_hookean, Law::m2, Law::m3, Law::isotropic_exponential};

inline Material material_of(Law law) {
  Material m;
  m.law = law;
  return m;
}

class Samples {
 public:
  explicit Samples(unsigned seed) : random_(seed) {}
  double normal() { return std::normal_distribution<double>()(random_); }
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Mat3 rotation() { return Eigen::Quaterniond(normal(), normal(), normal(), normal()).normalized().toRotationMatrix(); }
  Vec3 direction() { return Vec3(normal(), normal(), normal()).normalized(); }
  Mat3 stretches(double a, double b, double c) { return rotation() * Vec3(a, b, c).asDiagonal() * rotation(); }

 private:
  std::mt19937 random_;
};

/// nx x ny x nz cubes of side h, six tetrahedra each, optionally with midpoints.
inline SolidMesh block_mesh(int nx, int ny, int nz, double h, bool is_quadratic) {
  SolidMesh mesh;
  mesh.nodes_per_tet = is_quadratic ? 10 : 4;
  auto id = [&](int i, int j, int k) { return (k * (ny + 1) + j) * (nx + 1) + i; };
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i) mesh.points.insert(mesh.points.end(), {i * h, j * h, k * h});
  auto point = [&](int n) { return Vec3(mesh.points[3 * n], mesh.points[3 * n + 1], mesh.points[3 * n + 2]); };
  std::map<std::pair<int, int>, int> midpoints;
  const int paths[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  const int edges[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};
  Samples samples(11);
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i)
        for (const auto& path : paths) {
          int cell[3] = {i, j, k}, tet[4] = {id(i, j, k), 0, 0, 0};
          for (int s = 0; s < 3; ++s) {
            ++cell[path[s]];
            tet[s + 1] = id(cell[0], cell[1], cell[2]);
          }
          if ((point(tet[1]) - point(tet[0])).cross(point(tet[2]) - point(tet[0])).dot(point(tet[3]) - point(tet[0])) < 0)
            std::swap(tet[1], tet[2]);
          mesh.tets.insert(mesh.tets.end(), tet, tet + 4);
          for (int e = 0; is_quadratic && e < 6; ++e) {
            const std::pair<int, int> key = std::minmax(tet[edges[e][0]], tet[edges[e][1]]);
            if (!midpoints.contains(key)) {
              const Vec3 middle = 0.5 * (point(key.first) + point(key.second));
              midpoints[key] = static_cast<int>(mesh.points.size()) / 3;
              mesh.points.insert(mesh.points.end(), {middle.x(), middle.y(), middle.z()});
            }
            mesh.tets.push_back(midpoints[key]);
          }
          const Vec3 fibre = samples.direction();
          mesh.fibres.insert(mesh.fibres.end(), {fibre.x(), fibre.y(), fibre.z()});
          mesh.material.push_back(i % 2);
        }
  return mesh;
}

inline Vec3 node(const std::vector<double>& x, long n) { return Vec3(x[3 * n], x[3 * n + 1], x[3 * n + 2]); }

/// F X + smooth non-affine part + noise of the given size (m).
inline std::vector<double> deformed(const SolidMesh& mesh, const Mat3& F, double noise, unsigned seed) {
  Samples samples(seed);
  std::vector<double> x(mesh.points.size());
  for (std::size_t n = 0; n < x.size() / 3; ++n) {
    const Vec3 y = F * node(mesh.points, static_cast<long>(n));
    for (int i = 0; i < 3; ++i) x[3 * n + i] = y[i] + noise * samples.normal();
  }
  return x;
}

}   // namespace mv::solid_test
