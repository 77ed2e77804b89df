// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/thick/relocate.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <set>

#include "geometry/volume/gates.h"

namespace mv {
namespace {

constexpr int rounds = 8, split_rounds = 6;
constexpr double surface_share = 0.1;  // of the longest edge around it by which a point of the surface may move in all

std::size_t at(long i) { return static_cast<std::size_t>(i); }

double smallest_angle(const TetFill& f, const std::array<int, 4>& t) {
  const Vec3 &a = f.points[at(t[0])], &b = f.points[at(t[1])], &c = f.points[at(t[2])], &d = f.points[at(t[3])];
  if ((b - a).cross(c - a).dot(d - a) <= 0) return -1;
  const auto angles = dihedral_angles(a, b, c, d);
  return *std::min_element(angles.begin(), angles.end());
}

/// Directions to the corners, edges and faces of a cube.
std::vector<Vec3> directions() {
  std::vector<Vec3> all;
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z)
        if (x || y || z) all.push_back(Vec3(x, y, z).normalized());
  return all;
}

}  // namespace

long relocate_points(TetFill& f, const std::vector<char>& is_held, double wanted) {
  const std::size_t first_inner = is_held.size();
  std::vector<std::vector<int>> around(f.points.size());
  for (std::size_t e = 0; e < f.tets.size(); ++e)
    for (const int n : f.tets[e]) around[at(n)].push_back(static_cast<int>(e));
  const auto worst_around = [&](std::size_t p) {
    double least = 180;
    for (const int e : around[p]) least = std::min(least, smallest_angle(f, f.tets[at(e)]));
    return least;
  };
  const std::vector<Vec3> ways = directions(), surface(f.points.begin(), f.points.begin() + static_cast<std::ptrdiff_t>(first_inner));
  long left = 0;
  for (int round = 0; round < rounds; ++round) {
    std::set<std::size_t> to_move;
    left = 0;
    for (const auto& t : f.tets) {
      if (smallest_angle(f, t) >= wanted) continue;
      ++left;
      const bool has_inner = std::any_of(t.begin(), t.end(), [&](int n) { return at(n) >= first_inner; });
      for (const int n : t)
        if (at(n) >= first_inner || (!has_inner && !is_held[at(n)])) to_move.insert(at(n));
    }
    bool has_improved = false;
    for (const std::size_t p : to_move) {
      double best = worst_around(p), reach = 0;
      const Vec3 start = f.points[p];
      for (const int e : around[p])
        for (const int n : f.tets[at(e)]) reach = std::max(reach, (f.points[at(n)] - start).norm());
      const double had = best;
      for (double step = (p < first_inner ? 0.05 : 0.25) * reach; step > 0.01 * reach; step *= 0.5) {
        Vec3 place = f.points[p];
        for (const Vec3& way : ways) {
          const Vec3 centre = f.points[p];
          f.points[p] = centre + step * way;
          if (p < first_inner && (f.points[p] - surface[p]).norm() > surface_share * reach) {
            f.points[p] = centre;
            continue;
          }
          if (const double angle = worst_around(p); angle > best) {
            best = angle;
            place = f.points[p];
          }
          f.points[p] = centre;
        }
        f.points[p] = place;
      }
      has_improved = has_improved || best > had + 0.01;
    }
    if (!has_improved) break;
  }
  return left;
}

long split_long_steps(TetFill& f, std::size_t surface_points, const std::vector<std::array<int, 3>>& surface, double longest) {
  using Edge = std::pair<int, int>;
  std::set<Edge> outer;
  for (const auto& t : surface)
    for (std::size_t k = 0; k < 3; ++k) outer.insert(std::minmax(t[k], t[(k + 1) % 3]));
  const auto is_inner = [&](const Edge& e) { return at(e.second) >= surface_points || outer.count(e) == 0; };
  const auto length = [&](const Edge& e) { return (f.points[at(e.first)] - f.points[at(e.second)]).norm(); };
  long added = 0;
  for (int round = 0; round < split_rounds; ++round) {
    std::set<Edge> chosen;
    for (const auto& t : f.tets) {
      if (spanning_step({f.points[at(t[0])], f.points[at(t[1])], f.points[at(t[2])], f.points[at(t[3])]}) <= longest) continue;
      Edge best{-1, -1};
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = i + 1; j < 4; ++j)
          if (const Edge e = std::minmax(t[i], t[j]); is_inner(e) && (best.first < 0 || length(e) > length(best))) best = e;
      if (best.first >= 0) chosen.insert(best);
    }
    if (chosen.empty()) break;
    // Edges of one tetrahedron are split in different rounds.
    std::map<Edge, std::vector<std::size_t>> around;
    for (std::size_t e = 0; e < f.tets.size(); ++e)
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = i + 1; j < 4; ++j)
          if (const Edge edge = std::minmax(f.tets[e][i], f.tets[e][j]); chosen.count(edge)) around[edge].push_back(e);
    std::vector<char> is_split(f.tets.size(), 0);
    for (const Edge& edge : chosen) {
      const auto& tets = around[edge];
      if (std::any_of(tets.begin(), tets.end(), [&](std::size_t e) { return is_split[e] != 0; })) continue;
      const int point = static_cast<int>(f.points.size());
      f.points.push_back(0.5 * (f.points[at(edge.first)] + f.points[at(edge.second)]));
      ++added;
      for (const std::size_t e : tets) {
        is_split[e] = 1;
        std::array<int, 4> other = f.tets[e];
        std::replace(f.tets[e].begin(), f.tets[e].end(), edge.first, point);
        std::replace(other.begin(), other.end(), edge.second, point);
        f.tets.push_back(other);
      }
    }
  }
  return added;
}

}  // namespace mv
