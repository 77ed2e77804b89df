// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Second phase of the search: of the candidates of a node (candidates.h), those that can be seen before anything has moved far.

#include <span>
#include <vector>

#include "solver/contact/candidates.h"
#include "solver/contact/contact_kernel.h"
#include "solver/contact/leaf_heads.h"

namespace mv {

/// A node sees a triangle at signed height p along its normal when -depth < p < height and the lateral distance is below R_f + widening |p|.
struct SightLimits {
  double depth, height;  // m
  double widening;
};

class NearPairs {
 public:
  /// Keeps, of `search`'s lists, every triangle that the node can see while no node has moved by more than `skin` / 2 (m) and no triangle's unit
  /// normal by more than `turn` (may keep some that it cannot). `heads` of all triangles at `x` (3 * solid_nodes), R_f added to their size. Ascending order. Reuses its memory. Keeps a reference to `search`.
  void update(const ContactSurface& surface, const CandidateSearch& search, std::span<const contact::FacetHead> heads, std::span<const double> x,
              const SightLimits& limits, double skin, double turn);

  std::span<const int> triangles_of(int node) const {
    const std::size_t slot = slot_of(node);
    return {triangle_.data() + start_[slot], static_cast<std::size_t>(start_[slot + 1] - start_[slot])};
  }
  int first_pair(int node) const { return start_[slot_of(node)]; }
  int pair_count() const { return start_.back(); }

 private:
  std::size_t slot_of(int node) const { return static_cast<std::size_t>(search_->slot_of(node)); }

  const CandidateSearch* search_ = nullptr;
  std::vector<int> start_{0}, triangle_;  // by slot of `search`
  std::vector<LeafHeads> leaves_;
  std::vector<std::vector<int>> found_;  // per piece of nodes
};

}  // namespace mv
