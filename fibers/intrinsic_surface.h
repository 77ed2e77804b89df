// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The leaflet as a surface, for diffusion on irregular meshes: the atrial face's triangles, one column of nodes per face node, and the
// Laplacian of their intrinsic Delaunay triangulation (Bobenko & Springborn, "A discrete Laplace-Beltrami operator for simplicial surfaces",
// Discrete Comput. Geom. 38, 2007): edges are flipped on the surface itself, by lengths alone, until the two angles opposite to each add
// up to at most 180 degrees. Its cotangent weights are not negative, so that the discrete maximum principle holds on any mesh.

#include <vector>

#include "geometry/core/case.h"

namespace mv {

struct IntrinsicSurface {
  std::vector<int> column_of_node;  // per mesh point: column, -1 for points of no listed element
  std::vector<int> column_node;     // per column: its node on the atrial face
  struct Edge {
    int a, b;        // columns
    double weight;   // (cot + cot) / 2 >= 0
  };
  std::vector<Edge> edges;
  int flips = 0;
  /// Largest sum (degrees) of the two angles opposite to an edge, before flipping; above 180 ordinary cotangent weights are negative.
  double worst_angle_sum = 0;
};

/// Empty (no column) when the elements have no atrial face.
IntrinsicSurface intrinsic_surface(const LeafletMesh& mesh, const std::vector<int>& elements);

}  // namespace mv
