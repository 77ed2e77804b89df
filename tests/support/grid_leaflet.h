// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Small leaflet meshes made from a structured grid, each cell cut into six tetrahedra: a flat or bent patch, with or without a
// slit, and a closed four-scallop valve on a circular cone.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <vector>

#include "geometry/core/case.h"

namespace mv::test {

struct GridSpec {
  int columns = 20, rows = 20, layers = 2;                             // cells
  bool is_periodic = false;                                            // column `columns` is column 0
  std::function<Vec2(int, int)> pattern;                               // (column, row) -> (u, v), row 0 on the annulus
  std::function<Vec3(Vec2, double)> place;                             // (u, v), w in [-1/2, 1/2] (+1/2 atrial) -> position
  std::function<Vec3(Vec2)> normal;                                    // towards the atrial face
  std::function<bool(int, int)> keep = [](int, int) { return true; };  // cells
  std::function<int(int)> region = [](int) { return static_cast<int>(anterior); };  // of a column of cells
};

inline LeafletMesh grid_leaflet(const GridSpec& g) {
  LeafletMesh mesh;
  std::map<std::array<int, 3>, int> index;
  const auto node = [&](int i, int j, int l) {
    if (g.is_periodic) i = (i + g.columns) % g.columns;
    const auto [it, is_new] = index.try_emplace({i, j, l}, static_cast<int>(mesh.points.size()));
    if (is_new) {
      const Vec2 uv = g.pattern(i, j);
      mesh.points.push_back(g.place(uv, 0.5 - static_cast<double>(l) / g.layers));
      mesh.unfolded.push_back(uv);
      mesh.on_annulus.push_back(j == 0);
      mesh.on_free_edge.push_back(j == g.rows);
      mesh.side.push_back(l == 0 ? atrial : l == g.layers ? ventricular : between);
    }
    return it->second;
  };
  constexpr std::array<std::array<int, 3>, 6> orders{{{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
  for (int i = 0; i < g.columns; ++i)
    for (int j = 0; j < g.rows; ++j) {
      if (!g.keep(i, j)) continue;
      for (int l = 0; l < g.layers; ++l)
        for (const auto& order : orders) {
          std::array<int, 3> corner{i, j, l};
          std::array<int, 10> tet;
          tet.fill(-1);
          tet[0] = node(corner[0], corner[1], corner[2]);
          for (std::size_t k = 0; k < 3; ++k) {
            ++corner[static_cast<std::size_t>(order[k])];
            tet[k + 1] = node(corner[0], corner[1], corner[2]);
          }
          const auto x = [&](std::size_t k) { return mesh.points[static_cast<std::size_t>(tet[k])]; };
          if ((x(1) - x(0)).cross(x(2) - x(0)).dot(x(3) - x(0)) < 0) std::swap(tet[2], tet[3]);
          mesh.tets.push_back(tet);
          mesh.region.push_back(g.region(i));
          mesh.layer.push_back(l);
          Vec2 middle = g.pattern(i, j);
          middle = 0.5 * (middle + g.pattern(i + 1, j + 1));
          mesh.sheet_normal.push_back(g.normal(middle));
          mesh.fibre.push_back(Vec3::Zero());
        }
    }
  return mesh;
}

/// Flat patch [0, width] x [0, height] in the plane z = 0; annulus row at y = 0 (v = y), free edge at y = height.
inline LeafletMesh flat_patch(double width, double height, double spacing, double thickness = 1, int layers = 2) {
  GridSpec g;
  g.columns = static_cast<int>(std::lround(width / spacing));
  g.rows = static_cast<int>(std::lround(height / spacing));
  g.layers = layers;
  g.pattern = [=](int i, int j) { return Vec2(width * i / g.columns, height * j / g.rows); };
  g.place = [=](Vec2 p, double w) { return Vec3(p.x(), p.y(), w * thickness); };
  g.normal = [](Vec2) { return Vec3::UnitZ(); };
  return grid_leaflet(g);
}

/// Flat patch with a slit one cell wide from the free edge at x = width/2 down to y = floor.
inline LeafletMesh slit_patch(double width, double height, double floor, double spacing, double thickness = 1) {
  GridSpec g;
  g.columns = 2 * (static_cast<int>(std::lround(width / spacing)) / 2) + 1;
  g.rows = static_cast<int>(std::lround(height / spacing));
  const int columns = g.columns, rows = g.rows;
  g.pattern = [=](int i, int j) { return Vec2(width * i / columns, height * j / rows); };
  g.place = [=](Vec2 p, double w) { return Vec3(p.x(), p.y(), w * thickness); };
  g.normal = [](Vec2) { return Vec3::UnitZ(); };
  g.keep = [=](int i, int j) { return i != columns / 2 || (j + 0.5) * height / rows < floor; };
  return grid_leaflet(g);
}

/// The four-semicircle pattern on a circular cone about z: anterior leaflet u in [0, 36] centred on +y, three posterior scallops,
/// apex towards -z.
struct RingSpec {
  double perimeter = 107.2, strip = 6, anterior_radius = 18, anterior_height = 0.9, posterior_height = 0.75, slope = 0.35,
         thickness = 1;
  int columns = 216, rows = 14, layers = 2;
  int scallops = 3;
};

inline double ring_height(const RingSpec& r, double u) {
  u -= r.perimeter * std::floor(u / r.perimeter);
  double radius = r.anterior_radius, centre = radius, factor = r.anterior_height;
  if (u > 2 * r.anterior_radius) {
    radius = (r.perimeter - 2 * r.anterior_radius) / (2 * r.scallops);
    const int k = std::min(static_cast<int>((u - 2 * r.anterior_radius) / (2 * radius)), r.scallops - 1);
    centre = 2 * r.anterior_radius + (2 * k + 1) * radius;
    factor = r.posterior_height;
  }
  return r.strip + factor * std::sqrt(std::max(radius * radius - (u - centre) * (u - centre), 0.0));
}

/// Columns fall on the commissures and notches. Distances along v are exact; along u they are on the annulus.
inline LeafletMesh ring_valve(const RingSpec& r = {}) {
  GridSpec g;
  const double width = 2 * r.anterior_radius;
  const int in_anterior = static_cast<int>(std::lround(r.columns * width / r.perimeter));
  const int per_scallop = (r.columns - in_anterior) / r.scallops;
  g.columns = in_anterior + per_scallop * r.scallops;
  g.rows = r.rows;
  g.layers = r.layers;
  g.is_periodic = true;
  const auto u_of = [=](int i) {
    const double posterior_width = r.perimeter - width;
    return i <= in_anterior ? width * i / in_anterior : width + posterior_width * (i - in_anterior) / (per_scallop * r.scallops);
  };
  const double radius = r.perimeter / (2 * std::numbers::pi), length = std::hypot(1.0, r.slope);
  const auto outward = [=](Vec2 p) {
    const double angle = std::numbers::pi / 2 + 2 * std::numbers::pi * (p.x() - r.anterior_radius) / r.perimeter;
    return Vec3(std::cos(angle), std::sin(angle), 0);
  };
  g.pattern = [=](int i, int j) {
    const double u = u_of(i);
    return Vec2(u, ring_height(r, u) * j / r.rows);
  };
  g.normal = [=](Vec2 p) { return Vec3((-outward(p) + r.slope * Vec3::UnitZ()) / length); };
  g.place = [=](Vec2 p, double w) {
    const Vec3 mid = (radius - p.y() * r.slope / length) * outward(p) - p.y() / length * Vec3::UnitZ();
    return Vec3(mid + w * r.thickness * (-outward(p) + r.slope * Vec3::UnitZ()) / length);
  };
  g.region = [=](int i) { return static_cast<int>(i < in_anterior ? anterior : posterior); };
  return grid_leaflet(g);
}

inline Papillary ring_papillary() { return {{Vec3(10, -2, -32), Vec3(-10, -2, -32)}, {"anterolateral", "posteromedial"}}; }

inline Annulus ring_annulus(const RingSpec& r = {}) {
  Annulus a;
  const double radius = r.perimeter / (2 * std::numbers::pi);
  for (int i = 0; i < 180; ++i)
    a.points.emplace_back(radius * std::cos(i * std::numbers::pi / 90), radius * std::sin(i * std::numbers::pi / 90), 0);
  a.normal = -Vec3::UnitZ();
  return a;
}

}  // namespace mv::test
