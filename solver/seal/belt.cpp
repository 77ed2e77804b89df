// SPDX-License-Identifier: BSD-3-Clause
#include "solver/seal/belt.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <string>

#include "geometry/core/errors.h"

namespace mv {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// One leaflet's part of the map.
struct Patchwork {
  std::vector<int> rim;                       // contact points with a neighbour out of contact or on the surface's border
  std::vector<int> patch;                     // of each rim point
  std::vector<double> low_reach, high_reach;  // per patch: distance in u from either commissure
  std::vector<int> low_point, high_point;     // its outermost points
};

int find_root(std::vector<int>& parent, int i) {
  while (parent[static_cast<std::size_t>(i)] != i) {
    parent[static_cast<std::size_t>(i)] = parent[static_cast<std::size_t>(parent[static_cast<std::size_t>(i)])];
    i = parent[static_cast<std::size_t>(i)];
  }
  return i;
}

Patchwork make_patches(const BeltInput& in, const std::vector<int>& members, double u_min, double u_max) {
  std::vector<int> parent(in.unfolded.size());
  std::iota(parent.begin(), parent.end(), 0);
  std::vector<char> used(in.unfolded.size(), 0), on_rim(in.unfolded.size(), 0);
  std::map<std::pair<int, int>, int> edge_uses;
  for (int t : members) {
    const auto& c = in.triangles[static_cast<std::size_t>(t)];
    for (std::size_t e = 0; e < 3; ++e) {
      const int a = c[e], b = c[(e + 1) % 3];
      const bool ca = in.in_contact[static_cast<std::size_t>(a)] != 0, cb = in.in_contact[static_cast<std::size_t>(b)] != 0;
      if (ca) used[static_cast<std::size_t>(a)] = 1;
      if (ca && cb) parent[static_cast<std::size_t>(find_root(parent, a))] = find_root(parent, b);
      if (ca && !cb) on_rim[static_cast<std::size_t>(a)] = 1;
      if (!ca && cb) on_rim[static_cast<std::size_t>(b)] = 1;
      ++edge_uses[{std::min(a, b), std::max(a, b)}];
    }
  }
  for (const auto& [edge, uses] : edge_uses)
    if (uses == 1) on_rim[static_cast<std::size_t>(edge.first)] = on_rim[static_cast<std::size_t>(edge.second)] = 1;

  Patchwork out;
  std::map<int, int> name;
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) continue;
    const auto [at, fresh] = name.try_emplace(find_root(parent, static_cast<int>(i)), static_cast<int>(name.size()));
    if (fresh) {
      out.low_reach.push_back(infinite);
      out.high_reach.push_back(infinite);
      out.low_point.push_back(-1);
      out.high_point.push_back(-1);
    }
    const auto p = static_cast<std::size_t>(at->second);
    const double u = in.unfolded[i].x();
    if (u - u_min < out.low_reach[p]) out.low_reach[p] = u - u_min, out.low_point[p] = static_cast<int>(i);
    if (u_max - u < out.high_reach[p]) out.high_reach[p] = u_max - u, out.high_point[p] = static_cast<int>(i);
    if (!on_rim[i]) continue;
    out.rim.push_back(static_cast<int>(i));
    out.patch.push_back(at->second);
  }
  return out;
}

struct Jump {
  double width = infinite;
  int from = -1, to = -1;  // points; -1 is a commissure
};

/// Prim's tree over the patches from the lower commissure (node 0) to the upper one (last node); returns the jumps on the way.
std::vector<Jump> best_way(const BeltInput& in, const Patchwork& patches, double reach, double edge, double length) {
  const std::size_t count = patches.low_reach.size(), last = count + 1;
  std::vector<std::vector<int>> points(count);
  for (std::size_t r = 0; r < patches.rim.size(); ++r)
    points[static_cast<std::size_t>(patches.patch[r])].push_back(patches.rim[r]);
  std::vector<Jump> cost(count + 2);
  std::vector<std::size_t> parent(count + 2, 0);
  std::vector<char> done(count + 2, 0);
  const auto offer = [&](std::size_t node, const Jump& jump, std::size_t from) {
    if (!done[node] && jump.width < cost[node].width) {
      cost[node] = jump;
      parent[node] = from;
    }
  };
  cost[0] = {0, -1, -1};
  for (;;) {
    std::size_t node = last + 1;
    for (std::size_t i = 0; i <= last; ++i)
      if (!done[i] && cost[i].width < infinite && (node > last || cost[i].width < cost[node].width)) node = i;
    if (node > last) break;
    done[node] = 1;
    if (node == last) break;
    if (node == 0) {
      offer(last, {std::max(0.0, length - 2 * reach), -1, -1}, 0);
      for (std::size_t p = 0; p < count; ++p)
        offer(p + 1, {std::max(0.0, patches.low_reach[p] - reach), -1, patches.low_point[p]}, 0);
      continue;
    }
    const std::size_t p = node - 1;
    offer(last, {std::max(0.0, patches.high_reach[p] - reach), patches.high_point[p], -1}, node);
    for (std::size_t q = 0; q < count; ++q) {
      if (done[q + 1]) continue;
      Jump jump;
      for (int a : points[p])
        for (int b : points[q]) {
          const double d = (in.unfolded[static_cast<std::size_t>(a)] - in.unfolded[static_cast<std::size_t>(b)]).norm() - edge;
          if (d < jump.width) jump = {d, a, b};
        }
      jump.width = std::max(0.0, jump.width);
      offer(q + 1, jump, node);
    }
  }
  std::vector<Jump> way;
  for (std::size_t node = last; node != 0; node = parent[node]) way.push_back(cost[node]);
  std::reverse(way.begin(), way.end());
  return way;
}

double triangle_area(const Vec3& a, const Vec3& b, const Vec3& c) { return 0.5 * (b - a).cross(c - a).norm(); }
Vec3 lift(const Vec2& p) { return {p.x(), p.y(), 0}; }

}  // namespace

BeltResult measure_belt(const BeltInput& in, const BeltOptions& options) {
  const std::size_t n = in.unfolded.size();
  if (in.in_contact.size() != n || (!in.current.empty() && in.current.size() != n) || in.region.size() != in.triangles.size())
    throw InputError("belt: in_contact and current need one entry per point, region one per triangle");
  double edges = 0;
  std::map<int, std::vector<int>> by_region;
  for (std::size_t t = 0; t < in.triangles.size(); ++t) {
    for (std::size_t e = 0; e < 3; ++e) {
      const int a = in.triangles[t][e], b = in.triangles[t][(e + 1) % 3];
      if (a < 0 || b < 0 || static_cast<std::size_t>(std::max(a, b)) >= n)
        throw InputError("belt: triangle " + std::to_string(t) + " names a point that does not exist");
      edges += (in.unfolded[static_cast<std::size_t>(a)] - in.unfolded[static_cast<std::size_t>(b)]).norm();
    }
    by_region[in.region[t]].push_back(static_cast<int>(t));
  }
  BeltResult result;
  if (in.triangles.empty()) return result;
  const double edge = edges / (3.0 * static_cast<double>(in.triangles.size()));
  const double spacing = options.spacing_mm > 0 ? options.spacing_mm : edge;

  double unfolded_sum = 0, length_sum = 0;
  result.continuous = true;
  for (const auto& [region, members] : by_region) {
    LeafletBelt belt;
    belt.region = region;
    belt.u_min = infinite;
    belt.u_max = -infinite;
    for (int t : members) {
      const auto& c = in.triangles[static_cast<std::size_t>(t)];
      int touching = 0;
      std::array<Vec3, 3> flat, now;
      for (std::size_t e = 0; e < 3; ++e) {
        const auto s = static_cast<std::size_t>(c[e]);
        belt.u_min = std::min(belt.u_min, in.unfolded[s].x());
        belt.u_max = std::max(belt.u_max, in.unfolded[s].x());
        touching += in.in_contact[s] != 0;
        flat[e] = lift(in.unfolded[s]);
        now[e] = in.current.empty() ? flat[e] : in.current[s];
      }
      belt.contact_area_unfolded_mm2 += touching / 3.0 * triangle_area(flat[0], flat[1], flat[2]);
      belt.contact_area_mm2 += touching / 3.0 * triangle_area(now[0], now[1], now[2]);
    }
    const double length = belt.u_max - belt.u_min;
    belt.width_mean_mm = length > 0 ? belt.contact_area_unfolded_mm2 / length : 0;
    const Patchwork patches = make_patches(in, members, belt.u_min, belt.u_max);
    belt.continuous = !patches.low_reach.empty();
    for (const Jump& jump : best_way(in, patches, options.commissure_reach_mm, edge, length)) {
      belt.largest_gap_mm = std::max(belt.largest_gap_mm, jump.width);
      if (jump.width <= spacing) continue;
      belt.continuous = false;
      BeltInterruption gap;
      gap.region = region;
      gap.width_mm = jump.width;
      const auto end = [&](int point, double u) { return point < 0 ? Vec2(u, 0) : in.unfolded[static_cast<std::size_t>(point)]; };
      Vec2 a = end(jump.from, belt.u_min), b = end(jump.to, belt.u_max);
      if (jump.from < 0 && jump.to >= 0) a.y() = b.y();
      if (jump.to < 0 && jump.from >= 0) b.y() = a.y();
      if (a.x() > b.x()) std::swap(a, b);
      gap.u_from = a.x(), gap.v_from = a.y();
      gap.u_to = b.x(), gap.v_to = b.y();
      result.interruptions.push_back(gap);
    }
    result.continuous = result.continuous && belt.continuous;
    result.contact_area_mm2 += belt.contact_area_mm2;
    unfolded_sum += belt.contact_area_unfolded_mm2;
    length_sum += length;
    result.leaflets.push_back(belt);
  }
  result.width_mean_mm = length_sum > 0 ? unfolded_sum / length_sum : 0;
  return result;
}

}  // namespace mv
