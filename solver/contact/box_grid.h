// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Dense uniform grid of cubic cells over a bounding box, with items sorted by cell (counting sort). The number of cells is capped
// by enlarging them, so that far-flung positions cost time, never memory. Cells along x are neighbours in memory: a box of cells
// is a few contiguous runs of items.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <vector>

#include "geometry/core/errors.h"

namespace mv {

class BoxGrid {
 public:
  static constexpr double cells_max = 2.0e6;

  /// Covers [lower, upper] with cells of at least `cell` (m). Throws TrustError when the box is not finite.
  void reset(const Eigen::Vector3d& lower, const Eigen::Vector3d& upper, double cell) {
    if (!lower.allFinite() || !upper.allFinite()) throw TrustError("contact: positions are not finite; the run has diverged");
    lower_ = lower;
    const Eigen::Vector3d extent = (upper - lower).cwiseMax(cell);
    while (((extent / cell).array() + 1.0).prod() > cells_max) cell *= 1.25;
    inverse_ = 1.0 / cell;
    cell_ = cell;
    for (int k = 0; k < 3; ++k) size_[k] = static_cast<int>(extent[k] * inverse_) + 1;
  }

  /// Sorts `count` items by cell; item_cell(i) gives cell_index() of item i. Keeps the order of items within a cell.
  template <class ItemCell>
  void sort(int count, ItemCell&& item_cell) {
    start_.assign(static_cast<std::size_t>(size_[0]) * size_[1] * size_[2] + 1, 0);
    cell_of_.resize(static_cast<std::size_t>(count));
    items_.resize(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) ++start_[static_cast<std::size_t>((cell_of_[i] = item_cell(i))) + 1];
    for (std::size_t c = 1; c < start_.size(); ++c) start_[c] += start_[c - 1];
    for (int i = 0; i < count; ++i) items_[start_[cell_of_[i]]++] = i;
    for (std::size_t c = start_.size() - 1; c > 0; --c) start_[c] = start_[c - 1];
    start_[0] = 0;
  }

  /// Cell coordinates of a point, clamped to the grid.
  std::array<int, 3> cell(const Eigen::Vector3d& p) const {
    std::array<int, 3> c;
    for (int k = 0; k < 3; ++k) c[k] = static_cast<int>(std::clamp((p[k] - lower_[k]) * inverse_, 0.0, size_[k] - 1.0));
    return c;
  }
  int cell_index(const std::array<int, 3>& c) const { return c[0] + size_[0] * (c[1] + size_[1] * c[2]); }

  /// Calls run(begin, end) for contiguous ranges of sorted positions that cover all items in cells [low, high].
  template <class Run>
  void for_runs(const std::array<int, 3>& low, const std::array<int, 3>& high, Run&& run) const {
    for (int k = low[2]; k <= high[2]; ++k) {
      for (int j = low[1]; j <= high[1]; ++j) {
        const int first = cell_index({low[0], j, k});
        run(start_[first], start_[first + high[0] - low[0] + 1]);
      }
    }
  }

  int item(int position) const { return items_[position]; }
  double cell_size() const { return cell_; }
  const std::array<int, 3>& size() const { return size_; }

 private:
  Eigen::Vector3d lower_ = Eigen::Vector3d::Zero();
  double cell_ = 1, inverse_ = 1;
  std::array<int, 3> size_{1, 1, 1};
  std::vector<int> start_, items_, cell_of_;
};

}  // namespace mv
