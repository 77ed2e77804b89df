// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/image/mesh_smoothing.h"

#include <algorithm>
#include <cmath>

#include "geometry/core/parallel.h"

namespace mv {
namespace {

constexpr int most_iterations = 1000;
constexpr double stop_at = 1e-4;  // largest movement of an iteration

/// Neighbours of every point, one after the other.
struct Graph {
  std::vector<int> start, neighbour;
};

Graph neighbours_of(std::size_t points, const std::vector<std::array<int, 3>>& triangles) {
  std::vector<std::pair<int, int>> edges;
  edges.reserve(6 * triangles.size());
  for (const auto& t : triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      edges.emplace_back(t[i], t[(i + 1) % 3]);
      edges.emplace_back(t[(i + 1) % 3], t[i]);
    }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  Graph graph;
  graph.start.assign(points + 1, 0);
  for (const auto& [a, b] : edges) {
    ++graph.start[static_cast<std::size_t>(a) + 1];
    graph.neighbour.push_back(b);
  }
  for (std::size_t p = 0; p < points; ++p) graph.start[p + 1] += graph.start[p];
  return graph;
}

/// out = x - mean of the neighbours; eigenvalues between 0 and 2.
void laplacian(const Graph& graph, const std::vector<Vec3>& x, std::vector<Vec3>& out) {
  parallel_for(static_cast<std::ptrdiff_t>(x.size()), [&](std::ptrdiff_t i) {
    const auto p = static_cast<std::size_t>(i);
    Vec3 sum = Vec3::Zero();
    for (int n = graph.start[p]; n < graph.start[p + 1]; ++n) sum += x[static_cast<std::size_t>(graph.neighbour[static_cast<std::size_t>(n)])];
    const int count = graph.start[p + 1] - graph.start[p];
    out[p] = count > 0 ? Vec3(x[p] - sum / count) : Vec3(Vec3::Zero());
  });
}

}  // namespace

int smooth_mesh(std::vector<Vec3>& points, const std::vector<std::array<int, 3>>& triangles, const MeshSmoothing& options) {
  if (options.length <= 0 || points.empty()) return 0;
  const Graph graph = neighbours_of(points.size(), triangles);
  const double hold = std::pow(options.length, -4), step = 1 / (4 + hold);
  const std::vector<Vec3> start = points;
  std::vector<Vec3> y = points, first(points.size()), second(points.size());
  const auto count = static_cast<std::ptrdiff_t>(points.size());
  double t = 1;
  int iteration = 0;
  while (iteration < most_iterations) {  // accelerated projected gradient (Beck, Teboulle 2009), restarted (O'Donoghue, Candes 2015)
    ++iteration;
    laplacian(graph, y, first);
    laplacian(graph, first, second);
    parallel_for(count, [&](std::ptrdiff_t i) {
      const auto p = static_cast<std::size_t>(i);
      Vec3 d = y[p] - step * (second[p] + hold * (y[p] - start[p])) - start[p];
      if (const double far = d.norm(); far > options.reach) d *= options.reach / far;
      first[p] = start[p] + d;  // the new point
    });
    const double uphill = parallel_sum(count, [&](std::ptrdiff_t i) {
      const auto p = static_cast<std::size_t>(i);
      return (y[p] - first[p]).dot(first[p] - points[p]);
    });
    if (uphill > 0) t = 1;
    const double t_next = 0.5 * (1 + std::sqrt(1 + 4 * t * t)), push = (t - 1) / t_next;
    t = t_next;
    double moved = 0;
    for (std::size_t p = 0; p < points.size(); ++p) {
      const Vec3 change = first[p] - points[p];
      moved = std::max(moved, change.norm());
      y[p] = first[p] + push * change;
      points[p] = first[p];
    }
    if (moved < stop_at) break;
  }
  return iteration;
}

}  // namespace mv
