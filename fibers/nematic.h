// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Diffusion of a direction without sign over the tetrahedra of a leaflet.
//
// At node i with tangent frame (a_i, b_i), orthogonal to the averaged sheet normal, a direction at angle phi is the complex
// number z_i = exp(2 i phi), the same for +f and -f. Unknown nodes minimise
//   sum over edges  k_ij | z_i - r_ij z_j |^2,    k_ij = - integral grad N_i . grad N_j dV   (linear tetrahedra)
// where r_ij = exp(2 i rho_ij) carries z_j from frame j to frame i by the smallest rotation between the two normals (parallel
// transport). On a flat or developable patch this is the Laplace equation for z in the unrolled plane, second order in the mesh
// size. The Hermitian system is solved by Eigen's SimplicialLDLT. |z| <= 1 up to the failure of the discrete maximum
// principle at obtuse angles; |z| near 0 marks a place where the given directions contradict each other.

#include <vector>

#include "geometry/core/case.h"

namespace mv {

struct GivenDirection {
  int node = -1;
  Vec3 direction = Vec3::Zero();  // any length but zero, either sign; projected on the tangent plane
  double weight = 1;              // of several entries for one node, the weighted mean of z counts (then |z| = 1)
};

struct NematicField {
  std::vector<Vec3> directions;  // unit, tangent to the element's sheet normal; one per entry of `elements`
  std::vector<double> order;     // |z| of each: 1 where neighbours agree, 0 where undefined
  double order_min = 1;
  bool on_surface = false;       // which of the two ways was taken
};

/// volume: linear tetrahedra. surface: intrinsic Delaunay triangles of the atrial face (intrinsic_surface.h), the same through the
/// thickness; keeps the maximum principle whatever the angles. automatic: surface where the face is far from Delaunay.
enum class Diffusion { automatic, volume, surface };

/// `elements`: indices of the tetrahedra (one leaflet, or a part of it) that the field lives on; uses corner nodes. `given`: at
/// least one entry on a node of every connected part. Throws InputError when none is given, a direction vanishes in the tangent
/// plane, or the system is singular.
NematicField diffuse_directions(const LeafletMesh& mesh, const std::vector<int>& elements,
                                const std::vector<GivenDirection>& given, Diffusion how = Diffusion::automatic);

}  // namespace mv
