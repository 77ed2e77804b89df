// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Raw leaflets with known answers.

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "geometry/generic/generic_valve.h"
#include "geometry/surface/raw_leaflets.h"

namespace mv_test {

using mv::Vec3;

/// Ring of n columns and m rows of quads, each cut in two, uneven on purpose. x(phi, t), phi from +y counter-clockwise seen from +z, t = 0 at the
/// annulus.
inline mv::RawLeaflets ring(const std::function<Vec3(double, double)>& x, int n = 90, int m = 10) {
  mv::RawLeaflets raw;
  for (int j = 0; j <= m; ++j)
    for (int i = 0; i < n; ++i) {
      const double phi = 2 * std::numbers::pi * (i + 0.12 * std::sin(i + j)) / n;
      raw.points.push_back(x(phi, std::pow(static_cast<double>(j) / m, 1.2)));
    }
  for (int j = 0; j < m; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * n + i, b = j * n + (i + 1) % n, c = a + n, d = b + n;
      raw.triangles.push_back({a, d, b});
      raw.triangles.push_back({a, c, d});
    }
  return raw;
}

inline mv::RawLeaflets cylinder(double radius, double height) {
  return ring([=](double phi, double t) { return Vec3(-radius * std::sin(phi), radius * std::cos(phi), -height * t); });
}

/// The default generic valve, triangles of about 1.5 mm, labelled, atrium +z, anterior +y.
inline mv::RawLeaflets generic_raw(double spacing = 1.5) {
  const mv::GenericValve valve = mv::build_generic_valve(mv::GenericValveParameters{}, spacing);
  mv::RawLeaflets raw;
  raw.points = valve.mid_surface.points;
  raw.triangles = valve.mid_surface.triangles;
  raw.region = valve.mid_surface.region;
  raw.papillary_points = {{-10, -2, -32}, {10, -2, -32}};
  return raw;
}

inline void transform(mv::RawLeaflets& raw, const Eigen::Isometry3d& motion) {
  for (auto* list : {&raw.points, &raw.annulus_curve, &raw.commissures, &raw.papillary_points})
    for (Vec3& p : *list) p = motion * p;
  if (raw.anterior_hint) raw.anterior_hint = motion * *raw.anterior_hint;
  if (raw.ventricle_direction) raw.ventricle_direction = motion.linear() * *raw.ventricle_direction;
}

inline void add_noise(mv::RawLeaflets& raw, double sigma) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal(0, sigma);
  for (Vec3& p : raw.points) p += Vec3(normal(random), normal(random), normal(random));
}

/// Leaves out triangles; points stay.
inline void remove_if(mv::RawLeaflets& raw, const std::function<bool(const Vec3& centre, int region)>& goes) {
  mv::RawLeaflets kept = raw;
  kept.triangles.clear();
  kept.region.clear();
  for (std::size_t t = 0; t < raw.triangles.size(); ++t) {
    Vec3 centre = Vec3::Zero();
    for (int v : raw.triangles[t]) centre += raw.points[static_cast<std::size_t>(v)] / 3;
    if (goes(centre, raw.region.empty() ? 0 : raw.region[t])) continue;
    kept.triangles.push_back(raw.triangles[t]);
    if (!raw.region.empty()) kept.region.push_back(raw.region[t]);
  }
  raw = kept;
}

inline bool says(const std::vector<std::string>& notes, const std::string& what) {
  for (const std::string& n : notes)
    if (n.find(what) != std::string::npos) return true;
  return false;
}

}  // namespace mv_test
