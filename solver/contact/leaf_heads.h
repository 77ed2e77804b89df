// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Heads (contact_kernel.h) of the eight triangles of a leaf (box_tree.h), in single precision and side by side.

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "geometry/core/parallel.h"
#include "solver/contact/box_tree.h"
#include "solver/contact/contact_kernel.h"
#include "solver/contact/float_lanes.h"

namespace mv {

/// Metres. Where nothing counts: size minus infinity, the rest zero.
struct alignas(32) LeafHeads {
  std::array<std::array<float, BoxTree::width>, 3> centre, normal;
  std::array<float, BoxTree::width> size;
};

/// A node sees a triangle at signed height p along its normal when -depth < p < height and the lateral distance is below R_f + widening |p|.
struct SightLimits {
  double depth, height;  // m
  double widening;
};

/// Which triangles of a leaf a node may see once lengths have changed by up to `change` (m) and unit normals by up to `turn`; a superset.
class LeafSight {
 public:
  LeafSight(const SightLimits& limits, float change, float turn)
      : depth_(static_cast<float>(limits.depth)),
        height_(static_cast<float>(limits.height)),
        highest_(std::max(depth_, height_)),
        widening_(static_cast<float>(limits.widening)),
        change_(change),
        turn_(turn) {}

  /// Bit l: the triangle in lane l, of a leaf with the heads `l` (R_f added to their size), by a node at p.
  unsigned of(const LeafHeads& l, const Eigen::Vector3f& p) const {
    const Floats dx = p[0] - load_floats(l.centre[0].data()), dy = p[1] - load_floats(l.centre[1].data()), dz = p[2] - load_floats(l.centre[2].data());
    const Floats squared = dx * dx + dy * dy + dz * dz;
    const Floats height = load_floats(l.normal[0].data()) * dx + load_floats(l.normal[1].data()) * dy + load_floats(l.normal[2].data()) * dz;
    // d changes by at most `change`, height and lateral distance by at most change + turn |d|, the triangle's size by at most `change`.
    const Floats change = turn_ > 0 ? change_ + turn_ * square_root(squared) : change_ + Floats{};
    const Floats above = height < 0 ? -height : height;
    const Floats widest = above + change;
    const Floats far = load_floats(l.size.data()) + change_ + widening_ * (widest < highest_ ? widest : highest_ + Floats{}) + change;
    return bits((height >= -depth_ - change) & (height <= height_ + change) & (squared - height * height <= 1.001F * far * far));
  }

 private:
  float depth_, height_, highest_, widening_, change_, turn_;
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
