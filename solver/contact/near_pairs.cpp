// SPDX-License-Identifier: BSD-3-Clause
#include "solver/contact/near_pairs.h"

#include <algorithm>
#include <cmath>

#include "solver/contact/node_lists.h"

namespace mv {

void NearPairs::update(const ContactSurface& surface, const CandidateSearch& search, std::span<const contact::FacetHead> heads, std::span<const double> x,
                       const SightLimits& limits, double skin, double turn) {
  using Vec3 = Eigen::Vector3d;
  const BoxTree& tree = search.tree();
  gather_leaf_heads(tree, [&](int f) { return &heads[static_cast<std::size_t>(f)]; }, leaves_);
  double largest = 0;  // m; with it the margin for single precision
  for (const contact::FacetHead& head : heads) largest = std::max(largest, head.centre.cwiseAbs().maxCoeff());
  const float margin = static_cast<float>(2e-6 * largest);
  const float highest = static_cast<float>(std::max(limits.depth, limits.height)), widening = static_cast<float>(limits.widening);
  const float least_change = static_cast<float>(skin) + margin, turn_f = static_cast<float>(1.0001 * turn);
  const float depth = static_cast<float>(limits.depth), height_most = static_cast<float>(limits.height);
  search_ = &search;
  fill_node_lists(search.slot_count(), found_, start_, triangle_, [&](int slot, std::vector<int>& list) {
    const int n = search.node_at(slot);
    if (n < 0) return;
    const std::size_t before = list.size();
    const Eigen::Vector3f p = Vec3::Map(x.data() + 3 * static_cast<std::size_t>(surface.nodes[static_cast<std::size_t>(n)])).cast<float>();
    for (const CandidateSearch::Block& block : search.blocks_at(slot)) {
      const LeafHeads& l = leaves_[static_cast<std::size_t>(block.leaf)];
      const Floats dx = p[0] - load_floats(l.centre[0].data()), dy = p[1] - load_floats(l.centre[1].data()), dz = p[2] - load_floats(l.centre[2].data());
      const Floats squared = dx * dx + dy * dy + dz * dz;
      const Floats height = load_floats(l.normal[0].data()) * dx + load_floats(l.normal[1].data()) * dy + load_floats(l.normal[2].data()) * dz;
      // d changes by at most skin, height and lateral distance by at most skin + turn |d|, the triangle's size by at most skin.
      const Floats change = least_change + turn_f * square_root(squared);
      const Floats above = height < 0 ? -height : height;
      const Floats widest = above + change;
      const Floats far = load_floats(l.size.data()) + least_change + widening * (widest < highest ? widest : highest + Floats{}) + change;
      const unsigned seen = block.lanes & bits((height >= -depth - change) & (height <= height_most + change) & (squared - height * height <= 1.001F * far * far));
      for (unsigned lanes = seen; lanes != 0; lanes &= lanes - 1) list.push_back(tree.item(block.leaf * BoxTree::width + __builtin_ctz(lanes)));
    }
    std::sort(list.begin() + static_cast<std::ptrdiff_t>(before), list.end());
  });
}

}  // namespace mv
