// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

struct SideTriangle {
  std::array<int, 3> nodes;
  std::size_t element;
};

/// Triangles of the mesh's boundary whose corners all lie on `side` (atrial or ventricular), in the order of the elements; corners in the order of the element's. Any tetrahedra,
/// not only layers: an element may have two faces there, or three corners without a face.
inline std::vector<SideTriangle> side_triangles(const LeafletMesh& mesh, int side) {
  struct Found {
    std::array<int, 3> key;
    SideTriangle triangle;
  };
  std::vector<Found> found;
  for (std::size_t e = 0; e < mesh.tets.size(); ++e)
    for (std::size_t without = 4; without-- > 0;) {
      std::array<int, 3> nodes{};
      std::size_t count = 0;
      for (std::size_t k = 0; k < 4; ++k)
        if (k != without) nodes[count++] = mesh.tets[e][k];
      if (!std::all_of(nodes.begin(), nodes.end(), [&](int n) { return mesh.side[static_cast<std::size_t>(n)] == side; })) continue;
      std::array<int, 3> key = nodes;
      std::sort(key.begin(), key.end());
      found.push_back({key, {nodes, e}});
    }
  std::vector<std::size_t> order(found.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return found[a].key < found[b].key; });
  std::vector<char> is_boundary(found.size(), 1);
  for (std::size_t i = 1; i < order.size(); ++i)
    if (found[order[i]].key == found[order[i - 1]].key) is_boundary[order[i]] = is_boundary[order[i - 1]] = 0;
  std::vector<SideTriangle> triangles;
  for (std::size_t i = 0; i < found.size(); ++i)
    if (is_boundary[i]) triangles.push_back(found[i].triangle);
  return triangles;
}

}  // namespace mv
