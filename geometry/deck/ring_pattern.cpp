// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/deck/ring_pattern.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <queue>
#include <set>

#include "geometry/core/errors.h"

namespace mv {
namespace {

std::vector<std::vector<int>> neighbours_of(std::size_t points, const std::vector<std::array<int, 3>>& triangles) {
  std::vector<std::set<int>> sets(points);
  for (const auto& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      sets[static_cast<std::size_t>(t[k])].insert(t[(k + 1) % 3]);
      sets[static_cast<std::size_t>(t[(k + 1) % 3])].insert(t[k]);
    }
  std::vector<std::vector<int>> out;
  for (const auto& set : sets) out.emplace_back(set.begin(), set.end());
  return out;
}

/// Distance along edges from the annulus, and the u of the annulus point it starts at.
struct Reached {
  std::vector<double> distance, u;
};
Reached reach(const std::vector<Vec3>& points, const std::vector<std::vector<int>>& neighbours, const std::vector<int>& annulus, const std::vector<double>& u) {
  Reached r{std::vector<double>(points.size(), 1e300), std::vector<double>(points.size(), 0.0)};
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (std::size_t i = 0; i < annulus.size(); ++i) {
    r.distance[static_cast<std::size_t>(annulus[i])] = 0;
    r.u[static_cast<std::size_t>(annulus[i])] = u[i];
    queue.emplace(0.0, annulus[i]);
  }
  while (!queue.empty()) {
    const auto [distance, at] = queue.top();
    queue.pop();
    if (distance > r.distance[static_cast<std::size_t>(at)]) continue;
    for (const int n : neighbours[static_cast<std::size_t>(at)]) {
      const double d = distance + (points[static_cast<std::size_t>(n)] - points[static_cast<std::size_t>(at)]).norm();
      if (d >= r.distance[static_cast<std::size_t>(n)]) continue;
      r.distance[static_cast<std::size_t>(n)] = d;
      r.u[static_cast<std::size_t>(n)] = r.u[static_cast<std::size_t>(at)];
      queue.emplace(d, n);
    }
  }
  return r;
}

/// Arc length of each point of a closed loop from its first, and the whole length.
std::vector<double> arcs(const std::vector<Vec3>& points, const std::vector<int>& loop, double& length) {
  std::vector<double> arc;
  length = 0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    arc.push_back(length);
    length += (points[static_cast<std::size_t>(loop[(i + 1) % loop.size()])] - points[static_cast<std::size_t>(loop[i])]).norm();
  }
  return arc;
}

double wrapped(double u, double period) { return u - period * std::floor(u / period); }
double nearest_shift(double difference, double period) { return period * std::round(difference / period); }

/// Jagged heights would fold triangles that hang between two points of the free edge.
void smooth(std::vector<std::pair<double, double>>& height) {
  constexpr int rounds = 10;
  const std::size_t n = height.size();
  for (int r = 0; r < rounds; ++r) {
    const auto before = height;
    for (std::size_t i = 0; i < n; ++i) height[i].second = 0.25 * before[(i + n - 1) % n].second + 0.5 * before[i].second + 0.25 * before[(i + 1) % n].second;
  }
}

/// A triangle with two edges on the border lies flat on it in Tutte's map; its outer corner, which holds nothing else, is drawn out of the line of the other two.
void lift_ears(const std::vector<std::array<int, 3>>& triangles, const std::vector<int>& edge, const std::vector<std::vector<int>>& neighbours, RingPattern& pattern) {
  constexpr double lift = 0.25;  // of the edge that the ear stands on
  const std::set<int> on_edge(edge.begin(), edge.end());
  for (const auto& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const int b = t[k], a = t[(k + 1) % 3], c = t[(k + 2) % 3];
      if (neighbours[static_cast<std::size_t>(b)].size() != 2 || !on_edge.contains(a) || !on_edge.contains(b) || !on_edge.contains(c)) continue;
      Vec2& at = pattern.unfolded[static_cast<std::size_t>(b)];
      Vec2 first = pattern.unfolded[static_cast<std::size_t>(a)], second = pattern.unfolded[static_cast<std::size_t>(c)];
      for (Vec2* p : {&first, &second}) p->x() += nearest_shift(at.x() - p->x(), pattern.perimeter);
      const double width = second.x() - first.x(), share = width != 0 ? (at.x() - first.x()) / width : 0.5;
      at.y() = first.y() + share * (second.y() - first.y()) + lift * (second - first).norm();
    }
}

}  // namespace

RingPattern unfold_ring(const std::vector<Vec3>& points, const std::vector<std::array<int, 3>>& triangles, const std::vector<int>& annulus, const std::vector<int>& free_edge) {
  const std::size_t n = points.size();
  RingPattern pattern;
  const std::vector<double> u_annulus = arcs(points, annulus, pattern.perimeter);
  const double period = pattern.perimeter;
  const auto neighbours = neighbours_of(n, triangles);
  const Reached from_annulus = reach(points, neighbours, annulus, u_annulus);
  for (std::size_t i = 0; i < n; ++i)
    if (from_annulus.distance[i] > 1e200) throw InputError("leaflets: a part of the mesh is not joined to the annulus");

  // The free edge against its direction, started such that it lies opposite the annulus on the whole.
  std::vector<int> edge(free_edge.rbegin(), free_edge.rend());
  double edge_length = 0;
  std::vector<double> u_edge = arcs(points, edge, edge_length);
  double sine = 0, cosine = 0;
  for (std::size_t i = 0; i < edge.size(); ++i) {
    u_edge[i] *= period / edge_length;
    const double offset = 2 * std::acos(-1.0) * (from_annulus.u[static_cast<std::size_t>(edge[i])] - u_edge[i]) / period;
    sine += std::sin(offset), cosine += std::cos(offset);
  }
  const double start = period * std::atan2(sine, cosine) / (2 * std::acos(-1.0));

  std::vector<double> guess = from_annulus.u, u(n, 0.0), v(n, 0.0);
  std::vector<char> is_given(n, 0);
  for (std::size_t i = 0; i < annulus.size(); ++i) is_given[static_cast<std::size_t>(annulus[i])] = 1, u[static_cast<std::size_t>(annulus[i])] = u_annulus[i];
  for (std::size_t i = 0; i < edge.size(); ++i) {
    const auto p = static_cast<std::size_t>(edge[i]);
    is_given[p] = 1, v[p] = 1, u[p] = guess[p] = wrapped(u_edge[i] + start, period);
  }
  std::vector<int> unknown(n, -1);
  int unknowns = 0;
  for (std::size_t i = 0; i < n; ++i)
    if (!is_given[i]) unknown[i] = unknowns++;
  // u_i - u_j is near guess_i - guess_j but for whole periods, which go to the right-hand side.
  Eigen::SparseMatrix<double> laplacian(unknowns, unknowns);
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::MatrixX2d right = Eigen::MatrixX2d::Zero(unknowns, 2);
  for (std::size_t i = 0; i < n; ++i) {
    if (unknown[i] < 0) continue;
    entries.emplace_back(unknown[i], unknown[i], static_cast<double>(neighbours[i].size()));
    for (const int j : neighbours[i]) {
      const auto q = static_cast<std::size_t>(j);
      right(unknown[i], 0) += nearest_shift(guess[i] - guess[q], period);
      if (unknown[q] >= 0) {
        entries.emplace_back(unknown[i], unknown[q], -1.0);
      } else {
        right(unknown[i], 0) += u[q];
        right(unknown[i], 1) += v[q];
      }
    }
  }
  laplacian.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(laplacian);
  const Eigen::MatrixX2d solution = unknowns > 0 ? Eigen::MatrixX2d(solver.solve(right)) : right;
  for (std::size_t i = 0; i < n; ++i)
    if (unknown[i] >= 0) u[i] = solution(unknown[i], 0), v[i] = solution(unknown[i], 1);

  // Height over u: the free edge's distance from the annulus, linear between its points.
  std::vector<std::pair<double, double>> height;
  for (const int p : edge) height.emplace_back(u[static_cast<std::size_t>(p)], from_annulus.distance[static_cast<std::size_t>(p)]);
  std::sort(height.begin(), height.end());
  smooth(height);
  for (std::size_t i = 0; i < n; ++i) {
    const double x = wrapped(u[i], period);
    auto after = std::upper_bound(height.begin(), height.end(), std::pair(x, 1e300));
    const auto& right_end = after == height.end() ? height.front() : *after;
    const auto& left_end = after == height.begin() ? height.back() : *(after - 1);
    const double width = wrapped(right_end.first - left_end.first, period), share = width > 0 ? wrapped(x - left_end.first, period) / width : 0.0;
    pattern.unfolded.emplace_back(x < period ? x : 0.0, v[i] * (left_end.second + share * (right_end.second - left_end.second)));
  }
  lift_ears(triangles, edge, neighbours, pattern);
  return pattern;
}

double smallest_unfolded_area(const RingPattern& pattern, const std::vector<std::array<int, 3>>& triangles) {
  double least = 1e300;
  for (const auto& t : triangles) {
    std::array<Vec2, 3> p;
    for (std::size_t k = 0; k < 3; ++k) p[k] = pattern.unfolded[static_cast<std::size_t>(t[k])];
    for (std::size_t k = 1; k < 3; ++k) p[k].x() += nearest_shift(p[0].x() - p[k].x(), pattern.perimeter);
    const Vec2 a = p[1] - p[0], b = p[2] - p[0];
    least = std::min(least, 0.5 * (a.x() * b.y() - a.y() * b.x()));
  }
  return least;
}

}  // namespace mv
