// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Heads (contact_kernel.h) of the eight triangles of a leaf (box_tree.h), in single precision and side by side.

#include <array>
#include <limits>
#include <vector>

#include "geometry/core/parallel.h"
#include "solver/contact/box_tree.h"
#include "solver/contact/contact_kernel.h"

namespace mv {

/// Metres. Where nothing counts: size minus infinity, the rest zero.
struct alignas(32) LeafHeads {
  std::array<std::array<float, BoxTree::width>, 3> centre, normal;
  std::array<float, BoxTree::width> size;
};

/// Those of all leaves; `head_of(item)`: that of a triangle, or null where it does not count. Reuses the memory of `out`.
template <class HeadOf>
void gather_leaf_heads(const BoxTree& tree, const HeadOf& head_of, std::vector<LeafHeads>& out) {
  out.resize(static_cast<std::size_t>(tree.leaf_count()));
  parallel_for(
      tree.leaf_count(),
      [&](std::ptrdiff_t leaf) {
        LeafHeads& l = out[static_cast<std::size_t>(leaf)];
        for (std::size_t k = 0; k < BoxTree::width; ++k) {
          const int f = tree.item(static_cast<int>(leaf) * BoxTree::width + static_cast<int>(k));
          const contact::FacetHead* head = f < 0 ? nullptr : head_of(f);
          for (std::size_t c = 0; c < 3; ++c) {
            l.centre[c][k] = head ? static_cast<float>(head->centre[static_cast<int>(c)]) : 0;
            l.normal[c][k] = head ? static_cast<float>(head->n[static_cast<int>(c)]) : 0;
          }
          l.size[k] = head ? static_cast<float>(head->size) : -std::numeric_limits<float>::infinity();
        }
      },
      64);
}

}  // namespace mv
