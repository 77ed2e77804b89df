// SPDX-License-Identifier: BSD-3-Clause
#include "solver/seal/widest_path.h"

#include <algorithm>
#include <limits>
#include <queue>

namespace mv::seal {

namespace {

struct Entry {
  float key;
  Voxel voxel;
  std::int8_t from;  // direction of the step that led here, -1 at the start
  bool operator<(const Entry& o) const { return key != o.key ? key < o.key : voxel < o.voxel; }
};

struct Route {
  float bottleneck = 0;
  std::vector<Voxel> voxels;  // from the ventricular end to the atrial end
};

/// Best-first search from the atrial layer. bound(v) >= value(v); value(v) is only asked for where it can matter.
template <class Bound, class Value>
Route search(const VoxelField& field, Bound&& bound, Value&& value) {
  const VoxelGrid& grid = field.grid();
  std::vector<std::int8_t> from(static_cast<std::size_t>(grid.size()), -2);
  std::priority_queue<Entry> queue;
  const Voxel layer = grid.n[0] * grid.n[1], top = grid.size() - layer;
  for (Voxel v = top; v < grid.size(); ++v)
    if (!field.is_wall(v) && bound(v) > 0) queue.push({bound(v), v, -1});
  while (!queue.empty()) {
    const Entry e = queue.top();
    queue.pop();
    if (from[static_cast<std::size_t>(e.voxel)] != -2) continue;
    const float key = std::min(e.key, value(e.voxel));
    if (key <= 0) continue;
    if (key < e.key) {
      queue.push({key, e.voxel, e.from});
      continue;
    }
    from[static_cast<std::size_t>(e.voxel)] = e.from;
    if (e.voxel < layer) {
      Route route{key, {e.voxel}};
      for (int d; (d = from[static_cast<std::size_t>(route.voxels.back())]) >= 0;)
        route.voxels.push_back(grid.step_back(route.voxels.back(), d));
      return route;
    }
    grid.neighbours(e.voxel, [&](Voxel w, int direction) {
      if (from[static_cast<std::size_t>(w)] != -2 || field.is_wall(w)) return;
      const float next = std::min(key, bound(w));
      if (next > 0) queue.push({next, w, static_cast<std::int8_t>(direction)});
    });
  }
  return {};
}

/// Smallest clearance along the broken line through the voxels' best points. Where a straight piece dips below the bottleneck, its
/// middle is first moved to where the clearance is larger.
double follow(const VoxelField& field, const std::vector<Voxel>& route, double bottleneck) {
  const double h = field.grid().h, step = h / 16, cap = bottleneck + 2 * h;
  double least = bottleneck;
  const auto walk = [&](const Vec3& a, const Vec3& b) {
    const int pieces = std::max(1, static_cast<int>(std::ceil((b - a).norm() / step)));
    double lowest = bottleneck;
    for (int s = 0; s <= pieces; ++s)
      lowest = std::min(lowest, field.clearance(a + (static_cast<double>(s) / pieces) * (b - a), cap));
    return lowest;
  };
  for (std::size_t i = 0; i + 1 < route.size(); ++i) {
    if (std::min(field.cheap_peak(route[i]), field.cheap_peak(route[i + 1])) > cap) continue;
    const Vec3 a = field.peak_place(route[i]), b = field.peak_place(route[i + 1]);
    double lowest = walk(a, b);
    if (lowest < bottleneck - 0.5 * step) {
      const Vec3 middle = 0.5 * (a + b), better = field.climb(middle, middle, 0.5 * h, cap);
      lowest = std::max(lowest, std::min(walk(a, better), walk(better, b)));
    }
    least = std::min(least, lowest);
  }
  return std::max(0.0, least);
}

}  // namespace

Passage find_widest_passage(const VoxelField& field) {
  Passage out;
  if (field.leaflets().empty()) {
    out.upper = out.lower = std::numeric_limits<double>::infinity();
    return out;
  }
  // A first search over the centres alone bounds the answer: every point is within half a diagonal of a centre.
  const auto centre = [&](Voxel v) { return field.distance(v); };
  const Route coarse = search(field, centre, centre);
  const auto enough = coarse.bottleneck + static_cast<float>(half_diagonal * field.grid().h);
  const auto bound = [&](Voxel v) { return std::min(enough, field.peak_bound(v)); };
  const auto value = [&](Voxel v) { return field.distance(v) >= enough ? enough : std::min(enough, field.peak(v)); };
  const Route route = search(field, bound, value);
  if (route.voxels.empty()) return out;
  out.upper = route.bottleneck;
  out.lower = follow(field, route.voxels, out.upper);
  Voxel narrowest = route.voxels[0];
  for (Voxel v : route.voxels)
    if (field.cheap_peak(v) < field.cheap_peak(narrowest)) narrowest = v;
  out.place = field.peak_place(narrowest);
  return out;
}

}  // namespace mv::seal
