// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A second, independent solution of Cook's membrane: hexahedra Q1 or Q2, one element deep, hand-derived tangent. It shares nothing with
// the solver and takes either volumetric energy, so that the published table and the solver's law can be told apart.
//
//   W = mu/2 (J^(-2/3) F:F - 3) + U(J)
//
// The published table is headed plane strain, but is that of a slab with free faces, read at the upper corner: the program that printed
// it looked for the faces to hold by their x coordinate and found none. Both states are offered.

namespace mv::test {

enum class VolumetricEnergy {
  published,  // kappa/4 (J^2 - 1 - 2 ln J), deal.II code gallery
  solver,     // kappa/2 (ln J)^2, solver/solid
};
enum class Faces { held, free };  // of the slab: plane strain, or no stress

struct CookSpec {
  double shear = 422.5e3, poisson = 0.3;  // Pa
  double force = 1.0, depth = 1e-3;       // N over a slab of that depth (m)
  double bulk() const { return 2 * shear * (1 + poisson) / (3 * (1 - 2 * poisson)); }
};

/// Vertical displacement (m) of the loaded end's upper corner and of its middle, on a face of the slab.
struct CookTip {
  double corner = 0, middle = 0;
};
/// With n x n x 1 elements of degree 1 or 2 (the middle is a node unless n and degree are odd).
CookTip cook_tip_of_hexahedra(const CookSpec& spec, VolumetricEnergy energy, Faces faces, int n, int degree);

}  // namespace mv::test
