// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/image/medial_path.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <queue>

namespace mv {

MaskPaths::MaskPaths(int width, int height, std::vector<std::uint8_t> inside) : width_(width), height_(height), inside_(std::move(inside)) {
  // A frame of zeros, so that the picture's border counts as the mask's.
  cv::Mat framed = cv::Mat::zeros(height_ + 2, width_ + 2, CV_8U);
  for (int j = 0; j < height_; ++j)
    for (int i = 0; i < width_; ++i) framed.at<std::uint8_t>(j + 1, i + 1) = inside_[static_cast<std::size_t>(j * width_ + i)] ? 255 : 0;
  cv::Mat depth;
  cv::distanceTransform(framed, depth, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  depth_.resize(inside_.size());
  for (int j = 0; j < height_; ++j)
    for (int i = 0; i < width_; ++i) depth_[static_cast<std::size_t>(j * width_ + i)] = depth.at<float>(j + 1, i + 1);
}

int MaskPaths::nearest_inside(const Vec2& x) const {
  int best = -1;
  double nearest = HUGE_VAL;
  for (int c = 0; c < width_ * height_; ++c) {
    if (!is_inside(c)) continue;
    const double d = (position(c) - x).squaredNorm();
    if (d < nearest) nearest = d, best = c;
  }
  return best;
}

std::vector<double> MaskPaths::search(const std::vector<int>& starts, bool along_middle, std::vector<int>* previous, int target) const {
  std::vector<double> cost(inside_.size(), std::numeric_limits<double>::infinity());
  if (previous) previous->assign(inside_.size(), -1);
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (const int s : starts) cost[static_cast<std::size_t>(s)] = 0, queue.emplace(0, s);
  while (!queue.empty()) {
    const auto [value, cell] = queue.top();
    queue.pop();
    if (value > cost[static_cast<std::size_t>(cell)]) continue;
    if (cell == target) break;
    const int i = cell % width_, j = cell / width_;
    for (int dj = -1; dj <= 1; ++dj)
      for (int di = -1; di <= 1; ++di) {
        if ((di == 0 && dj == 0) || i + di < 0 || i + di >= width_ || j + dj < 0 || j + dj >= height_) continue;
        const int next = cell + dj * width_ + di;
        if (!is_inside(next)) continue;
        double step = di != 0 && dj != 0 ? std::sqrt(2.0) : 1.0;
        if (along_middle) {
          const double d = 0.5 * (depth(cell) + depth(next));
          step /= d * d;
        }
        if (value + step < cost[static_cast<std::size_t>(next)]) {
          cost[static_cast<std::size_t>(next)] = value + step;
          if (previous) (*previous)[static_cast<std::size_t>(next)] = cell;
          queue.emplace(value + step, next);
        }
      }
  }
  return cost;
}

std::vector<double> MaskPaths::distances(const std::vector<int>& starts) const { return search(starts, false, nullptr, -1); }

std::vector<int> MaskPaths::middle_path(int a, int b) const {
  std::vector<int> previous;
  const auto cost = search({a}, true, &previous, b);
  if (!std::isfinite(cost[static_cast<std::size_t>(b)])) return {};
  std::vector<int> path;
  for (int c = b; c >= 0; c = previous[static_cast<std::size_t>(c)]) path.push_back(c);
  std::reverse(path.begin(), path.end());
  return path;
}

std::vector<Vec2> MaskPaths::extended_end(const std::vector<Vec2>& path) const {
  const auto cell_at = [&](const Vec2& x) {
    const int i = static_cast<int>(std::lround(x.x())), j = static_cast<int>(std::lround(x.y()));
    return i < 0 || j < 0 || i >= width_ || j >= height_ ? -1 : j * width_ + i;
  };
  // Where the path still is in the middle: twice the depth there reaches no further than the end; a cheapest path leaves the middle for a corner about that early.
  std::size_t keep = path.size() - 1;
  double rest = 0;
  while (keep > 1) {
    const int cell = cell_at(path[keep]);
    if (cell >= 0 && rest >= 2 * depth(cell)) break;
    rest += (path[keep] - path[keep - 1]).norm();
    --keep;
  }
  if (keep < 3) return path;
  const double depth_here = std::max(2.0, depth(cell_at(path[keep])));
  std::size_t from = keep;
  for (double back = 0; from > 0 && back < 3 * depth_here; --from) back += (path[from] - path[from - 1]).norm();
  const Vec2 direction = (path[keep] - path[from]).normalized();
  std::vector<Vec2> result(path.begin(), path.begin() + static_cast<std::ptrdiff_t>(keep) + 1);
  Vec2 x = path[keep];
  constexpr double step = 0.5;
  for (int k = 0; k < 4 * (width_ + height_); ++k) {
    const Vec2 next = x + step * direction;
    const int cell = cell_at(next);
    if (cell < 0 || !is_inside(cell)) break;
    x = next;
    if (k % 2 == 1) result.push_back(x);
  }
  // A mask that bends away before its end: then the path itself is the better guess.
  const double straight = (x - path[keep]).norm();
  if (straight < 0.5 * rest) return path;
  if ((x - result.back()).norm() > 1e-9) result.push_back(x);
  return result;
}

}  // namespace mv
