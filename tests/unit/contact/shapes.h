// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Shapes for the contact tests: triangle sheets and thick sheets of tetrahedra, in m.

#include <Eigen/Geometry>
#include <array>
#include <functional>
#include <vector>

#include "geometry/core/parallel.h"
#include "solver/contact/surface.h"

namespace mv::test {

using Vec3 = Eigen::Vector3d;
using Mapping = std::function<Vec3(const Vec3&)>;

struct TriangleMesh {
  std::vector<double> x;
  std::vector<std::array<int, 3>> triangles;

  int node_count() const { return static_cast<int>(x.size() / 3); }
  Vec3 point(int n) const { return {x[3 * n], x[3 * n + 1], x[3 * n + 2]}; }

  /// Appends an nu x nv grid over [0, lu] x [0, lv] mapped by `map`; outward is +z before mapping, or -z when `down`.
  /// Returns the range of its nodes.
  std::array<int, 2> add_sheet(int nu, int nv, double lu, double lv, const Mapping& map, bool down = false) {
    const int first = node_count();
    for (int j = 0; j <= nv; ++j) {
      for (int i = 0; i <= nu; ++i) {
        const Vec3 p = map(Vec3(lu * i / nu, lv * j / nv, 0));
        x.insert(x.end(), {p[0], p[1], p[2]});
      }
    }
    const auto id = [&](int i, int j) { return first + i + (nu + 1) * j; };
    const auto add = [&](int a, int b, int c) {
      triangles.push_back(down ? std::array<int, 3>{a, c, b} : std::array<int, 3>{a, b, c});
    };
    for (int j = 0; j < nv; ++j) {
      for (int i = 0; i < nu; ++i) {
        if ((i + j) % 2 == 0) {
          add(id(i, j), id(i + 1, j), id(i + 1, j + 1));
          add(id(i, j), id(i + 1, j + 1), id(i, j + 1));
        } else {
          add(id(i, j), id(i + 1, j), id(i, j + 1));
          add(id(i + 1, j), id(i + 1, j + 1), id(i, j + 1));
        }
      }
    }
    return {first, node_count()};
  }
};

struct TetMesh {
  std::vector<double> x;  // rest
  std::vector<std::array<int, 10>> tets;
  std::vector<int> side;  // +1 top (z max), -1 bottom, 0 between

  Vec3 point(int n) const { return {x[3 * n], x[3 * n + 1], x[3 * n + 2]}; }
  std::vector<double> mapped(const Mapping& map) const {
    std::vector<double> y(x.size());
    for (std::size_t n = 0; n < x.size() / 3; ++n) Eigen::Map<Vec3>(y.data() + 3 * n) = map(point(static_cast<int>(n)));
    return y;
  }
};

/// Box [0, lx] x [0, ly] x [0, lz] of nx * ny * nz cubes, each in six tetrahedra around its diagonal (conforming).
inline TetMesh tet_box(int nx, int ny, int nz, double lx, double ly, double lz) {
  TetMesh m;
  const auto id = [&](int i, int j, int k) { return i + (nx + 1) * (j + (ny + 1) * k); };
  for (int k = 0; k <= nz; ++k) {
    for (int j = 0; j <= ny; ++j) {
      for (int i = 0; i <= nx; ++i) {
        m.x.insert(m.x.end(), {lx * i / nx, ly * j / ny, lz * k / nz});
        m.side.push_back(k == nz ? 1 : (k == 0 ? -1 : 0));
      }
    }
  }
  const int order[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  for (int k = 0; k < nz; ++k) {
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i) {
        for (const auto& o : order) {
          std::array<int, 3> c{i, j, k};
          std::array<int, 10> t;
          t.fill(-1);
          t[0] = id(c[0], c[1], c[2]);
          for (int s = 0; s < 3; ++s) {
            ++c[o[s]];
            t[s + 1] = id(c[0], c[1], c[2]);
          }
          m.tets.push_back(t);
        }
      }
    }
  }
  return m;
}

/// Runs a scope on one thread: the small models of these tests gain nothing from more.
class OneThread {
 public:
  OneThread() { set_thread_count(1); }
  ~OneThread() { set_thread_count(before_); }
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  int before_ = thread_count();
};

/// Total force and total moment about the origin of interleaved nodal forces, with the sums of the magnitudes for scale.
struct Resultant {
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
  double force_scale = 0, moment_scale = 0;
};
inline Resultant resultant(const std::vector<double>& x, const std::vector<double>& forces) {
  Resultant r;
  for (std::size_t n = 0; n < x.size() / 3; ++n) {
    const Vec3 p = Eigen::Map<const Vec3>(x.data() + 3 * n), f = Eigen::Map<const Vec3>(forces.data() + 3 * n);
    r.force += f;
    r.moment += p.cross(f);
    r.force_scale += f.norm();
    r.moment_scale += p.norm() * f.norm();
  }
  return r;
}

}  // namespace mv::test
