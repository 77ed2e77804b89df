// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <map>

#include "geometry/volume/gates.h"

namespace mv {

BoundarySurface extract_boundary(const LeafletMesh& mesh) {
  // Faces of a positive tetrahedron, outward, with the mid-edge nodes of edges 01, 12, 20 of the face (VTK numbering).
  constexpr std::array<std::array<std::size_t, 6>, 4> faces{
      {{0, 2, 1, 6, 5, 4}, {0, 1, 3, 4, 8, 7}, {1, 2, 3, 5, 9, 8}, {0, 3, 2, 7, 9, 6}}};
  struct Face {
    std::array<int, 6> nodes;
    int element;
    int count;
  };
  std::map<std::array<int, 3>, Face> seen;
  for (std::size_t e = 0; e < mesh.tets.size(); ++e)
    for (const auto& f : faces) {
      std::array<int, 6> nodes{};
      for (std::size_t k = 0; k < 6; ++k) nodes[k] = mesh.tets[e][f[k]];
      std::array<int, 3> key{nodes[0], nodes[1], nodes[2]};
      std::sort(key.begin(), key.end());
      const auto [entry, added] = seen.try_emplace(key, Face{nodes, static_cast<int>(e), 0});
      ++entry->second.count;
    }
  std::vector<const Face*> outer;
  for (const auto& [key, face] : seen)
    if (face.count == 1) outer.push_back(&face);
  std::stable_sort(outer.begin(), outer.end(), [](const Face* a, const Face* b) { return a->element < b->element; });
  BoundarySurface b;
  for (const Face* f : outer) {
    b.triangles.push_back({f->nodes[0], f->nodes[1], f->nodes[2]});
    if (mesh.order == 2) b.quadratic.push_back(f->nodes);
    b.element.push_back(f->element);
  }
  return b;
}

std::vector<std::array<int, 3>> boundary_facets(const BoundarySurface& boundary) {
  if (boundary.quadratic.empty()) return boundary.triangles;
  std::vector<std::array<int, 3>> facets;
  for (const auto& q : boundary.quadratic) {
    facets.push_back({q[0], q[3], q[5]});
    facets.push_back({q[3], q[1], q[4]});
    facets.push_back({q[5], q[4], q[2]});
    facets.push_back({q[3], q[4], q[5]});
  }
  return facets;
}

}  // namespace mv
