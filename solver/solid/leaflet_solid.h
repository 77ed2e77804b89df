// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Total Lagrangian finite elements for the leaflets: linear tetrahedra with one point, quadratic ones (C3D10) with four.
//
//   f_a = - dW/dx_a = - sum over quadrature points  w  P(F) dN_a/dX,      F = sum_a x_a (x) dN_a/dX.
//
// Node arrays are 3 n doubles, x0 y0 z0 x1 y1 z1 ... in m, N, m/s. Results do not depend on the number of threads, bit for bit.
// Nothing is allocated after construction. A LeafletSolid has work buffers: one object must not be used from two threads at once.

#include <memory>
#include <span>
#include <vector>

#include "geometry/core/case.h"
#include "solver/solid/material.h"

namespace mv {

struct SolidMesh {
  int nodes_per_tet = 4;        // 4, or 10 (VTK ordering: corners, then midpoints of edges 01 12 02 03 13 23)
  std::vector<double> points;   // 3 n, m
  std::vector<int> tets;        // nodes_per_tet an element
  std::vector<double> fibres;   // 3 an element, unit
  std::vector<int> material;    // index into the materials, one an element
};

/// mm to m; materials in the order of leaflet_names: 0 for the anterior leaflet, 1 for the posterior, 2 for the septal. Throws InputError for another region.
SolidMesh to_solid_mesh(const LeafletMesh& mesh);

struct SolidStatistics {
  double energy = 0;           // J, distortion control included
  double control_energy = 0;   // J, of distortion control alone
  double volume = 0;           // m3, current
  double J_min = 1;            // over all quadrature points
  double J_max = 1;
  long J_min_element = -1;          // element that holds J_min
  double controlled_fraction = 0;   // elements with distortion control active / elements
  long inverted = 0;                // elements with J <= 0 at a quadrature point
  bool is_finite = true;            // false: energy is NaN or infinite, positions were not finite or absurd
};

class LeafletSolid {
 public:
  /// Throws InputError: sizes that do not match, indices out of range, non-positive reference volume (element named), fibre not
  /// unit, unusable material.
  LeafletSolid(const SolidMesh& mesh, std::vector<Material> materials);
  ~LeafletSolid();
  LeafletSolid(LeafletSolid&&) noexcept;
  LeafletSolid& operator=(LeafletSolid&&) noexcept;

  long node_count() const;
  long element_count() const;

  /// Adds -dW/dx to `f`, returns W in J and fills statistics(). x and f: 3 n.
  double forces(std::span<const double> x, std::span<double> f);
  /// Of the last forces() call.
  const SolidStatistics& statistics() const;

  /// out = K v = -(df/dx) v by central differences of the force, the largest node displacement being 3e-6 of the shortest edge.
  /// Error about 1e-7 of |K v| where the law is smooth. Two force evaluations; statistics() is not touched. v, out: 3 n; out is
  /// overwritten.
  void forces_directional(std::span<const double> x, std::span<const double> v, std::span<double> out);

  /// The same by a forward difference from the forces `at_x` = f(x), for estimates that need many products at one x: one force evaluation, error about 1e-4.
  void forces_directional(std::span<const double> x, std::span<const double> at_x, std::span<const double> v, std::span<double> out);

  /// Largest stable step (s) of explicit central differences with the element's own lumped mass: min over elements of
  /// 2 / sqrt(lambda_max(M_e^-1 K_e)) with the current tangent, distortion control included; a lower bound of the assembled step
  /// but for the power iteration (16 rounds; a few per cent). Costs about 30 force evaluations: call it every 50 or 100 steps.
  /// `element_steps`, when not empty, receives the value of each element.
  double critical_step(std::span<const double> x, std::span<double> element_steps = {}, int rounds = 16);

  /// Reference volume (m3) and mass (kg) per node: V/4 to each node of a linear tetrahedron; V/36 to each corner and 4V/27 to
  /// each midpoint of a quadratic one (HRZ: diagonal of the consistent mass, scaled). All positive; their sum is the total.
  const std::vector<double>& node_volumes() const;
  const std::vector<double>& node_masses() const;
  /// Reference volume of each element, m3.
  const std::vector<double>& element_volumes() const;

  const SolidMesh& mesh() const;
  const std::vector<Material>& materials() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}   // namespace mv
