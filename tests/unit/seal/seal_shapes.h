// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Solids with known holes inside a straight tube, for the tests of solver/seal.

#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <vector>

#include "solver/seal/seal.h"

namespace mv::test {

using Map2 = std::function<Vec2(int, int)>;
using Map3 = std::function<Vec3(const Vec3&)>;

struct Solid {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;

  void add(const Solid& o) {
    const int shift = static_cast<int>(points.size());
    points.insert(points.end(), o.points.begin(), o.points.end());
    for (auto t : o.triangles) triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
  }
};

/// Plate of quadrilateral cells (i, j) from z = -thickness/2 to +thickness/2; cells not kept are holes.
inline Solid extrude(
    int ni, int nj, bool periodic_j, const Map2& xy, const std::function<bool(int, int)>& keep, double thickness,
    const Map3& map = [](const Vec3& p) { return p; }) {
  Solid s;
  const int rows = periodic_j ? nj : nj + 1;
  for (int side = 0; side < 2; ++side)
    for (int i = 0; i <= ni; ++i)
      for (int j = 0; j < rows; ++j) {
        const Vec2 p = xy(i, j);
        s.points.push_back(map(Vec3(p.x(), p.y(), side ? 0.5 * thickness : -0.5 * thickness)));
      }
  const auto at = [&](int i, int j, int side) { return (side * (ni + 1) + i) * rows + (periodic_j ? (j + nj) % nj : j); };
  const auto kept = [&](int i, int j) {
    if (periodic_j) j = (j + nj) % nj;
    return i >= 0 && i < ni && j >= 0 && j < nj && keep(i, j);
  };
  const auto quad = [&](int a, int b, int c, int d) {
    s.triangles.push_back({a, b, c});
    s.triangles.push_back({a, c, d});
  };
  for (int i = 0; i < ni; ++i)
    for (int j = 0; j < nj; ++j) {
      if (!kept(i, j)) continue;
      quad(at(i, j, 1), at(i + 1, j, 1), at(i + 1, j + 1, 1), at(i, j + 1, 1));
      quad(at(i, j, 0), at(i, j + 1, 0), at(i + 1, j + 1, 0), at(i + 1, j, 0));
      if (!kept(i, j - 1)) quad(at(i, j, 0), at(i + 1, j, 0), at(i + 1, j, 1), at(i, j, 1));
      if (!kept(i, j + 1)) quad(at(i + 1, j + 1, 0), at(i, j + 1, 0), at(i, j + 1, 1), at(i + 1, j + 1, 1));
      if (!kept(i - 1, j)) quad(at(i, j + 1, 0), at(i, j, 0), at(i, j, 1), at(i, j + 1, 1));
      if (!kept(i + 1, j)) quad(at(i + 1, j, 0), at(i + 1, j + 1, 0), at(i + 1, j + 1, 1), at(i + 1, j, 1));
    }
  return s;
}

/// Ring plate around `centre` between radii r0 (0: a full disc) and r1, r1 measured from the origin.
inline Solid ring_plate(
    double r0, double r1, double thickness, const Vec2& centre = Vec2::Zero(), const Map3& map = [](const Vec3& p) { return p; },
    int rings = 10, int sectors = 72) {
  const auto xy = [=](int i, int j) {
    const double a = 2 * std::numbers::pi * j / sectors, s = static_cast<double>(i) / rings;
    const Vec2 e(std::cos(a), std::sin(a));
    const Vec2 inner = centre + r0 * e, outer = r1 * e;
    return Vec2((1 - s) * inner + s * outer);
  };
  return extrude(
      rings, sectors, true, xy, [](int, int) { return true; }, thickness, map);
}

/// Rectangular plate of squares with side `cell`, centred at the origin.
inline Solid cell_plate(
    int ni, int nj, double cell, const std::function<bool(int, int)>& keep, double thickness,
    const Map3& map = [](const Vec3& p) { return p; }) {
  return extrude(
      ni, nj, false, [=](int i, int j) { return Vec2(cell * (i - 0.5 * ni), cell * (j - 0.5 * nj)); }, keep, thickness, map);
}

inline std::vector<Vec2> circle(double r, int n = 120) {
  std::vector<Vec2> out;
  for (int i = 0; i < n; ++i)
    out.emplace_back(r * std::cos(2 * std::numbers::pi * i / n), r * std::sin(2 * std::numbers::pi * i / n));
  return out;
}

inline std::vector<Vec2> rectangle(double a, double b) {
  return {{-a / 2, -b / 2}, {a / 2, -b / 2}, {a / 2, b / 2}, {-a / 2, b / 2}};
}

/// The solid in a tube whose axis is z; the annulus lies on the wall at height z_annulus(x, y).
inline SealInput in_tube(
    const Solid& solid, const std::vector<Vec2>& section,
    const std::function<double(const Vec2&)>& z_annulus = [](const Vec2&) { return 0.0; }) {
  SealInput in;
  in.points = solid.points;
  in.triangles = solid.triangles;
  in.tube.cross_section = section;
  in.tube.z_ventricle = -40;
  in.tube.z_atrium = 20;
  for (std::size_t i = 0; i < section.size(); ++i)
    for (int s = 0; s < 8; ++s) {
      const Vec2 p = section[i] + s / 8.0 * (section[(i + 1) % section.size()] - section[i]);
      in.annulus.emplace_back(p.x(), p.y(), z_annulus(p));
    }
  return in;
}

/// Two leaflets that reach from the walls at x = -10 and x = +10 to the middle and hang down there, `gap` apart; `slope` leans
/// the coaptation over, which narrows the gap to gap * cos(angle).
inline SealInput two_leaflets(double gap, double slope = 0, double offset = 0) {
  const double thickness = 1, depth = 6;
  Solid s;
  for (int side : {-1, 1}) {
    // Profile in (x, z) as two rows of cells: along the roof, then down; extruded along y.
    const auto xz = [=](int i, int across) {
      const double inner = 0.5 * gap, outer = inner + thickness;
      if (i == 0) return Vec2(10.5, across ? 0.0 : -thickness);
      const double z = across ? (i == 1 ? 0.0 : -depth) : (i == 1 ? -thickness : -depth);
      return Vec2(across ? inner : outer, z);
    };
    const Solid leaf = extrude(
        2, 44, false, [](int i, int j) { return Vec2(i, 0.5 * (j - 22)); }, [](int, int) { return true; }, 1.0,
        [&](const Vec3& p) {
          const Vec2 q = xz(static_cast<int>(std::lround(p.x())), p.z() > 0 ? 1 : 0);
          return Vec3(side * q.x() + slope * q.y() + offset, p.y(), q.y());
        });
    s.add(leaf);
  }
  // The mirrored leaflet is inside out; turn it.
  const std::size_t half = s.triangles.size() / 2;
  for (std::size_t t = 0; t < half; ++t) std::swap(s.triangles[t][1], s.triangles[t][2]);
  return in_tube(s, rectangle(20, 20), [](const Vec2&) { return -0.5; });
}

/// Moves everything together: the answer must move along and otherwise stay.
inline SealInput moved(SealInput in, const Mat3& rotation, const Vec3& shift) {
  for (Vec3& p : in.points) p = rotation * p + shift;
  for (Vec3& p : in.annulus) p = rotation * p + shift;
  in.tube.origin = rotation * in.tube.origin + shift;
  in.tube.axes = in.tube.axes * rotation.transpose();
  in.anterolateral = rotation * in.anterolateral;
  return in;
}

}  // namespace mv::test
