// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Boxes of linear or quadratic tetrahedra mapped into space, with their boundary faces and loads on these. SI units.

#include <Eigen/Geometry>
#include <array>
#include <functional>
#include <span>
#include <vector>

#include "solver/solid/leaflet_solid.h"

namespace mv::test {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

/// Corners 0..2, outward by the right hand; midpoints of edges 01, 12, 20 (quadratic only, else -1).
using Face = std::array<int, 6>;

struct BoxSpec {
  std::array<int, 3> cells{1, 1, 1};
  int order = 1;
  bool is_curved = false;                                        // midpoints of edges mapped as well, or halfway between the mapped corners
  std::function<Vec3(const Vec3&)> place = [](const Vec3& p) { return p; };  // unit cube -> m, keeps the orientation
  Vec3 fibre = Vec3::UnitX();
};

struct BoxMesh {
  SolidMesh mesh;
  std::array<int, 3> cells{1, 1, 1};
  std::vector<std::array<int, 3>> lattice;  // per node: position in half cells, 0 .. 2 cells

  int order() const { return mesh.nodes_per_tet == 10 ? 2 : 1; }
  int node_count() const { return static_cast<int>(lattice.size()); }
  /// On the near (0) or far (1) side along `axis`.
  bool is_on(int node, int axis, int side) const;
  int node_at(const std::array<int, 3>& half_cells) const;  // -1 when there is none
  std::vector<Face> faces_on(int axis, int side) const;
};

/// Every cell is cut into the same six tetrahedra around its diagonal.
BoxMesh box_mesh(const BoxSpec& spec);

/// f_a += integral of N_a load(dA) over the faces at positions `x`, dA the outward area vector (m2); degree 4.
void add_face_load(std::span<const Face> faces, std::span<const double> x, const std::function<Vec3(const Vec3&)>& load,
                   std::span<double> f);
/// Pressure (Pa) on the current faces, or a dead traction (Pa) when `x` are the rest positions.
void add_pressure(std::span<const Face> faces, double pressure, std::span<const double> x, std::span<double> f);
void add_traction(std::span<const Face> faces, const Vec3& traction, std::span<const double> rest, std::span<double> f);

inline Vec3 node(std::span<const double> x, int n) { return Vec3::Map(x.data() + 3 * static_cast<std::size_t>(n)); }

/// Appends the mesh of a body; returns the index of its first node.
int append(SolidMesh& all, const SolidMesh& body);

/// Slope of log |error| between two meshes whose spacing halves.
double observed_order(double coarse_error, double fine_error);

}  // namespace mv::test
