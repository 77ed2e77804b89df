// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Second phase of the search: of the candidates of a node (candidates.h), those that can be seen before anything has moved far.

#include <span>
#include <vector>

#include "solver/contact/candidates.h"
#include "solver/contact/leaf_heads.h"

namespace mv {

class NearPairs {
 public:
  using Block = CandidateSearch::Block;

  /// Keeps, of `search`'s lists, every triangle that the node can see while no node has moved by more than `skin` / 2 (m) and no triangle's unit
  /// normal by more than `turn` (may keep some that it cannot). `heads` of the leaves of search.tree() at `x` (3 * solid_nodes), R_f added to their size; `margin` (m): of single precision.
  /// Reuses its memory. Keeps a reference to `search`.
  void update(const ContactSurface& surface, const CandidateSearch& search, std::span<const LeafHeads> heads, std::span<const double> x, const SightLimits& limits,
              float margin, double skin, double turn);

  /// Ascending leaves.
  std::span<const Block> blocks_of(int node) const {
    const auto slot = static_cast<std::size_t>(search_->slot_of(node));
    return {block_.data() + start_[slot], static_cast<std::size_t>(start_[slot + 1] - start_[slot])};
  }
  /// The same as a list, ascending.
  std::vector<int> triangles_of(int node) const { return search_->triangles_in(blocks_of(node)); }

 private:
  const CandidateSearch* search_ = nullptr;
  std::vector<int> start_{0};  // by slot of `search`
  std::vector<Block> block_;
  std::vector<std::vector<Block>> found_;  // per piece of nodes
};

}  // namespace mv
