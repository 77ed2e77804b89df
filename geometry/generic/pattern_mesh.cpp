// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/generic/pattern_mesh.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <sstream>

#include "geometry/core/errors.h"
#include "geometry/generic/surface_remesh.h"

namespace mv {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Edge size aimed at, over the longest allowed one: the largest for which few edges have to be split at the end (measured: 0.82
/// gives the fewest points at spacing 0.5 mm; 0.78 and 0.86 give 4 to 8 % more).
constexpr double mean_over_longest = 0.82;
/// Border edges are even by construction; the rest of the way to 1 is for the outer face, which is longer by thickness/2 over the
/// radius.
constexpr double border_over_longest = 0.88;
/// Seeds closer to the border than this share of the edge size would make flat triangles.
constexpr double border_clearance = 0.7;
constexpr double longest_over_spacing_limit = 1.25;
constexpr double smallest_angle_limit = 20;  // degrees
constexpr double most_triangles = 1e6;       // a minute's work; no explicit solver would end with the tetrahedra on them

void check_size(const PatternSurface& pattern, double spacing) {
  constexpr int columns = 360;
  double area = 0;
  for (int i = 0; i < columns; ++i) area += pattern.height(pattern.perimeter * (i + 0.5) / columns) * pattern.perimeter / columns;
  const double edge = mean_over_longest * spacing, triangles = area / (0.25 * std::sqrt(3.0) * edge * edge);
  if (triangles > most_triangles)
    throw ConfigError(fmt::format("key 'mesh.spacing' = {:.3g} mm: leaflets of {:.0f} mm2 would need {:.2g} million triangles, more than {:.0f} million are not made; raise it to {:.2g} mm or more, or check the unit of the valve's data", spacing,
                                  area, 1e-6 * triangles, 1e-6 * most_triangles, spacing * std::sqrt(triangles / most_triangles) * 1.01));
}

int pieces(double length, double size) { return std::max(2, static_cast<int>(std::ceil(length / size - 1e-9))); }

/// Free edge between two columns, resampled to equal lengths in space, measured on the longer of the two faces; both ends
/// included.
std::vector<Vec2> sampled_free_edge(const PatternSurface& pattern, double u_begin, double u_end, double size) {
  std::vector<Vec2> dense{{u_begin, pattern.height(u_begin)}};
  for (const Vec2& p : pattern.free_edge(std::min(0.01, 0.01 * size)))
    if (p.x() > u_begin + 1e-9 && p.x() < u_end - 1e-9) dense.push_back(p);
  dense.push_back({u_end, pattern.height(u_end)});
  std::vector<double> s{0};
  Vec3 last = pattern.map.position(dense.front()), last_shift = pattern.map.half_thickness_of(dense.front()) * pattern.normal(dense.front());
  for (std::size_t i = 1; i < dense.size(); ++i) {
    const Vec3 x = pattern.map.position(dense[i]), shift = pattern.map.half_thickness_of(dense[i]) * pattern.normal(dense[i]);
    s.push_back(s.back() + std::max((x - last + shift - last_shift).norm(), (x - last - shift + last_shift).norm()));
    last = x;
    last_shift = shift;
  }
  const int n = pieces(s.back(), size);
  std::vector<Vec2> result{dense.front()};
  std::size_t k = 0;
  for (int i = 1; i < n; ++i) {
    const double target = s.back() * i / n;
    while (s[k + 1] < target) ++k;
    const double t = (target - s[k]) / (s[k + 1] - s[k]);
    result.push_back((1 - t) * dense[k] + t * dense[k + 1]);
  }
  result.push_back(dense.back());
  return result;
}

/// Border points of both leaflets; each leaflet's ring runs counter-clockwise in (u, v), which continues to the perimeter in the
/// posterior.
struct Border {
  std::vector<Vec2> uv;
  std::vector<char> on_annulus, on_free_edge;
  std::array<std::vector<int>, 2> ring;      // indices into uv
  std::array<std::vector<Vec2>, 2> polygon;  // the same points, u not wrapped
};

/// How much longer than on the mid-surface the annulus is at most on a face, between two u; 1 for uniform thickness, where the margin of the border's
/// spacing covers it.
double annulus_stretch(const PatternSurface& pattern, double u_begin, double u_end) {
  if (!pattern.map.half_thickness_at) return 1;
  constexpr int dense = 400;
  double stretch = 1;
  Vec3 last = pattern.map.position({u_begin, 0}), last_shift = pattern.map.half_thickness_of({u_begin, 0}) * pattern.normal({u_begin, 0});
  for (int i = 1; i <= dense; ++i) {
    const Vec2 uv(u_begin + (u_end - u_begin) * i / dense, 0);
    const Vec3 x = pattern.map.position(uv), shift = pattern.map.half_thickness_of(uv) * pattern.normal(uv);
    const Vec3 d = x - last, turn = shift - last_shift;
    stretch = std::max({stretch, (d + turn).norm() / d.norm(), (d - turn).norm() / d.norm()});
    last = x;
    last_shift = shift;
  }
  return stretch;
}

Border sample_border(const PatternSurface& pattern, double size) {
  Border border;
  auto add = [&](const Vec2& p, bool annulus, bool free_edge) {
    border.uv.push_back(p);
    border.on_annulus.push_back(annulus);
    border.on_free_edge.push_back(free_edge);
    return static_cast<int>(border.uv.size()) - 1;
  };
  const std::array<double, 3> ends{0, pattern.anterior_end, pattern.perimeter};
  std::array<std::vector<int>, 2> columns;
  for (std::size_t c = 0; c < 2; ++c) {
    const double height = pattern.height(ends[c]);
    const int n = pieces(height, size);
    for (int i = 0; i <= n; ++i) columns[c].push_back(add({ends[c], height * i / n}, i == 0, i == n));
  }
  for (std::size_t patch = 0; patch < 2; ++patch) {
    const double u0 = ends[patch], u1 = ends[patch + 1];
    const std::vector<int>&left = columns[patch], &right = columns[1 - patch];
    auto put = [&](int index, double u) {
      border.ring[patch].push_back(index);
      border.polygon[patch].push_back({u, border.uv[at(index)].y()});
    };
    const int n = pieces((u1 - u0) * annulus_stretch(pattern, u0, u1), size);
    put(left.front(), u0);
    for (int i = 1; i < n; ++i) {
      const double u = u0 + (u1 - u0) * i / n;
      put(add({u, 0}, true, false), u);
    }
    for (int index : right) put(index, u1);
    const std::vector<Vec2> edge = sampled_free_edge(pattern, u0, u1, size);
    for (std::size_t i = edge.size() - 2; i > 0; --i) put(add(edge[i], false, true), edge[i].x());
    for (std::size_t i = left.size() - 1; i > 0; --i) put(left[i], u0);
  }
  return border;
}

/// Rows of constant v, each with points of equal spacing in space, staggered by half a spacing against the row above: a nearly
/// hexagonal lattice with a dislocation only where the cone's narrowing drops a point. Points too close to the border are left
/// out.
void seed_rows(const PatternSurface& pattern, const std::vector<Vec2>& polygon, double size, SurfaceRemesh& remesh) {
  const double row_height = 0.5 * std::sqrt(3.0) * size, clearance = border_clearance * size;
  double u0 = 1e300, u1 = -1e300, top = 0;
  std::vector<Vec3> wall;
  for (const Vec2& p : polygon) {
    u0 = std::min(u0, p.x());
    u1 = std::max(u1, p.x());
    top = std::max(top, p.y());
    if (p.y() > 0) wall.push_back(pattern.map.position(p));
  }
  constexpr int dense = 2000;
  const double step = (u1 - u0) / dense;
  for (int row = 1; row * row_height < top; ++row) {
    const double v = row * row_height;
    std::vector<double> s{0};
    Vec3 last = pattern.map.position({u0, v});
    for (int i = 1; i <= dense; ++i) {
      const Vec3 x = pattern.map.position({u0 + i * step, v});
      s.push_back(s.back() + (x - last).norm());
      last = x;
    }
    const int n = std::max(1, static_cast<int>(std::round(s.back() / size)));
    std::size_t k = 0;
    for (int i = 0; i < n; ++i) {
      const double target = s.back() * (i + (row % 2 ? 0.5 : 0.0)) / n;
      while (k + 2 < s.size() && s[k + 1] < target) ++k;
      const double u = u0 + (static_cast<double>(k) + (target - s[k]) / (s[k + 1] - s[k])) * step;
      if (v >= pattern.height(u)) continue;
      const Vec3 x = pattern.map.position({u, v});
      const bool crowded =
          std::any_of(wall.begin(), wall.end(), [&](const Vec3& w) { return (w - x).squaredNorm() < clearance * clearance; });
      if (!crowded) remesh.insert({u, v});
    }
    remesh.flip_to_delaunay();
  }
}

double angle_at(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 p = b - a, q = c - a;
  return std::atan2(p.cross(q).norm(), p.dot(q)) * 180 / std::acos(-1.0);
}

SurfaceMeshReport measure(const MidSurface& s, const SurfaceMap& map) {
  std::vector<double> half;
  for (const Vec2& uv : s.unfolded) half.push_back(map.half_thickness_of(uv));
  SurfaceMeshReport r;
  r.points = static_cast<int>(s.points.size());
  r.triangles = static_cast<int>(s.triangles.size());
  r.edge_min = r.angle_min = 1e300;
  double sum = 0;
  for (const auto& t : s.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 &a = s.points[at(t[k])], &b = s.points[at(t[(k + 1) % 3])], &c = s.points[at(t[(k + 2) % 3])];
      const Vec3 turn = half[at(t[(k + 1) % 3])] * s.normals[at(t[(k + 1) % 3])] - half[at(t[k])] * s.normals[at(t[k])];
      r.face_edge_max = std::max({r.face_edge_max, (b - a + turn).norm(), (b - a - turn).norm()});
      const double edge = (b - a).norm(), angle = angle_at(a, b, c);
      sum += edge;
      r.edge_min = std::min(r.edge_min, edge);
      r.edge_max = std::max(r.edge_max, edge);
      r.angle_min = std::min(r.angle_min, angle);
      r.angle_max = std::max(r.angle_max, angle);
    }
  r.edge_mean = sum / (3.0 * static_cast<double>(s.triangles.size()));
  return r;
}

/// One leaflet: border points first (in the order of the polygon), then the free ones.
SurfaceRemesh mesh_leaflet(const PatternSurface& pattern, const std::vector<Vec2>& polygon, double spacing) {
  const double size = mean_over_longest * spacing, longest = 1.4 * size, shortest = 0.65 * size;
  SurfaceRemesh remesh(pattern.map, polygon, triangulate_polygon(polygon), std::vector<char>(polygon.size(), 1));
  remesh.flip_to_delaunay();
  seed_rows(pattern, polygon, size, remesh);
  remesh.smooth(10, 1.0);
  remesh.flip_to_delaunay();
  for (int i = 0; i < 4; ++i) {
    remesh.split_border_chords(1.2 * size);
    remesh.split_longer_than(longest);
    remesh.collapse_shorter_than(shortest, longest);
    remesh.flip_to_delaunay();
    remesh.smooth(5, 1.0);
  }
  for (int i = 0; i < 8; ++i) {
    remesh.flip_to_delaunay();
    remesh.equalise_edges(5, 6);
  }
  // What is still too long is few: split it and settle the new points and their neighbours, which may lengthen others; the last
  // rounds therefore split only.
  for (int i = 0; i < 14; ++i) {
    remesh.flip_to_delaunay();
    const int first_new = remesh.size();
    if (remesh.split_longer_on_faces(spacing) == 0) break;
    remesh.flip_to_delaunay();
    if (i < 7) remesh.smooth(5, 1.0, first_new);
  }
  remesh.compact();
  return remesh;
}

}  // namespace

MidSurface mesh_pattern(const FlatPattern& pattern, const ConeWrap& wrap, double spacing, double thickness,
                        SurfaceMeshReport* report) {
  const SurfaceMap map{[&](const Vec2& p) { return wrap.position(p); }, [&](const Vec2& p) { return wrap.along_u(p); },
                       [&](const Vec2& p) { return wrap.along_v(p); }, 0.5 * thickness, {}};
  return mesh_pattern({pattern.perimeter(), 2 * pattern.parameters().anterior_radius, [&](double u) { return pattern.height(u); },
                       [&](double step) { return pattern.free_edge(step); }, map, [&](const Vec2& p) { return wrap.normal(p); }},
                      spacing, report);
}

MidSurface mesh_pattern(const PatternSurface& pattern, double spacing, SurfaceMeshReport* report) {
  check_size(pattern, spacing);
  if (!(spacing > 0)) throw ConfigError("mesh.spacing must be positive");
  const Border border = sample_border(pattern, border_over_longest * spacing);
  MidSurface s;
  s.perimeter = pattern.perimeter;
  s.unfolded = border.uv;
  s.on_annulus = border.on_annulus;
  s.on_free_edge = border.on_free_edge;
  for (std::size_t patch = 0; patch < 2; ++patch) {
    const SurfaceRemesh remesh = mesh_leaflet(pattern, border.polygon[patch], spacing);
    std::vector<int> index = border.ring[patch];
    for (std::size_t i = index.size(); i < remesh.uv().size(); ++i) {
      index.push_back(static_cast<int>(s.unfolded.size()));
      s.unfolded.push_back(remesh.uv()[i]);
    }
    for (const auto& t : remesh.triangles()) {
      s.triangles.push_back({index[at(t[0])], index[at(t[1])], index[at(t[2])]});
      s.region.push_back(patch == 0 ? anterior : posterior);
    }
  }
  s.on_annulus.resize(s.unfolded.size(), 0);
  s.on_free_edge.resize(s.unfolded.size(), 0);
  for (const Vec2& p : s.unfolded) {
    s.points.push_back(pattern.map.position(p));
    s.normals.push_back(pattern.normal(p));
  }
  SurfaceMeshReport measured = measure(s, pattern.map);
  if (report) *report = measured;
  if (measured.face_edge_max > longest_over_spacing_limit * spacing || measured.angle_min < smallest_angle_limit) {
    std::ostringstream message;
    message << "mid-surface mesh: longest edge " << measured.face_edge_max << " mm (limit "
            << longest_over_spacing_limit * spacing << "), smallest angle " << measured.angle_min << " degrees (limit "
            << smallest_angle_limit << "); change mesh.spacing or generic.notch_radius";
    throw GateError(message.str());
  }
  return s;
}

}  // namespace mv
