// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/generic/pattern_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <sstream>

#include "geometry/core/errors.h"
#include "geometry/generic/surface_remesh.h"

namespace mv {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Mean edge over the longest allowed one: below this the mesh reaches the limit everywhere, above it some edges stay too long.
static double env(const char*n,double d){const char*v=getenv(n);return v?atof(v):d;}
const double mean_over_longest = env("MO",0.86);
constexpr double longest_over_spacing_limit = 1.25;
constexpr double smallest_angle_limit = 20;   // degrees

int pieces(double length, double size) { return std::max(2, static_cast<int>(std::ceil(length / size - 1e-9))); }

/// Free edge between two columns, resampled to equal lengths in space; both ends included.
std::vector<Vec2> sampled_free_edge(const FlatPattern& pattern, const ConeWrap& wrap, double u_begin, double u_end, double size) {
  std::vector<Vec2> dense{{u_begin, pattern.height(u_begin)}};
  for (const Vec2& p : pattern.free_edge(std::min(0.01, 0.01 * size)))
    if (p.x() > u_begin + 1e-9 && p.x() < u_end - 1e-9) dense.push_back(p);
  dense.push_back({u_end, pattern.height(u_end)});
  std::vector<double> s{0};
  Vec3 last = wrap.position(dense.front());
  for (std::size_t i = 1; i < dense.size(); ++i) {
    const Vec3 x = wrap.position(dense[i]);
    s.push_back(s.back() + (x - last).norm());
    last = x;
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

/// Fixed points (annulus, free edge, both commissure columns), the border polygons of the two leaflets in these points, and their triangles.
struct Border {
  std::vector<Vec2> uv;
  std::vector<char> on_annulus, on_free_edge;
  std::vector<std::array<int, 3>> triangles;
  std::vector<std::pair<int, int>> column_edges;
};

Border sample_border(const FlatPattern& pattern, const ConeWrap& wrap, double size) {
  Border border;
  auto add = [&](const Vec2& p, bool annulus, bool free_edge) {
    border.uv.push_back(p);
    border.on_annulus.push_back(annulus);
    border.on_free_edge.push_back(free_edge);
    return static_cast<int>(border.uv.size()) - 1;
  };
  const std::array<double, 3> ends{0, 2 * pattern.parameters().anterior_radius, pattern.perimeter()};
  std::array<std::vector<int>, 2> columns;
  for (std::size_t c = 0; c < 2; ++c) {
    const double height = pattern.height(ends[c]);
    const int n = pieces(height, size);
    for (int i = 0; i <= n; ++i) columns[c].push_back(add({ends[c], height * i / n}, i == 0, i == n));
    for (int i = 0; i < n; ++i) border.column_edges.emplace_back(columns[c][at(i)], columns[c][at(i + 1)]);
  }
  for (std::size_t patch = 0; patch < 2; ++patch) {
    const double u0 = ends[patch], u1 = ends[patch + 1];
    const std::vector<int>&left = columns[patch], &right = columns[1 - patch];
    std::vector<int> ring;
    std::vector<Vec2> polygon;
    auto put = [&](int index, double u) {
      ring.push_back(index);
      polygon.push_back({u, border.uv[at(index)].y()});
    };
    const int n = pieces(u1 - u0, size);
    put(left.front(), u0);
    for (int i = 1; i < n; ++i) {
      const double u = u0 + (u1 - u0) * i / n;
      put(add({u, 0}, true, false), u);
    }
    for (int index : right) put(index, u1);
    const std::vector<Vec2> edge = sampled_free_edge(pattern, wrap, u0, u1, size);
    for (std::size_t i = edge.size() - 2; i > 0; --i) put(add(edge[i], false, true), edge[i].x());
    for (std::size_t i = left.size() - 1; i > 0; --i) put(left[i], u0);
    for (const auto& t : triangulate_polygon(polygon)) border.triangles.push_back({ring[at(t[0])], ring[at(t[1])], ring[at(t[2])]});
  }
  return border;
}

/// Rows of constant v, each with points of equal spacing in space, staggered by half a spacing against the row above: a nearly
/// hexagonal lattice with a dislocation only where the cone's narrowing drops a point. Points too close to the border are left out.
void seed_rows(const FlatPattern& pattern, const ConeWrap& wrap, const Border& border, double size, SurfaceRemesh& remesh) {
  const double row_height = 0.5 * std::sqrt(3.0) * size, clearance = env("CL",0.7) * size, perimeter = pattern.perimeter();
  std::vector<Vec3> wall;
  for (std::size_t i = 0; i < border.uv.size(); ++i)
    if (!border.on_annulus[i]) wall.push_back(wrap.position(border.uv[i]));
  double top = 0;
  for (const Vec2& p : border.uv) top = std::max(top, p.y());
  const std::array<double, 3> ends{0, 2 * pattern.parameters().anterior_radius, perimeter};
  for (int row = 1; row * row_height < top; ++row) {
    const double v = row * row_height;
    for (std::size_t patch = 0; patch < 2; ++patch) {
      constexpr int dense = 2000;
      const double step = (ends[patch + 1] - ends[patch]) / dense;
      std::vector<double> s{0};
      Vec3 last = wrap.position({ends[patch], v});
      for (int i = 1; i <= dense; ++i) {
        const Vec3 x = wrap.position({ends[patch] + i * step, v});
        s.push_back(s.back() + (x - last).norm());
        last = x;
      }
      const int n = std::max(1, static_cast<int>(std::round(s.back() / size)));
      std::size_t k = 0;
      for (int i = 0; i < n; ++i) {
        const double target = s.back() * (i + (row % 2 ? 0.5 : 0.0)) / n;
        while (k + 2 < s.size() && s[k + 1] < target) ++k;
        const double u = ends[patch] + (static_cast<double>(k) + (target - s[k]) / (s[k + 1] - s[k])) * step;
        if (v >= pattern.height(u)) continue;
        const Vec3 x = wrap.position({u, v});
        const bool crowded = std::any_of(wall.begin(), wall.end(), [&](const Vec3& w) { return (w - x).squaredNorm() < clearance * clearance; });
        if (!crowded) remesh.insert({u, v});
      }
    }
    remesh.flip_to_delaunay();
  }
}

double angle_at(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 p = b - a, q = c - a;
  return std::atan2(p.cross(q).norm(), p.dot(q)) * 180 / std::acos(-1.0);
}

SurfaceMeshReport measure(const MidSurface& s) {
  SurfaceMeshReport r;
  r.points = static_cast<int>(s.points.size());
  r.triangles = static_cast<int>(s.triangles.size());
  r.edge_min = r.angle_min = 1e300;
  double sum = 0;
  for (const auto& t : s.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 &a = s.points[at(t[k])], &b = s.points[at(t[(k + 1) % 3])], &c = s.points[at(t[(k + 2) % 3])];
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

}  // namespace

MidSurface mesh_pattern(const FlatPattern& pattern, const ConeWrap& wrap, double spacing, SurfaceMeshReport* report) {
  if (!(spacing > 0)) throw ConfigError("mesh.spacing must be positive");
  const double size = mean_over_longest * spacing;
  const Border border = sample_border(pattern, wrap, env("BS",0.86)*spacing);
  SurfaceMap map{[&](const Vec2& p) { return wrap.position(p); }, [&](const Vec2& p) { return wrap.along_u(p); },
                 [&](const Vec2& p) { return wrap.along_v(p); }, pattern.perimeter()};
  SurfaceRemesh remesh(map, border.uv, border.triangles, std::vector<char>(border.uv.size(), 1));
  for (const auto& [a, b] : border.column_edges) remesh.fix_edge(a, b);

  int iterations = 0;
  const double bsize=env("BS",0.86)*spacing;(void)bsize;
  remesh.flip_to_delaunay();
  if (env("SEED",1)>0) { seed_rows(pattern, wrap, border, size, remesh); fprintf(stderr,"seeded\n"); remesh.smooth(10,1.0); remesh.flip_to_delaunay(); }
  while (remesh.split_longer_than(1.4 * size) > 0 && ++iterations < 40) {
    remesh.flip_to_delaunay();
    remesh.smooth(2, 1.0);
  }
  for (int i = 0; i < 12; ++i, ++iterations) {
    remesh.split_longer_than(env("SP",1.33) * size);
    remesh.collapse_shorter_than(env("CO",0.75) * size, env("SP",1.33) * size);
    if (i < env("VA",8)) remesh.flip_to_better_valence(); else remesh.flip_to_delaunay();
    remesh.smooth(5, 1.0);
  }
  for (int i = 0; i < 6; ++i, ++iterations) {
    remesh.flip_to_delaunay();
    remesh.smooth(10, 1.0);
  }
  remesh.flip_to_delaunay();
  for(int i=0;i<int(env("EQ",0));++i){ remesh.equalise_edges(5,env("PW",4)); if(env("FL",1)>0) remesh.flip_to_delaunay(); }
  if(env("RL",1)>0) remesh.relax_long_edges(0.97 * spacing, 30);
  remesh.compact();

  MidSurface s;
  s.points = remesh.points();
  s.unfolded = remesh.uv();
  s.triangles = remesh.triangles();
  s.perimeter = pattern.perimeter();
  s.on_annulus = border.on_annulus;
  s.on_annulus.resize(s.points.size(), 0);
  s.on_free_edge = border.on_free_edge;
  s.on_free_edge.resize(s.points.size(), 0);
  for (const Vec2& p : s.unfolded) s.normals.push_back(wrap.normal(p));
  for (int t = 0; t < static_cast<int>(s.triangles.size()); ++t) {
    const std::array<Vec2, 3> c = unfolded_triangle(s, t);
    s.region.push_back(pattern.region((c[0].x() + c[1].x() + c[2].x()) / 3));
  }
  SurfaceMeshReport measured = measure(s);
  measured.iterations = iterations;
  if (report) *report = measured;
  if (measured.edge_max > longest_over_spacing_limit * spacing || measured.angle_min < smallest_angle_limit) {
    std::ostringstream message;
    message << "mid-surface mesh: longest edge " << measured.edge_max << " mm (limit " << longest_over_spacing_limit * spacing
            << "), smallest angle " << measured.angle_min << " degrees (limit " << smallest_angle_limit
            << "); change mesh.spacing or generic.notch_radius";
    throw GateError(message.str());
  }
  return s;
}

}  // namespace mv
