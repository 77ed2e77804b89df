// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Thick sheets with known mid-surfaces: a map (u, v) in [0, 1]^2 to the middle, its normal and thickness, closed to a solid.

#include <Eigen/Geometry>
#include <cmath>
#include <functional>

#include "geometry/surface/mid_surface_of_solid.h"

namespace solid_shapes {

using mv::Vec3;

struct Sheet {
  std::function<Vec3(double, double)> middle;
  std::function<Vec3(double, double)> normal;  // unit
  std::function<double(double, double)> thickness;
  bool periodic = false;  // in u
};

/// Flat rims across the thickness. Quads are split along the diagonal.
inline mv::SolidSurface solid_of(const Sheet& sheet, int nu, int nv, int nt, int label_below = 0, int label_above = 0) {
  mv::SolidSurface s;
  const int columns = sheet.periodic ? nu : nu + 1;
  // layer k = 0..nt of grid point (i, j); only the points on the outside are made
  std::vector<int> index(static_cast<std::size_t>(columns * (nv + 1) * (nt + 1)), -1);
  const auto id = [&](int i, int j, int k) {
    if (sheet.periodic) i %= nu;
    int& entry = index[static_cast<std::size_t>((k * (nv + 1) + j) * columns + i)];
    if (entry < 0) {
      const double u = static_cast<double>(i) / nu, v = static_cast<double>(j) / nv;
      entry = static_cast<int>(s.points.size());
      s.points.push_back(sheet.middle(u, v) + (static_cast<double>(k) / nt - 0.5) * sheet.thickness(u, v) * sheet.normal(u, v));
    }
    return entry;
  };
  const auto quad = [&](int a, int b, int c, int d, double u) {
    s.triangles.push_back({a, b, c});
    s.triangles.push_back({a, c, d});
    const int label = u < 0.5 ? label_below : label_above;
    s.label.insert(s.label.end(), {label, label});
  };
  for (int i = 0; i < nu; ++i) {
    const double u = (i + 0.5) / nu;
    for (int j = 0; j < nv; ++j) {
      quad(id(i, j, nt), id(i + 1, j, nt), id(i + 1, j + 1, nt), id(i, j + 1, nt), u);
      quad(id(i, j, 0), id(i, j + 1, 0), id(i + 1, j + 1, 0), id(i + 1, j, 0), u);
    }
    for (int k = 0; k < nt; ++k) {
      quad(id(i, 0, k), id(i + 1, 0, k), id(i + 1, 0, k + 1), id(i, 0, k + 1), u);
      quad(id(i, nv, k), id(i, nv, k + 1), id(i + 1, nv, k + 1), id(i + 1, nv, k), u);
    }
  }
  if (!sheet.periodic)
    for (int j = 0; j < nv; ++j)
      for (int k = 0; k < nt; ++k) {
        quad(id(0, j, k), id(0, j, k + 1), id(0, j + 1, k + 1), id(0, j + 1, k), 0);
        quad(id(nu, j, k), id(nu, j + 1, k), id(nu, j + 1, k + 1), id(nu, j, k + 1), 1);
      }
  double volume = 0;
  for (const auto& t : s.triangles) {
    const auto p = [&](int k) { return s.points[static_cast<std::size_t>(t[static_cast<std::size_t>(k)])]; };
    volume += p(0).dot(p(1).cross(p(2)));
  }
  if (volume < 0)
    for (auto& t : s.triangles) std::swap(t[1], t[2]);
  return s;
}

/// Part of a sphere shell from polar angle `from` to `to`, a ring around the axis.
inline Sheet sphere_zone(double radius, double thickness, double from, double to) {
  const auto direction = [=](double u, double v) {
    const double a = 2 * M_PI * u, p = from + (to - from) * v;
    return Vec3(std::sin(p) * std::cos(a), std::sin(p) * std::sin(a), std::cos(p));
  };
  return {[=](double u, double v) { return Vec3(radius * direction(u, v)); }, direction, [=](double, double) { return thickness; }, true};
}

/// Cone frustum: radius r0 at the top (v = 0) to r1 at the bottom, drop `height`, thickness t0 to t1.
inline Sheet cone(double r0, double r1, double height, double t0, double t1) {
  return {[=](double u, double v) {
            const double r = r0 + (r1 - r0) * v;
            return Vec3(r * std::cos(2 * M_PI * u), r * std::sin(2 * M_PI * u), -height * v);
          },
          [=](double u, double) {
            // outward normal of the frustum: radial part height, axial part (r1 - r0) along +z
            return Vec3(Vec3(height * std::cos(2 * M_PI * u), height * std::sin(2 * M_PI * u), r1 - r0).normalized());
          },
          [=](double, double v) { return t0 + (t1 - t0) * v; }, true};
}

/// Part of a cylinder's wall over an angle, a leaflet of its own.
inline Sheet cylinder_leaflet(double radius, double thickness, double angle_from, double angle_to, double height) {
  const auto direction = [=](double u) {
    const double a = angle_from + (angle_to - angle_from) * u;
    return Vec3(std::cos(a), std::sin(a), 0);
  };
  return {[=](double u, double v) { return Vec3(radius * direction(u) + Vec3(0, 0, -height * v)); },
          [=](double u, double) { return direction(u); }, [=](double, double) { return thickness; }, false};
}

inline void append(mv::SolidSurface& s, const mv::SolidSurface& other) {
  const int first = static_cast<int>(s.points.size());
  s.points.insert(s.points.end(), other.points.begin(), other.points.end());
  for (auto t : other.triangles) {
    for (int& v : t) v += first;
    s.triangles.push_back(t);
  }
  s.label.insert(s.label.end(), other.label.begin(), other.label.end());
}

/// Any pose: no axis of the shape along an axis of the frame.
inline void tilt(mv::SolidSurface& s) {
  mv::Mat3 m;
  m = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized());
  for (Vec3& p : s.points) p = m * p + Vec3(31, -470, 12);
}
inline Vec3 untilt(const Vec3& x) {
  mv::Mat3 m;
  m = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized());
  return m.transpose() * (x - Vec3(31, -470, 12));
}

}  // namespace solid_shapes
