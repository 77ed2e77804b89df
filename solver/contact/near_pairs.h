// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Second phase of the search: of the candidates of a node (candidates.h), those that can be seen before anything has moved far.

#include <array>
#include <span>
#include <vector>

#include "solver/contact/candidates.h"
#include "solver/contact/contact_kernel.h"

namespace mv {

/// A node sees a triangle at signed height p along its normal when -depth < p < height and the lateral distance is below R_f + widening |p|.
struct SightLimits {
  double depth, height;  // m
  double widening;
};

class NearPairs {
 public:
  /// Keeps, of `search`'s lists, every triangle that the node can see while no node has moved by more than `skin` / 2 (m) and no triangle's unit
  /// normal by more than `turn` (may keep some that it cannot). `heads` of all triangles at `x` (3 * solid_nodes), R_f added to their size. Ascending order. Reuses its memory.
  void update(const ContactSurface& surface, const CandidateSearch& search, std::span<const contact::FacetHead> heads, std::span<const double> x,
              const SightLimits& limits, double skin, double turn);

  std::span<const int> triangles_of(int node) const {
    return {triangle_.data() + start_[static_cast<std::size_t>(node)],
            static_cast<std::size_t>(start_[static_cast<std::size_t>(node) + 1] - start_[static_cast<std::size_t>(node)])};
  }
  int first_pair(int node) const { return start_[static_cast<std::size_t>(node)]; }
  int pair_count() const { return start_.back(); }

 private:
  /// Heads of the triangles of a leaf.
  struct alignas(32) Lanes {
    std::array<float, BoxTree::width> cx, cy, cz, nx, ny, nz, size;
  };
  std::vector<int> start_{0}, triangle_;
  std::vector<Lanes> lanes_;             // per leaf
  std::vector<std::vector<int>> found_;  // per piece of nodes
};

}  // namespace mv
