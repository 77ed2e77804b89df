// SPDX-License-Identifier: BSD-3-Clause
#include "solver/contact/near_pairs.h"

#include "solver/contact/node_lists.h"

namespace mv {

void NearPairs::update(const ContactSurface& surface, const CandidateSearch& search, std::span<const LeafHeads> heads, std::span<const double> x,
                       const SightLimits& limits, float margin, double skin, double turn) {
  const LeafSight sight(limits, static_cast<float>(skin) + margin, static_cast<float>(1.0001 * turn));
  search_ = &search;
  fill_node_lists(search.slot_count(), found_, start_, block_, [&](int slot, std::vector<Block>& list) {
    const int n = search.node_at(slot);
    if (n < 0) return;
    const Eigen::Vector3f p = Eigen::Vector3d::Map(x.data() + 3 * static_cast<std::size_t>(surface.nodes[static_cast<std::size_t>(n)])).cast<float>();
    for (const Block& block : search.blocks_at(slot))
      if (const unsigned seen = block.lanes & sight.of(heads[static_cast<std::size_t>(block.leaf)], p); seen != 0) list.push_back({block.leaf, seen});
  });
}

}  // namespace mv
