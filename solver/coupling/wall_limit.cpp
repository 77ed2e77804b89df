// SPDX-License-Identifier: BSD-3-Clause
#include "solver/coupling/wall_limit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "geometry/core/errors.h"
#include "geometry/core/parallel.h"
#include "solver/fluid/tube_wall.h"

namespace mv {
namespace {

constexpr double cells_across = 64;   // of the section's bounding box, which is widened by a quarter on each side
constexpr double margin = 0.25;

Eigen::Vector2d nearest_on(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d e = b - a;
  const double length = e.squaredNorm();
  return a + (length > 0 ? std::clamp((p - a).dot(e) / length, 0.0, 1.0) : 0.0) * e;
}

}  // namespace

WallLimit::WallLimit(std::vector<Eigen::Vector2d> section, std::span<const double> rest, std::span<const char> is_fixed) : section_(std::move(section)) {
  if (section_.size() < 3 || rest.size() != 3 * is_fixed.size())
    throw InputError(fmt::format("wall limit: {} corners of the tube, {} coordinates of {} nodes; at least 3 corners and 3 coordinates a node are expected", section_.size(), rest.size(),
                                 is_fixed.size()));
  Eigen::Vector2d low = section_[0], high = section_[0];
  for (const auto& p : section_) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const double size = (high - low).maxCoeff();
  width_ = (1 + 2 * margin) * size / cells_across;
  lower_ = low - Eigen::Vector2d::Constant(margin * size);
  cells_ = (((high - low).array() + 2 * margin * size) / width_).ceil().cast<int>().cwiseMax(1).matrix();
  all_edges_.resize(section_.size());
  std::iota(all_edges_.begin(), all_edges_.end(), 0);

  edges_.resize(static_cast<std::size_t>(cells_.x()) * static_cast<std::size_t>(cells_.y()));
  const double reach = 0.5 * std::sqrt(2.0) * width_;
  for (int j = 0; j < cells_.y(); ++j)
    for (int i = 0; i < cells_.x(); ++i) {
      const Eigen::Vector2d centre = lower_ + width_ * Eigen::Vector2d(i + 0.5, j + 0.5);
      std::vector<double> distance(section_.size());
      for (std::size_t e = 0; e < section_.size(); ++e) distance[e] = (nearest_on(centre, section_[e], section_[(e + 1) % section_.size()]) - centre).norm();
      const double least = *std::min_element(distance.begin(), distance.end());
      if (least > reach && is_inside_polygon(centre, section_)) continue;
      std::vector<int>& edges = edges_[static_cast<std::size_t>(i + cells_.x() * j)];
      for (std::size_t e = 0; e < section_.size(); ++e)
        if (distance[e] <= least + 2 * reach) edges.push_back(static_cast<int>(e));
    }

  allowed_.assign(is_fixed.size(), std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < is_fixed.size(); ++i)
    if (!is_fixed[i]) allowed_[i] = std::max(nearest({rest[3 * i], rest[3 * i + 1]}).outside, 0.0);
}

std::ptrdiff_t WallLimit::cell_of(const Eigen::Vector2d& p) const {
  const Eigen::Vector2d q = (p - lower_) / width_;
  if (!(q.x() >= 0 && q.x() < cells_.x() && q.y() >= 0 && q.y() < cells_.y())) return -1;
  return static_cast<std::ptrdiff_t>(q.x()) + cells_.x() * static_cast<std::ptrdiff_t>(q.y());
}

WallLimit::Nearest WallLimit::nearest(const Eigen::Vector2d& p) const {
  const std::ptrdiff_t cell = cell_of(p);
  const std::vector<int>& edges = cell < 0 ? all_edges_ : edges_[static_cast<std::size_t>(cell)];
  Nearest best{-std::numeric_limits<double>::infinity(), p};
  if (edges.empty()) return best;
  double least = std::numeric_limits<double>::infinity();
  for (int e : edges) {
    const Eigen::Vector2d q = nearest_on(p, section_[static_cast<std::size_t>(e)], section_[(static_cast<std::size_t>(e) + 1) % section_.size()]);
    const double distance = (q - p).norm();
    if (distance < least) least = distance, best.on_wall = q;
  }
  best.outside = is_inside_polygon(p, section_) ? -least : least;
  return best;
}

void WallLimit::apply(std::span<double> x) {
  moved_.clear();
  shifts_.clear();
  is_beyond_.resize(allowed_.size());
  parallel_for(static_cast<std::ptrdiff_t>(allowed_.size()), [&](std::ptrdiff_t n) {
    const auto i = static_cast<std::size_t>(n);
    is_beyond_[i] = 0;
    if (std::isinf(allowed_[i])) return;
    const Eigen::Vector2d p(x[3 * i], x[3 * i + 1]);
    if (const std::ptrdiff_t cell = cell_of(p); cell >= 0 && edges_[static_cast<std::size_t>(cell)].empty()) return;
    is_beyond_[i] = nearest(p).outside > allowed_[i];
  });
  for (std::size_t i = 0; i < allowed_.size(); ++i) {
    if (!is_beyond_[i]) continue;
    const Eigen::Vector2d p(x[3 * i], x[3 * i + 1]);
    const Nearest wall = nearest(p);
    const Eigen::Vector2d shift = (1 - allowed_[i] / wall.outside) * (wall.on_wall - p);
    x[3 * i] += shift.x();
    x[3 * i + 1] += shift.y();
    moved_.push_back(static_cast<int>(i));
    shifts_.emplace_back(shift.x(), shift.y(), 0.0);
  }
}

}  // namespace mv
