// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/thick/relocate.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <set>

#include "geometry/volume/gates.h"

namespace mv {
namespace {

constexpr int rounds = 8;

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
  const std::vector<Vec3> ways = directions();
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

}  // namespace mv
