// SPDX-License-Identifier: BSD-3-Clause
#include "solver/contact/box_tree.h"

#include <algorithm>
#include <numeric>

namespace mv {
namespace {

using Coordinates = Eigen::Array<float, 6, 1>;  // point, scaled normal

/// Orders items [begin, end) so that every aligned run of 8, 64, 512, ... is a cell of repeated halving along the longest extent.
void order(std::span<const Coordinates> at, std::span<int> items) {
  const std::size_t count = items.size();
  if (count <= BoxTree::width) {
    std::sort(items.begin(), items.end());
    return;
  }
  Coordinates lower = at[static_cast<std::size_t>(items[0])], upper = lower;
  for (int i : items) {
    lower = lower.min(at[static_cast<std::size_t>(i)]);
    upper = upper.max(at[static_cast<std::size_t>(i)]);
  }
  int axis = 0;
  (upper - lower).maxCoeff(&axis);
  std::size_t left = BoxTree::width;
  while (2 * left < count) left *= 2;
  const auto before = [&](int a, int b) {
    const float u = at[static_cast<std::size_t>(a)][axis], v = at[static_cast<std::size_t>(b)][axis];
    return u < v || (u == v && a < b);
  };
  std::nth_element(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(left), items.end(), before);
  order(at, items.first(left));
  order(at, items.subspan(left));
}

}  // namespace

BoxTree::BoxTree(std::span<const Eigen::Vector3d> points, std::span<const Eigen::Vector3d> normals, double normal_length) {
  std::vector<Coordinates> at(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) at[i] << points[i].cast<float>().array(), (normal_length * normals[i]).cast<float>().array();
  item_.resize(points.size());
  std::iota(item_.begin(), item_.end(), 0);
  order(at, item_);
  leaf_count_ = static_cast<int>((points.size() + width - 1) / width);
  item_.resize(static_cast<std::size_t>(slot_count()), -1);
  std::size_t groups = static_cast<std::size_t>(std::max(leaf_count_, 1));
  levels_.emplace_back(groups);
  do {
    groups = (groups + width - 1) / width;
    levels_.emplace_back(groups);
  } while (groups > 1);
}

void BoxTree::fit_upwards() {
  for (std::size_t level = 1; level < levels_.size(); ++level) {
    const auto children = static_cast<std::ptrdiff_t>(level == 1 ? static_cast<std::size_t>(leaf_count_) : levels_[level - 1].size());
    parallel_for(
        children,
        [&](std::ptrdiff_t child) {
          const Eight& e = levels_[level - 1][static_cast<std::size_t>(child)];
          Box b;
          for (int c = 0; c < 3; ++c) {
            b.lower[c] = *std::min_element(e.lower[c].begin(), e.lower[c].end());
            b.upper[c] = *std::max_element(e.upper[c].begin(), e.upper[c].end());
          }
          put(static_cast<int>(level), static_cast<int>(child / width), static_cast<int>(child % width), b);
        },
        512);
  }
}

}  // namespace mv
