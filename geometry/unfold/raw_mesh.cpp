// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/unfold/raw_mesh.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <unordered_map>

#include "geometry/core/errors.h"

namespace mv {
namespace {

using Triangle = std::array<int, 3>;
using Edge = std::pair<int, int>;

/// Points closer than this share of the extent are one point.
constexpr double weld_share = 1e-6;
/// Flaps on edges with three or more triangles may be dropped up to this share of the area.
constexpr double flap_share = 0.02;

std::size_t at(long i) { return static_cast<std::size_t>(i); }
Edge undirected(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

std::string place(const Vec3& x) { return fmt::format("({:.1f}, {:.1f}, {:.1f}) mm", x.x(), x.y(), x.z()); }

void check(const RawLeaflets& raw) {
  if (raw.triangles.empty() || raw.points.empty()) throw InputError("leaflets: no triangles; the source found no surface");
  if (!raw.region.empty() && raw.region.size() != raw.triangles.size())
    throw InputError(fmt::format("leaflets: {} region labels for {} triangles", raw.region.size(), raw.triangles.size()));
  if (!raw.thickness.empty() && raw.thickness.size() != raw.points.size())
    throw InputError(fmt::format("leaflets: {} thickness values for {} points", raw.thickness.size(), raw.points.size()));
  for (std::size_t i = 0; i < raw.points.size(); ++i)
    if (!raw.points[i].allFinite())
      throw InputError(fmt::format("leaflets: the coordinates of point {} are not finite; repair the surface", i));
  for (std::size_t i = 0; i < raw.thickness.size(); ++i)
    if (!std::isfinite(raw.thickness[i])) throw InputError(fmt::format("leaflets: the thickness of point {} is not finite", i));
  for (std::size_t t = 0; t < raw.triangles.size(); ++t)
    for (int v : raw.triangles[t])
      if (v < 0 || at(v) >= raw.points.size())
        throw InputError(fmt::format("leaflets: triangle {} refers to point {} of {}", t, v, raw.points.size()));
}

/// Index of the first point of each cluster; a grid of the weld distance finds the candidates.
std::vector<int> weld(const std::vector<Vec3>& points) {
  Vec3 lower = points.front(), upper = points.front();
  for (const Vec3& p : points) {
    lower = lower.cwiseMin(p);
    upper = upper.cwiseMax(p);
  }
  const double distance = std::max(weld_share * (upper - lower).norm(), 1e-12);
  std::map<std::array<long, 3>, std::vector<int>> grid;
  std::vector<int> first(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 cell = (points[i] - lower) / distance;
    const std::array<long, 3> key{std::lround(cell.x()), std::lround(cell.y()), std::lround(cell.z())};
    first[i] = static_cast<int>(i);
    for (long dx = -1; dx <= 1; ++dx)
      for (long dy = -1; dy <= 1; ++dy)
        for (long dz = -1; dz <= 1; ++dz) {
          const auto found = grid.find({key[0] + dx, key[1] + dy, key[2] + dz});
          if (found == grid.end()) continue;
          for (int j : found->second)
            if ((points[at(j)] - points[i]).norm() <= distance) first[i] = std::min(first[i], j);
        }
    if (first[i] == static_cast<int>(i)) grid[key].push_back(first[i]);
  }
  return first;
}

std::map<Edge, std::vector<int>> edge_triangles(const std::vector<Triangle>& triangles) {
  std::map<Edge, std::vector<int>> edges;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k)
      edges[undirected(triangles[t][k], triangles[t][(k + 1) % 3])].push_back(static_cast<int>(t));
  return edges;
}

void keep(RawMesh& mesh, const std::vector<char>& kept) {
  RawMesh out;
  std::vector<int> index(mesh.points.size(), -1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!kept[t]) continue;
    Triangle tri = mesh.triangles[t];
    for (int& v : tri) {
      if (index[at(v)] < 0) index[at(v)] = out.add_point(mesh.points[at(v)], mesh.thickness.empty() ? -1 : mesh.thickness[at(v)]);
      v = index[at(v)];
    }
    out.add_triangle(tri, mesh.region[t], mesh.weight[t]);
  }
  mesh = std::move(out);
}

/// Drops the smallest triangles of edges with more than two.
void drop_flaps(RawMesh& mesh, std::vector<std::string>& notes) {
  const double whole = mesh.area();
  double dropped_area = 0;
  long dropped = 0;
  for (bool again = true; again;) {
    again = false;
    std::vector<char> kept(mesh.triangles.size(), 1);
    for (auto& [edge, list] : edge_triangles(mesh.triangles)) {
      std::erase_if(list, [&](int t) { return !kept[at(t)]; });
      std::stable_sort(list.begin(), list.end(), [&](int a, int b) { return mesh.area(at(a)) > mesh.area(at(b)); });
      for (std::size_t k = 2; k < list.size(); ++k) {
        kept[at(list[k])] = 0;
        dropped_area += mesh.area(at(list[k]));
        ++dropped;
        again = true;
      }
      if (dropped_area > flap_share * whole)
        throw InputError("leaflets: sheets branch off the surface (edges with more than two triangles) near " +
                         place(mesh.points[at(edge.first)]) + "; separate or repair the sheets");
    }
    if (again) keep(mesh, kept);
  }
  if (dropped > 0) notes.push_back(fmt::format("{} triangles ({:.2f} mm2) on edges with more than two were dropped", dropped, dropped_area));
}

void orient(RawMesh& mesh, std::vector<std::string>& notes) {
  const auto edges = edge_triangles(mesh.triangles);
  const auto runs = [&](int t, int a, int b) {
    const Triangle& tri = mesh.triangles[at(t)];
    for (std::size_t k = 0; k < 3; ++k)
      if (tri[k] == a && tri[(k + 1) % 3] == b) return true;
    return false;
  };
  std::vector<char> seen(mesh.triangles.size(), 0);
  long flipped = 0;
  for (std::size_t start = 0; start < mesh.triangles.size(); ++start) {
    if (seen[start]) continue;
    std::vector<int> queue{static_cast<int>(start)};
    seen[start] = 1;
    long part_flipped = 0;
    for (std::size_t q = 0; q < queue.size(); ++q) {
      const Triangle tri = mesh.triangles[at(queue[q])];
      for (std::size_t k = 0; k < 3; ++k) {
        const int a = tri[k], b = tri[(k + 1) % 3];
        for (int other : edges.at(undirected(a, b))) {
          if (other == queue[q]) continue;
          const bool agrees = runs(other, b, a);
          if (seen[at(other)]) {
            if (!agrees)
              throw InputError("leaflets: the surface is one-sided (Moebius or Klein), it cannot be oriented; the turn was met near " +
                               place(mesh.points[at(a)]));
            continue;
          }
          if (!agrees) {
            std::swap(mesh.triangles[at(other)][1], mesh.triangles[at(other)][2]);
            ++part_flipped;
          }
          seen[at(other)] = 1;
          queue.push_back(other);
        }
      }
    }
    flipped += std::min(part_flipped, static_cast<long>(queue.size()) - part_flipped);
  }
  if (flipped > 0) notes.push_back(fmt::format("{} triangles were turned over", flipped));
}

/// A point in which several fans of triangles meet gets a copy for each.
void split_touching_fans(RawMesh& mesh, std::vector<std::string>& notes) {
  std::vector<std::vector<int>> star(mesh.points.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int v : mesh.triangles[t]) star[at(v)].push_back(static_cast<int>(t));
  long split = 0;
  for (std::size_t v = 0; v < star.size(); ++v) {
    std::vector<int> left = star[v];
    for (bool is_first = true; !left.empty(); is_first = false) {
      std::vector<int> fan{left.front()};
      left.erase(left.begin());
      for (std::size_t q = 0; q < fan.size(); ++q)
        for (std::size_t k = 0; k < left.size();) {
          int shared = 0;
          for (int a : mesh.triangles[at(fan[q])])
            for (int b : mesh.triangles[at(left[k])]) shared += a == b;
          if (shared >= 2) {
            fan.push_back(left[k]);
            left.erase(left.begin() + static_cast<std::ptrdiff_t>(k));
          } else {
            ++k;
          }
        }
      if (is_first) continue;
      const int copy = mesh.add_point(mesh.points[v], mesh.thickness.empty() ? -1 : mesh.thickness[v]);
      for (int t : fan)
        for (int& c : mesh.triangles[at(t)])
          if (c == static_cast<int>(v)) c = copy;
      ++split;
    }
  }
  if (split > 0) notes.push_back(fmt::format("{} points in which two pieces only touched were split", split));
}

}  // namespace

double RawMesh::area(std::size_t t) const {
  const Vec3 &a = points[at(triangles[t][0])], &b = points[at(triangles[t][1])], &c = points[at(triangles[t][2])];
  return 0.5 * (b - a).cross(c - a).norm();
}

double RawMesh::area() const {
  double sum = 0;
  for (std::size_t t = 0; t < triangles.size(); ++t) sum += area(t);
  return sum;
}

int RawMesh::add_point(const Vec3& x, double its_thickness) {
  points.push_back(x);
  if (its_thickness >= 0) thickness.push_back(its_thickness);
  return static_cast<int>(points.size()) - 1;
}

void RawMesh::add_triangle(const Triangle& corners, int its_region, double its_weight) {
  triangles.push_back(corners);
  region.push_back(its_region);
  weight.push_back(its_weight);
}

RawMesh clean_mesh(const RawLeaflets& raw, std::vector<std::string>& notes) {
  check(raw);
  const std::vector<int> first = weld(raw.points);
  RawMesh mesh;
  mesh.points = raw.points;
  mesh.thickness = raw.thickness;
  for (double& t : mesh.thickness) t = std::max(t, 0.0);
  std::map<Triangle, int> known;
  long degenerate = 0, repeated = 0;
  for (std::size_t t = 0; t < raw.triangles.size(); ++t) {
    Triangle tri = raw.triangles[t];
    for (int& v : tri) v = first[at(v)];
    if (tri[0] == tri[1] || tri[1] == tri[2] || tri[2] == tri[0]) {
      ++degenerate;
      continue;
    }
    Triangle key = tri;
    std::sort(key.begin(), key.end());
    if (!known.try_emplace(key, 1).second) {
      ++repeated;
      continue;
    }
    const int label = raw.region.empty() ? 0 : raw.region[t];
    mesh.add_triangle(tri, label == posterior || label == anterior ? label : 0, 1.0);
  }
  if (degenerate > 0) notes.push_back(fmt::format("{} degenerate triangles were dropped", degenerate));
  if (repeated > 0) notes.push_back(fmt::format("{} repeated triangles were dropped", repeated));
  if (mesh.triangles.empty()) throw InputError("leaflets: all triangles are degenerate");
  keep(mesh, std::vector<char>(mesh.triangles.size(), 1));
  drop_flaps(mesh, notes);
  orient(mesh, notes);
  split_touching_fans(mesh, notes);
  return mesh;
}

std::vector<std::vector<int>> border_loops(const RawMesh& mesh) {
  std::map<Edge, int> directed;
  for (const Triangle& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) ++directed[{t[k], t[(k + 1) % 3]}];
  std::map<int, int> next;
  for (const auto& [edge, count] : directed)
    if (!directed.count({edge.second, edge.first})) next[edge.first] = edge.second;
  std::vector<std::vector<int>> loops;
  while (!next.empty()) {
    std::vector<int> loop;
    for (int v = next.begin()->first;;) {
      const auto step = next.find(v);
      if (step == next.end()) break;
      loop.push_back(v);
      v = step->second;
      next.erase(step);
    }
    loops.push_back(std::move(loop));
  }
  std::stable_sort(loops.begin(), loops.end(),
                   [&](const auto& a, const auto& b) { return loop_length(mesh, a) > loop_length(mesh, b); });
  return loops;
}

double loop_length(const RawMesh& mesh, const std::vector<int>& loop) {
  double length = 0;
  for (std::size_t i = 0; i < loop.size(); ++i)
    length += (mesh.points[at(loop[(i + 1) % loop.size()])] - mesh.points[at(loop[i])]).norm();
  return length;
}

std::vector<RawMesh> connected_parts(const RawMesh& mesh) {
  const auto edges = edge_triangles(mesh.triangles);
  std::vector<int> part(mesh.triangles.size(), -1);
  int count = 0;
  for (std::size_t start = 0; start < part.size(); ++start) {
    if (part[start] >= 0) continue;
    std::vector<int> queue{static_cast<int>(start)};
    part[start] = count;
    for (std::size_t q = 0; q < queue.size(); ++q)
      for (std::size_t k = 0; k < 3; ++k) {
        const Triangle& tri = mesh.triangles[at(queue[q])];
        for (int other : edges.at(undirected(tri[k], tri[(k + 1) % 3])))
          if (part[at(other)] < 0) {
            part[at(other)] = count;
            queue.push_back(other);
          }
      }
    ++count;
  }
  std::vector<RawMesh> parts;
  for (int p = 0; p < count; ++p) {
    std::vector<char> kept(part.size());
    for (std::size_t t = 0; t < part.size(); ++t) kept[t] = part[t] == p;
    parts.push_back(mesh);
    keep(parts.back(), kept);
  }
  std::stable_sort(parts.begin(), parts.end(), [](const RawMesh& a, const RawMesh& b) { return a.area() > b.area(); });
  return parts;
}

int handles(const RawMesh& mesh, std::size_t loops) {
  const long euler = static_cast<long>(mesh.points.size()) - static_cast<long>(edge_triangles(mesh.triangles).size()) +
                     static_cast<long>(mesh.triangles.size());
  return static_cast<int>((2 - euler - static_cast<long>(loops)) / 2);
}

void fill_hole(RawMesh& mesh, const std::vector<int>& loop) {
  Vec3 centre = Vec3::Zero();
  double thickness = mesh.thickness.empty() ? -1 : 0;
  for (int v : loop) {
    centre += mesh.points[at(v)] / static_cast<double>(loop.size());
    if (!mesh.thickness.empty()) thickness += mesh.thickness[at(v)] / static_cast<double>(loop.size());
  }
  const int middle = mesh.add_point(centre, thickness);
  for (std::size_t i = 0; i < loop.size(); ++i) mesh.add_triangle({loop[(i + 1) % loop.size()], loop[i], middle}, 0, 0.0);
}

void refine(RawMesh& mesh, double length) {
  constexpr int most_rounds = 12;
  for (int round = 0; round < most_rounds; ++round) {
    std::map<Edge, int> middle;
    std::vector<char> on_border(mesh.points.size(), 0);
    for (const auto& loop : border_loops(mesh))
      for (int v : loop) on_border[at(v)] = 1;
    const auto edges = edge_triangles(mesh.triangles);
    for (const auto& [edge, list] : edges) {
      const double d = (mesh.points[at(edge.first)] - mesh.points[at(edge.second)]).norm();
      const bool chord = list.size() == 2 && on_border[at(edge.first)] && on_border[at(edge.second)];
      if (d > length || chord) middle[edge] = -1;
    }
    if (middle.empty()) return;
    for (auto& [edge, index] : middle)
      index = mesh.add_point(0.5 * (mesh.points[at(edge.first)] + mesh.points[at(edge.second)]),
                             mesh.thickness.empty() ? -1 : 0.5 * (mesh.thickness[at(edge.first)] + mesh.thickness[at(edge.second)]));
    RawMesh out;
    out.points = std::move(mesh.points);
    out.thickness = std::move(mesh.thickness);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const Triangle& tri = mesh.triangles[t];
      std::array<int, 3> m{};
      int splits = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto found = middle.find(undirected(tri[k], tri[(k + 1) % 3]));
        m[k] = found == middle.end() ? -1 : found->second;
        splits += m[k] >= 0;
      }
      const auto put = [&](int a, int b, int c) { out.add_triangle({a, b, c}, mesh.region[t], mesh.weight[t]); };
      if (splits == 0) {
        put(tri[0], tri[1], tri[2]);
      } else if (splits == 3) {
        put(tri[0], m[0], m[2]);
        put(m[0], tri[1], m[1]);
        put(m[2], m[1], tri[2]);
        put(m[0], m[1], m[2]);
      } else {
        // Turned so that edge 0 is split and, with two splits, edge 2 is not.
        std::size_t k = 0;
        while (!(m[k] >= 0 && (splits == 1 || m[(k + 2) % 3] < 0))) ++k;
        const int a = tri[k], b = tri[(k + 1) % 3], c = tri[(k + 2) % 3], ab = m[k], bc = m[(k + 1) % 3];
        if (splits == 1) {
          put(a, ab, c);
          put(ab, b, c);
        } else {
          put(ab, b, bc);
          const bool short_first = (out.points[at(a)] - out.points[at(bc)]).norm() < (out.points[at(ab)] - out.points[at(c)]).norm();
          if (short_first) {
            put(a, ab, bc);
            put(a, bc, c);
          } else {
            put(a, ab, c);
            put(ab, bc, c);
          }
        }
      }
    }
    mesh = std::move(out);
  }
}

}  // namespace mv
