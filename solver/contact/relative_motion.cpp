// SPDX-License-Identifier: BSD-3-Clause
#include "solver/contact/relative_motion.h"

#include <algorithm>
#include <limits>

#include "geometry/core/parallel.h"

namespace mv {
namespace {
constexpr double infinity = std::numeric_limits<double>::infinity();
}  // namespace

void RelativeMotion::place(std::span<const double> x, std::span<const int> vertices, double cell) {
  using Vec3 = Eigen::Vector3d;
  const auto at = [&](std::size_t k) { return Vec3(Eigen::Map<const Vec3>(x.data() + 3 * static_cast<std::size_t>(vertices[k]))); };
  Vec3 lower = at(0), upper = lower;
  for (std::size_t k = 1; k < vertices.size(); ++k) {
    lower = lower.cwiseMin(at(k));
    upper = upper.cwiseMax(at(k));
  }
  grid_.reset(lower, upper, cell);
  const auto& n = grid_.size();
  const auto cells = static_cast<std::size_t>(n[0]) * static_cast<std::size_t>(n[1]) * static_cast<std::size_t>(n[2]);
  std::vector<int> cell_of(vertices.size());
  start_.assign(cells + 1, 0);
  for (std::size_t k = 0; k < vertices.size(); ++k) ++start_[static_cast<std::size_t>(cell_of[k] = grid_.cell_index(grid_.cell(at(k)))) + 1];
  for (std::size_t c = 0; c < cells; ++c) start_[c + 1] += start_[c];
  item_.resize(vertices.size());
  std::vector<int> next(start_.begin(), start_.end() - 1);
  for (std::size_t k = 0; k < vertices.size(); ++k) item_[static_cast<std::size_t>(next[static_cast<std::size_t>(cell_of[k])]++)] = static_cast<int>(k);
}

double RelativeMotion::bound(std::span<const Eigen::Vector3d> u) {
  const std::size_t cells = start_.size() - 1;
  box_.resize(cells);
  wide_.resize(cells);
  parallel_for(static_cast<std::ptrdiff_t>(cells), [&](std::ptrdiff_t c) {
    Box b{Eigen::Array3d::Constant(infinity), Eigen::Array3d::Constant(-infinity)};
    for (int k = start_[static_cast<std::size_t>(c)]; k < start_[static_cast<std::size_t>(c) + 1]; ++k) {
      const Eigen::Array3d value = u[static_cast<std::size_t>(item_[static_cast<std::size_t>(k)])].array();
      b.lower = b.lower.min(value);
      b.upper = b.upper.max(value);
    }
    box_[static_cast<std::size_t>(c)] = b;
  });
  // Each cell with its neighbours, one direction after the other.
  const auto& n = grid_.size();
  const std::array<std::ptrdiff_t, 3> stride{1, n[0], static_cast<std::ptrdiff_t>(n[0]) * n[1]};
  for (int axis = 0; axis < 3; ++axis) {
    parallel_for(static_cast<std::ptrdiff_t>(cells), [&](std::ptrdiff_t c) {
      const std::ptrdiff_t along = c / stride[axis] % n[axis];
      Box b = box_[static_cast<std::size_t>(c)];
      for (int side : {-1, 1}) {
        if (along + side < 0 || along + side >= n[axis]) continue;
        const Box& other = box_[static_cast<std::size_t>(c + side * stride[axis])];
        b.lower = b.lower.min(other.lower);
        b.upper = b.upper.max(other.upper);
      }
      wide_[static_cast<std::size_t>(c)] = b;
    });
    std::swap(box_, wide_);
  }
  double squared = 0;
  for (std::size_t c = 0; c < cells; ++c)
    if (start_[c + 1] > start_[c]) squared = std::max(squared, (box_[c].upper - box_[c].lower).matrix().squaredNorm());
  return std::sqrt(squared);
}

}  // namespace mv
