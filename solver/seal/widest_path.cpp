// SPDX-License-Identifier: BSD-3-Clause
#include "solver/seal/widest_path.h"

#include <algorithm>
#include <cmath>
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
  // No key exceeds that of the entry it came from: what equals it is next, and most of the blood is wider than what counts. First in, first out keeps routes short.
  std::queue<Entry> level;
  const Voxel layer = grid.n[0] * grid.n[1], top = grid.size() - layer;
  for (Voxel v = top; v < grid.size(); ++v)
    if (!field.is_wall(v) && bound(v) > 0) queue.push({bound(v), v, -1});
  while (!level.empty() || !queue.empty()) {
    const Entry e = level.empty() ? queue.top() : level.front();
    if (level.empty()) queue.pop();
    else level.pop();
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
      const Entry step{next, w, static_cast<std::int8_t>(direction)};
      if (next == key) level.push(step);
      else if (next > 0) queue.push(step);
    });
  }
  return {};
}

/// Widest way from a to b over a fine lattice around two neighbouring voxels and one voxel more on each side (at the mouth of a
/// gap the way may lead through a third voxel); empty when there is none.
std::vector<Vec3> detour(const VoxelField& field, Voxel from, Voxel to, const Vec3& a, const Vec3& b, double cap) {
  constexpr int per_voxel = 6;
  const double h = field.grid().h, step = h / per_voxel;
  const Vec3 c0 = field.grid().centre(from), c1 = field.grid().centre(to);
  const Vec3 lower = (c0.cwiseMin(c1).array() - 1.5 * h).matrix();
  std::array<int, 3> n;
  for (int k = 0; k < 3; ++k) n[static_cast<std::size_t>(k)] = per_voxel * (std::abs(c0[k] - c1[k]) > 0.5 * h ? 4 : 3) + 1;
  const int lattice = n[0] * n[1] * n[2];
  const auto at = [&](int i) {
    return i == lattice ? a : i == lattice + 1 ? b : Vec3(lower + step * Vec3(i % n[0], i / n[0] % n[1], i / (n[0] * n[1])));
  };
  std::vector<double> clearance(static_cast<std::size_t>(lattice + 2)), best(clearance.size(), 0.0);
  for (int i = 0; i < lattice + 2; ++i)
    clearance[static_cast<std::size_t>(i)] = i < lattice && field.is_wall_at(at(i)) ? 0.0 : field.clearance(at(i), cap);
  std::vector<int> previous(clearance.size(), -1);
  std::priority_queue<std::pair<double, int>> queue;
  best[static_cast<std::size_t>(lattice)] = clearance[static_cast<std::size_t>(lattice)];
  queue.push({best[static_cast<std::size_t>(lattice)], lattice});
  const auto offer = [&](int i, int j, double key) {
    const double next = std::min(key, clearance[static_cast<std::size_t>(j)]);
    if (next <= best[static_cast<std::size_t>(j)]) return;
    best[static_cast<std::size_t>(j)] = next;
    previous[static_cast<std::size_t>(j)] = i;
    queue.push({next, j});
  };
  while (!queue.empty()) {
    const auto [key, i] = queue.top();
    queue.pop();
    if (i == lattice + 1) break;
    if (key < best[static_cast<std::size_t>(i)]) continue;
    const Vec3 p = at(i);
    if ((b - p).norm() <= 2 * step) offer(i, lattice + 1, key);
    std::array<int, 3> lo, hi;
    for (int k = 0; k < 3; ++k) {
      const auto s = static_cast<std::size_t>(k);
      const double x = (p[k] - lower[k]) / step;
      lo[s] = std::max(0, static_cast<int>(std::ceil(x - 1 - 1e-9)));
      hi[s] = std::min(n[s] - 1, static_cast<int>(std::floor(x + 1 + 1e-9)));
    }
    for (int z = lo[2]; z <= hi[2]; ++z)
      for (int y = lo[1]; y <= hi[1]; ++y)
        for (int x = lo[0]; x <= hi[0]; ++x) offer(i, (z * n[1] + y) * n[0] + x, key);
  }
  std::vector<Vec3> way;
  if (best.back() <= 0) return way;
  for (int i = lattice + 1; i >= 0; i = previous[static_cast<std::size_t>(i)]) {
    const Vec3 p = at(i);
    way.push_back(i < lattice ? field.climb(p, p, 0.5 * step, cap) : p);
  }
  return way;
}

/// Smallest clearance along a line through the best points of the route's voxels. Where a straight piece dips below the
/// bottleneck, the way from point to point is sought on a fine lattice.
double follow(const VoxelField& field, const std::vector<Voxel>& route, double bottleneck) {
  const double h = field.grid().h, step = h / 32, cap = bottleneck + 2 * h;
  const auto walk = [&](const Vec3& a, const Vec3& b) {
    const int pieces = std::max(1, static_cast<int>(std::ceil((b - a).norm() / step)));
    double lowest = bottleneck;
    for (int s = 0; s <= pieces; ++s)
      lowest = std::min(lowest, field.clearance(a + (static_cast<double>(s) / pieces) * (b - a), cap));
    return lowest;
  };
  double least = bottleneck;
  for (std::size_t i = 0; i + 1 < route.size() && least > 0; ++i) {
    if (std::min(field.cheap_peak(route[i]), field.cheap_peak(route[i + 1])) > cap) continue;
    for (Voxel v : {route[i], route[i + 1]})
      if (field.distance(v) < cap) field.peak(v);
    const Vec3 a = field.peak_place(route[i]), b = field.peak_place(route[i + 1]);
    double lowest = walk(a, b);
    if (lowest < bottleneck - 0.5 * step) {
      const std::vector<Vec3> way = detour(field, route[i], route[i + 1], a, b, cap);
      double other = way.empty() ? 0 : bottleneck;
      for (std::size_t k = 0; k + 1 < way.size(); ++k) other = std::min(other, walk(way[k], way[k + 1]));
      lowest = std::max(lowest, other);
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
  const auto h = static_cast<float>(field.grid().h);
  float enough = search(field, centre, centre).bottleneck + static_cast<float>(half_diagonal) * h;
  const auto bound = [&](Voxel v) { return std::min(enough, field.peak_bound(v)); };
  // Samples narrow the range, so that few voxels need the full search for their peak.
  const auto sample = [&](Voxel v) { return field.distance(v) >= enough ? enough : std::min(enough, field.sampled(v)); };
  const float sampled = search(field, bound, sample).bottleneck;
  enough = std::min(enough, sampled + static_cast<float>(sample_reach) * h);
  const auto value = [&](Voxel v) {
    return field.distance(v) >= enough || (field.peak_bound(v) >= enough && field.sampled(v) >= enough)
               ? enough
               : std::min(enough, field.peak(v));
  };
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
