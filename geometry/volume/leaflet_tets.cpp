// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/volume/leaflet_tets.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

#include "geometry/core/errors.h"

namespace mv {
namespace {

std::size_t at(long i) { return static_cast<std::size_t>(i); }

void check(const MidSurface& s, const ThickenOptions& o) {
  if (!(o.thickness > 0)) throw ConfigError("mesh.thickness must be positive");
  if (o.layers < 1 || o.layers > 16) throw ConfigError("mesh.layers must lie between 1 and 16");
  if (o.order != 1 && o.order != 2) throw ConfigError("mesh.order must be 1 or 2");
  const std::size_t n = s.points.size();
  if (s.normals.size() != n || s.unfolded.size() != n || s.on_annulus.size() != n || s.on_free_edge.size() != n ||
      s.region.size() != s.triangles.size())
    throw InputError("mid-surface: per-point or per-triangle arrays do not match the number of points or triangles");
  if (!s.thickness.empty() && s.thickness.size() != n)
    throw InputError("mid-surface: " + std::to_string(s.thickness.size()) + " thickness values for " + std::to_string(n) + " points");
  for (double t : s.thickness)
    if (!(t > 0 && t < 1e300)) throw InputError("mid-surface: thickness " + std::to_string(t) + " mm; expected a positive number");
  for (const auto& t : s.triangles)
    for (int v : t)
      if (v < 0 || at(v) >= n)
        throw InputError("mid-surface: a triangle refers to point " + std::to_string(v) + " of " + std::to_string(n));
}

using Tet = std::array<int, 4>;

/// Prism with lower triangle a, b, c and upper one A, B, C (positive volume when the lower triangle is counter-clockwise seen
/// from the upper). `rank` orders the columns: on each side wall the diagonal starts below the column of lower rank, which is the
/// same seen from either prism.
std::array<Tet, 3> split_prism(std::array<int, 3> lower, std::array<int, 3> upper, std::array<int, 3> rank) {
  const auto first = static_cast<std::size_t>(std::min_element(rank.begin(), rank.end()) - rank.begin());
  const std::array<std::size_t, 3> k{first, (first + 1) % 3, (first + 2) % 3};
  const int a = lower[k[0]], b = lower[k[1]], c = lower[k[2]], A = upper[k[0]], B = upper[k[1]], C = upper[k[2]];
  // Column a has the lowest rank, so the diagonals aB and aC exist; the wall opposite decides between bC and cB.
  if (rank[k[1]] < rank[k[2]]) return {Tet{a, b, c, C}, Tet{a, b, C, B}, Tet{a, B, C, A}};
  return {Tet{a, b, c, B}, Tet{a, c, C, B}, Tet{a, B, C, A}};
}

}  // namespace

LeafletMesh thicken(const MidSurface& s, const ThickenOptions& o) {
  check(s, o);
  LeafletMesh m;
  const int n = static_cast<int>(s.points.size());
  for (int level = 0; level <= o.layers; ++level) {
    for (int i = 0; i < n; ++i) {
      const double offset = (0.5 - static_cast<double>(level) / o.layers) * (s.thickness.empty() ? o.thickness : s.thickness[at(i)]);
      m.points.push_back(s.points[at(i)] + offset * s.normals[at(i)]);
      m.on_annulus.push_back(s.on_annulus[at(i)]);
      m.on_free_edge.push_back(s.on_free_edge[at(i)]);
      m.side.push_back(level == 0 ? atrial : (level == o.layers ? ventricular : between));
      m.unfolded.push_back(s.unfolded[at(i)]);
    }
  }
  for (std::size_t t = 0; t < s.triangles.size(); ++t) {
    const auto& tri = s.triangles[t];
    const Vec3 normal = (s.normals[at(tri[0])] + s.normals[at(tri[1])] + s.normals[at(tri[2])]).normalized();
    Vec3 tangent = s.axis.cross(normal);
    if (tangent.norm() < 1e-6) {  // the surface lies in the annulus plane: any tangent is parallel to it
      const Vec3 edge = s.points[at(tri[1])] - s.points[at(tri[0])];
      tangent = edge - edge.dot(normal) * normal;
    }
    tangent = (tangent - tangent.dot(normal) * normal).normalized();
    for (int layer = 0; layer < o.layers; ++layer) {
      std::array<int, 3> inner, outer;
      for (std::size_t k = 0; k < 3; ++k) {
        inner[k] = layer * n + tri[k];
        outer[k] = inner[k] + n;
      }
      // The triangle is counter-clockwise seen from the atrial face. The ventricular half is the mirror image of the atrial half:
      // the prism is turned upside down, which also reverses its triangle.
      const bool mirrored = 2 * layer >= o.layers;
      std::array<Tet, 3> tets;
      if (!mirrored)
        tets = split_prism(outer, inner, tri);
      else
        tets = split_prism({inner[0], inner[2], inner[1]}, {outer[0], outer[2], outer[1]}, {tri[0], tri[2], tri[1]});
      for (const Tet& tet : tets) {
        m.tets.push_back({tet[0], tet[1], tet[2], tet[3], -1, -1, -1, -1, -1, -1});
        m.region.push_back(s.region[t]);
        m.layer.push_back(layer);
        m.fibre.push_back(tangent);
        m.sheet_normal.push_back(normal);
      }
    }
  }
  return o.order == 2 ? to_quadratic(m, s.perimeter) : m;
}

LeafletMesh to_quadratic(const LeafletMesh& linear, double perimeter) {
  constexpr std::array<std::array<int, 2>, 6> edges{{{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};
  LeafletMesh m = linear;
  m.order = 2;
  std::map<std::pair<int, int>, int> middle;
  for (auto& tet : m.tets)
    for (std::size_t e = 0; e < 6; ++e) {
      const int a = std::min(tet[at(edges[e][0])], tet[at(edges[e][1])]),
                b = std::max(tet[at(edges[e][0])], tet[at(edges[e][1])]);
      const auto [entry, added] = middle.try_emplace({a, b}, static_cast<int>(m.points.size()));
      tet[4 + e] = entry->second;
      if (!added) continue;
      m.points.push_back(0.5 * (m.points[at(a)] + m.points[at(b)]));
      m.on_annulus.push_back(m.on_annulus[at(a)] && m.on_annulus[at(b)]);
      m.on_free_edge.push_back(m.on_free_edge[at(a)] && m.on_free_edge[at(b)]);
      m.side.push_back(m.side[at(a)] == m.side[at(b)] ? m.side[at(a)] : static_cast<int>(between));
      Vec2 p = m.unfolded[at(a)], q = m.unfolded[at(b)];
      if (perimeter > 0 && std::abs(p.x() - q.x()) > 0.5 * perimeter) (p.x() < q.x() ? p : q).x() += perimeter;
      Vec2 unfolded = 0.5 * (p + q);
      if (perimeter > 0 && unfolded.x() >= perimeter) unfolded.x() -= perimeter;
      m.unfolded.push_back(unfolded);
    }
  return m;
}

}  // namespace mv
