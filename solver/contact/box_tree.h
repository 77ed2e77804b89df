// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Tree of axis-aligned boxes, eight children to a node, over items that move but keep their neighbours. The tree is made once, at rest; a search only fits the
// boxes to where the items are now. Items that look different ways at rest (the two faces of a leaflet) part in the tree like items that are far apart.

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "geometry/core/parallel.h"
#include "solver/contact/float_lanes.h"

namespace mv {

class BoxTree {
 public:
  static constexpr int width = 8;
  /// Lengths of edges for `normal_length`: leaves of a leaflet that is thinner than they are wide keep to one face.
  static constexpr double normal_edges = 2;
  struct Box {
    Eigen::Array3f lower, upper;
  };

  BoxTree() = default;
  /// `points`: where the items are at rest (m); `normals`: unit vectors or zero, as many; `normal_length` (m): opposite normals count like a distance of twice that.
  BoxTree(std::span<const Eigen::Vector3d> points, std::span<const Eigen::Vector3d> normals, double normal_length);

  /// Leaves hold `width` slots each, some of them empty. Leaves near in number are near in space.
  int leaf_count() const { return leaf_count_; }
  int slot_count() const { return leaf_count_ * width; }
  int item(int slot) const { return item_[static_cast<std::size_t>(slot)]; }  // -1: empty

  /// Fits all boxes; `box_of(item)` is that of an item (m; lower above upper: overlaps nothing). Positions must be finite. The result does not depend on the thread count.
  template <class BoxOf>
  void fit(const BoxOf& box_of) {
    parallel_for(
        leaf_count_,
        [&](std::ptrdiff_t leaf) {
          for (int lane = 0; lane < width; ++lane) {
            const int i = item_[static_cast<std::size_t>(leaf * width + lane)];
            if (i >= 0) put(0, static_cast<int>(leaf), lane, box_of(i));
          }
        },
        64);
    fit_upwards();
  }

  /// Bit l: the box in lane l of the leaf overlaps `query`.
  unsigned overlapping(int leaf, const Box& query) const { return overlapping(levels_[0][static_cast<std::size_t>(leaf)], query); }
  /// Of all items of a leaf.
  Box leaf_box(int leaf) const { return get(1, leaf / width, leaf % width); }

  /// Calls visit(leaf) in ascending order for all leaves from `first` on whose box overlaps `query`.
  template <class Visit>
  void for_leaves(const Box& query, int first, const Visit& visit) const {
    descend(static_cast<int>(levels_.size()) - 1, 0, query, first, visit);
  }

 private:
  struct alignas(32) Eight {
    Eight() {
      for (auto& l : lower) l.fill(std::numeric_limits<float>::infinity());
      for (auto& u : upper) u.fill(-std::numeric_limits<float>::infinity());
    }
    std::array<std::array<float, width>, 3> lower, upper;
  };

  static unsigned overlapping(const Eight& e, const Box& q) {
    const auto lower = [&](int c) { return load_floats(e.lower[c].data()); };
    const auto upper = [&](int c) { return load_floats(e.upper[c].data()); };
    return bits((lower(0) <= q.upper[0]) & (upper(0) >= q.lower[0]) & (lower(1) <= q.upper[1]) & (upper(1) >= q.lower[1]) & (lower(2) <= q.upper[2]) &
                (upper(2) >= q.lower[2]));
  }
  void put(int level, int group, int lane, const Box& box) {
    Eight& e = levels_[static_cast<std::size_t>(level)][static_cast<std::size_t>(group)];
    for (int c = 0; c < 3; ++c) {
      e.lower[c][lane] = box.lower[c];
      e.upper[c][lane] = box.upper[c];
    }
  }
  Box get(int level, int group, int lane) const {
    const Eight& e = levels_[static_cast<std::size_t>(level)][static_cast<std::size_t>(group)];
    return {{e.lower[0][lane], e.lower[1][lane], e.lower[2][lane]}, {e.upper[0][lane], e.upper[1][lane], e.upper[2][lane]}};
  }
  void fit_upwards();
  template <class Visit>
  void descend(int level, int group, const Box& query, int first, const Visit& visit) const {
    unsigned mask = overlapping(levels_[static_cast<std::size_t>(level)][static_cast<std::size_t>(group)], query);
    for (; mask != 0; mask &= mask - 1) {
      const int child = group * width + __builtin_ctz(mask);
      if (level == 1) {
        if (child >= first) visit(child);
      } else if ((static_cast<long>(child) + 1) << (3 * (level - 1)) > first) {  // past the child's last leaf
        descend(level - 1, child, query, first, visit);
      }
    }
  }

  int leaf_count_ = 0;
  std::vector<int> item_;                   // by slot
  std::vector<std::vector<Eight>> levels_;  // [0]: the items of a leaf, [1]: eight leaves, ... up to one
};

}  // namespace mv
