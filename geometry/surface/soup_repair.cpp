// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/surface/soup_repair.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <queue>
#include <set>
#include <unordered_map>

#include "geometry/core/errors.h"
#include "geometry/surface/sheet_remesh.h"

namespace mv {
namespace {

using Triangle = std::array<int, 3>;
std::size_t at(long i) { return static_cast<std::size_t>(i); }

std::string place(const Vec3& p) { return fmt::format("({:.1f}, {:.1f}, {:.1f}) mm", p.x(), p.y(), p.z()); }

struct Use {
  int triangle;
  bool is_upwards;
};
using EdgeUses = std::map<std::pair<int, int>, std::vector<Use>>;

EdgeUses edge_uses(const std::vector<Triangle>& triangles) {
  EdgeUses uses;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = triangles[t][k], b = triangles[t][(k + 1) % 3];
      uses[{std::min(a, b), std::max(a, b)}].push_back({static_cast<int>(t), a < b});
    }
  return uses;
}

/// Parts of the surface joined over edges with exactly two triangles.
std::vector<int> sheets_of(const EdgeUses& uses, std::size_t triangles, int& count) {
  std::vector<int> root(triangles);
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int i) {
    while (root[at(i)] != i) i = root[at(i)] = root[at(root[at(i)])];
    return i;
  };
  for (const auto& [edge, use] : uses)
    if (use.size() == 2) root[at(find(use[0].triangle))] = find(use[1].triangle);
  std::map<int, int> number;
  std::vector<int> sheet(triangles);
  for (std::size_t t = 0; t < triangles; ++t)
    sheet[t] = number.try_emplace(find(static_cast<int>(t)), static_cast<int>(number.size())).first->second;
  count = static_cast<int>(number.size());
  return sheet;
}

}  // namespace

double Soup::area(std::size_t t) const {
  const Triangle& v = triangles[t];
  return 0.5 * (points[at(v[1])] - points[at(v[0])]).cross(points[at(v[2])] - points[at(v[0])]).norm();
}

double Soup::size() const {
  Eigen::AlignedBox3d box;
  for (const Triangle& t : triangles)
    for (int v : t) box.extend(points[at(v)]);
  return triangles.empty() ? 0 : box.diagonal().norm();
}

void Soup::keep(const std::vector<char>& marked) {
  std::vector<int> index(points.size(), -1);
  std::vector<Vec3> kept_points;
  std::size_t n = 0;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (!marked[t]) continue;
    Triangle v = triangles[t];
    for (int& i : v) {
      if (index[at(i)] < 0) index[at(i)] = static_cast<int>(kept_points.size()), kept_points.push_back(points[at(i)]);
      i = index[at(i)];
    }
    triangles[n] = v;
    group[n++] = group[t];
  }
  triangles.resize(n), group.resize(n);
  points.swap(kept_points);
}

void weld_points(Soup& s, double distance) {
  // Cells as wide as the distance: a partner lies in one of the 27 around.
  std::map<std::array<long, 3>, std::vector<int>> cells;
  std::vector<int> onto(s.points.size());
  long merged = 0;
  Vec3 first = Vec3::Zero();
  const double width = distance > 0 ? distance : 1;
  const auto partner = [&](const std::array<long, 3>& c, const Vec3& p) {
    for (int k = 0; k < 27; ++k) {
      const auto found = cells.find({c[0] + k % 3 - 1, c[1] + k / 3 % 3 - 1, c[2] + k / 9 - 1});
      if (found == cells.end()) continue;
      for (int j : found->second)
        if ((s.points[at(j)] - p).norm() <= distance) return j;
    }
    return -1;
  };
  std::vector<char> is_used(s.points.size(), 0);
  for (const Triangle& t : s.triangles)
    for (int v : t) is_used[at(v)] = 1;
  for (std::size_t i = 0; i < s.points.size(); ++i) {
    onto[i] = static_cast<int>(i);
    if (!is_used[i]) continue;
    const Vec3& p = s.points[i];
    const std::array<long, 3> c{std::lround(std::floor(p.x() / width)), std::lround(std::floor(p.y() / width)),
                                std::lround(std::floor(p.z() / width))};
    const int j = partner(c, p);
    if (j < 0) {
      cells[c].push_back(static_cast<int>(i));
      continue;
    }
    onto[i] = j;
    if (++merged == 1) first = p;
  }
  if (merged == 0) return;
  for (Triangle& t : s.triangles)
    for (int& v : t) v = onto[at(v)];
  s.tell(fmt::format("{} duplicated points joined (closer than {:.2g} mm), the first at {}", merged, distance, place(first)));
}

void remove_degenerate_triangles(Soup& s) {
  const double flat = 1e-10 * s.size() * s.size() * 1e-2;
  long removed = 0, flipped = 0;
  Vec3 first = Vec3::Zero();
  for (int pass = 0; pass < 5; ++pass) {
    EdgeUses uses = edge_uses(s.triangles);
    std::vector<char> keep(s.triangles.size(), 1), touched(s.triangles.size(), 0);
    bool changed = false;
    for (std::size_t t = 0; t < s.triangles.size(); ++t) {
      const Triangle v = s.triangles[t];
      const bool is_repeated = v[0] == v[1] || v[1] == v[2] || v[2] == v[0];
      if ((!is_repeated && s.area(t) > flat) || touched[t]) continue;
      if (removed + flipped == 0) first = s.points[at(v[0])];
      changed = true;
      if (is_repeated) {
        keep[t] = 0, ++removed;
        continue;
      }
      // The corner opposite the longest edge lies on it: the neighbour there takes the corner in.
      std::size_t k = 0;
      const auto length = [&](std::size_t e) { return (s.points[at(v[e])] - s.points[at(v[(e + 1) % 3])]).norm(); };
      for (std::size_t e = 1; e < 3; ++e)
        if (length(e) > length(k)) k = e;
      const int a = v[k], b = v[(k + 1) % 3], c = v[(k + 2) % 3];
      const auto& around = uses[{std::min(a, b), std::max(a, b)}];
      int other = -1;
      if (around.size() == 2) other = around[0].triangle == static_cast<int>(t) ? around[1].triangle : around[0].triangle;
      if (other < 0 || touched[at(other)] || !keep[at(other)]) {
        keep[t] = 0, ++removed;
        continue;
      }
      Triangle& w = s.triangles[at(other)];
      Triangle left = w, right = w;
      for (int& i : left)
        if (i == b) i = c;
      for (int& i : right)
        if (i == a) i = c;
      w = left;
      s.triangles[t] = right;
      touched[t] = touched[at(other)] = 1;
      ++flipped;
    }
    if (!changed) break;
    s.keep(keep);
  }
  if (removed + flipped > 0)
    s.tell(fmt::format("{} degenerate triangles removed, {} turned into their neighbour, the first at {}", removed, flipped, place(first)));
}

void remove_duplicate_triangles(Soup& s) {
  std::set<Triangle> seen;
  std::vector<char> keep(s.triangles.size(), 1);
  long removed = 0;
  Vec3 first = Vec3::Zero();
  for (std::size_t t = 0; t < s.triangles.size(); ++t) {
    Triangle key = s.triangles[t];
    std::sort(key.begin(), key.end());
    if (seen.insert(key).second) continue;
    keep[t] = 0;
    if (++removed == 1) first = s.points[at(s.triangles[t][0])];
  }
  if (removed == 0) return;
  s.keep(keep);
  s.tell(fmt::format("{} duplicated triangles removed, the first at {}", removed, place(first)));
}

void cut_crowded_edges(Soup& s, double small_share) {
  for (int pass = 0; pass < 10; ++pass) {
    const EdgeUses uses = edge_uses(s.triangles);
    int count = 0;
    const std::vector<int> sheet = sheets_of(uses, s.triangles.size(), count);
    std::vector<double> area(at(count), 0.0);
    double whole = 0;
    for (std::size_t t = 0; t < sheet.size(); ++t) area[at(sheet[t])] += s.area(t), whole += s.area(t);
    std::set<int> hanging;  // smallest sheet at each crowded edge, when it is small
    long crowded = 0;
    Vec3 first = Vec3::Zero();
    for (const auto& [edge, use] : uses) {
      if (use.size() <= 2) continue;
      if (++crowded == 1) first = s.points[at(edge.first)];
      int smallest = sheet[at(use[0].triangle)];
      for (const Use& u : use)
        if (area[at(sheet[at(u.triangle)])] < area[at(smallest)]) smallest = sheet[at(u.triangle)];
      if (area[at(smallest)] < small_share * whole) hanging.insert(smallest);
    }
    if (crowded == 0) return;
    if (!hanging.empty()) {
      std::vector<char> keep(s.triangles.size(), 1);
      long removed = 0;
      for (std::size_t t = 0; t < sheet.size(); ++t)
        if (hanging.count(sheet[t])) keep[t] = 0, ++removed;
      s.keep(keep);
      s.tell(fmt::format("{} triangles in {} small sheets that hang on edges with more than two triangles removed, the first edge at {}", removed,
                         hanging.size(), place(first)));
      continue;
    }
    // Cut: each sheet gets its own copy of the ends of crowded edges.
    std::map<std::pair<int, int>, int> copy;
    std::set<int> ends;
    for (const auto& [edge, use] : uses)
      if (use.size() > 2) ends.insert({edge.first, edge.second});
    for (std::size_t t = 0; t < s.triangles.size(); ++t)
      for (int& v : s.triangles[t]) {
        if (!ends.count(v)) continue;
        const auto [entry, added] = copy.try_emplace({v, sheet[t]}, static_cast<int>(s.points.size()));
        if (added) s.points.push_back(s.points[at(v)]);
        v = entry->second;
      }
    s.tell(fmt::format("surface cut at {} edges with more than two triangles, the first at {}", crowded, place(first)));
    // Within one sheet an edge can stay crowded: its triangles get corners of their own.
    const EdgeUses left = edge_uses(s.triangles);
    for (const auto& [edge, use] : left) {
      if (use.size() <= 2) continue;
      for (std::size_t u = 2; u < use.size(); ++u)
        for (int& v : s.triangles[at(use[u].triangle)])
          if (v == edge.first || v == edge.second) s.points.push_back(s.points[at(v)]), v = static_cast<int>(s.points.size()) - 1;
    }
    return;
  }
}

void orient_parts(Soup& s) {
  const EdgeUses uses = edge_uses(s.triangles);
  std::vector<std::vector<std::pair<int, bool>>> next(s.triangles.size());  // neighbour, oriented alike
  for (const auto& [edge, use] : uses)
    if (use.size() == 2) {
      const bool alike = use[0].is_upwards != use[1].is_upwards;
      next[at(use[0].triangle)].emplace_back(use[1].triangle, alike);
      next[at(use[1].triangle)].emplace_back(use[0].triangle, alike);
    }
  std::vector<int> turn(s.triangles.size(), -1);
  long turned_all = 0, outward = 0;
  for (std::size_t seed = 0; seed < s.triangles.size(); ++seed) {
    if (turn[seed] >= 0) continue;
    std::vector<int> part;
    std::queue<int> queue;
    turn[seed] = 0;
    queue.push(static_cast<int>(seed));
    while (!queue.empty()) {
      const int t = queue.front();
      queue.pop();
      part.push_back(t);
      for (const auto& [other, alike] : next[at(t)]) {
        const int wanted = alike ? turn[at(t)] : 1 - turn[at(t)];
        if (turn[at(other)] < 0) {
          turn[at(other)] = wanted;
          queue.push(other);
        } else if (turn[at(other)] != wanted) {
          throw InputError("surface: it has no two sides (like a Moebius strip or a Klein bottle): going round through triangle " +
                           std::to_string(other) + " near " + place(s.points[at(s.triangles[at(other)][0])]) +
                           " turns the normal over; expected an orientable surface. Separate or re-export the leaflets");
        }
      }
    }
    double area[2] = {0, 0}, volume = 0;
    const Vec3 origin = s.points[at(s.triangles[seed][0])];
    bool is_closed = true;
    for (int t : part) {
      area[turn[at(t)]] += s.area(at(t));
      const Triangle& v = s.triangles[at(t)];
      const double six = (s.points[at(v[0])] - origin).dot((s.points[at(v[1])] - origin).cross(s.points[at(v[2])] - origin));
      volume += turn[at(t)] == 0 ? six : -six;
      is_closed = is_closed && next[at(t)].size() == 3;
    }
    // Closed: outwards. Open: as most of the area.
    const bool flip = is_closed ? volume < 0 : area[1] > area[0];
    long turned = 0;
    for (int t : part) {
      const bool change = (turn[at(t)] == 1) != flip;
      if (!change) continue;
      std::swap(s.triangles[at(t)][1], s.triangles[at(t)][2]);
      ++turned;
    }
    if (turned == static_cast<long>(part.size()))
      outward += turned;
    else
      turned_all += turned;
  }
  if (turned_all > 0) s.tell(fmt::format("{} triangles turned over to agree with their neighbours", turned_all));
  if (outward > 0) s.tell(fmt::format("closed parts with {} triangles turned over to face outwards", outward));
}

void split_pinched_points(Soup& s) {
  const EdgeUses uses = edge_uses(s.triangles);
  std::vector<std::vector<int>> around(s.points.size());
  for (std::size_t t = 0; t < s.triangles.size(); ++t)
    for (int v : s.triangles[t]) around[at(v)].push_back(static_cast<int>(t));
  long split = 0;
  Vec3 first = Vec3::Zero();
  const std::size_t n = s.points.size();
  const std::vector<Triangle> before = s.triangles;
  for (std::size_t v = 0; v < n; ++v) {
    std::map<int, int> fan;  // triangle -> fan
    int fans = 0;
    for (int seed : around[v]) {
      if (fan.count(seed)) continue;
      std::queue<int> queue;
      queue.push(seed);
      fan[seed] = fans;
      while (!queue.empty()) {
        const int t = queue.front();
        queue.pop();
        for (int w : before[at(t)]) {
          const int i = static_cast<int>(v);
          if (w == i) continue;
          const auto& use = uses.at({std::min(w, i), std::max(w, i)});
          if (use.size() != 2) continue;
          for (const Use& u : use)
            if (fan.try_emplace(u.triangle, fans).second) queue.push(u.triangle);
        }
      }
      ++fans;
    }
    if (fans < 2) continue;
    if (++split == 1) first = s.points[v];
    std::vector<int> copy(at(fans), static_cast<int>(v));
    for (int f = 1; f < fans; ++f) copy[at(f)] = static_cast<int>(s.points.size()), s.points.push_back(s.points[v]);
    for (const auto& [t, f] : fan)
      for (int& w : s.triangles[at(t)])
        if (w == static_cast<int>(v)) w = copy[at(f)];
  }
  if (split > 0) s.tell(fmt::format("{} points where sheets touch split, the first at {}", split, place(first)));
}

void drop_specks(Soup& s, double smallest_share) {
  int count = 0;
  const std::vector<int> part = connected_parts(s.triangles, s.points.size(), &count);
  if (count < 2) return;
  std::vector<double> area(at(count), 0.0);
  std::vector<Vec3> where(at(count), Vec3::Zero());
  double whole = 0;
  for (std::size_t t = 0; t < part.size(); ++t) {
    area[at(part[t])] += s.area(t), whole += s.area(t);
    where[at(part[t])] = s.points[at(s.triangles[t][0])];
  }
  std::vector<char> keep(part.size());
  for (std::size_t t = 0; t < part.size(); ++t) keep[t] = area[at(part[t])] >= smallest_share * whole;
  std::string list;
  int dropped = 0;
  for (std::size_t c = 0; c < area.size(); ++c)
    if (area[c] < smallest_share * whole && ++dropped <= 5) list += fmt::format("{}{:.2f} mm2 at {}", dropped > 1 ? "; " : "", area[c], place(where[c]));
  if (dropped == 0) return;
  s.keep(keep);
  s.tell(fmt::format("{} of {} parts dropped as specks: {}{}", dropped, count, list, dropped > 5 ? "; ..." : ""));
}

void close_strip(Soup& s, std::vector<int> a, std::vector<int> b) {
  // The rims run with the surface on their left; seen along the strip they run against each other.
  std::reverse(b.begin(), b.end());
  double best = std::numeric_limits<double>::max();
  std::size_t start = 0;
  for (std::size_t j = 0; j < b.size(); ++j)
    if ((s.points[at(b[j])] - s.points[at(a[0])]).norm() < best) best = (s.points[at(b[j])] - s.points[at(a[0])]).norm(), start = j;
  std::rotate(b.begin(), b.begin() + static_cast<long>(start), b.end());
  std::size_t i = 0, j = 0;
  const std::size_t first = s.triangles.size();
  while (i < a.size() || j < b.size()) {
    const int p = a[i % a.size()], q = b[j % b.size()], p1 = a[(i + 1) % a.size()], q1 = b[(j + 1) % b.size()];
    const bool step_a = j == b.size() || (i < a.size() && (s.points[at(p1)] - s.points[at(q)]).norm() <= (s.points[at(q1)] - s.points[at(p)]).norm());
    if (step_a)
      s.triangles.push_back({p1, p, q}), ++i;
    else
      s.triangles.push_back({p, q, q1}), ++j;
    s.group.push_back(-1);
  }
  s.tell(fmt::format("strip of {} triangles closes the gap between two rims", s.triangles.size() - first));
}

}  // namespace mv
