// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// A funnel whose every measure is known: leaflets on a cone about -z, annulus at z = 0, free edge at z = -height; anterior: y > 0. Slices: planes x = const.

#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <vector>

#include "geometry/image/slice.h"
#include "geometry/loft/leaflet_curve.h"

namespace mv_test {

struct ConeValve {
  double annulus = 16, free_edge = 9, height = 14, thickness = 1.5;  // mm

  double slope() const { return (annulus - free_edge) / height; }
  double radius(double z) const { return annulus + slope() * z; }
  double length() const { return std::hypot(height, annulus - free_edge); }
  double area() const { return std::numbers::pi * (annulus + free_edge) * length(); }
  /// Distance from the mid-surface taken as endless cone; signed, positive outside.
  double distance(const mv::Vec3& p) const { return (std::hypot(p.x(), p.y()) - radius(p.z())) / std::hypot(1, slope()); }

  mv::LeafletCurve curve(double x, int region, double step = 0.5) const {
    mv::LeafletCurve c;
    c.region = region;
    c.plane_normal = mv::Vec3::UnitX();
    c.name = std::string(region == mv::anterior ? "anterior" : "posterior") + " at x = " + std::to_string(x);
    const double sign = region == mv::anterior ? 1 : -1;
    const int n = static_cast<int>(std::ceil(length() / step));
    for (int i = 0; i <= n; ++i) {
      const double z = -height * i / n, y = radius(z) * radius(z) - x * x;
      if (y < 0) break;
      c.points.emplace_back(x, sign * std::sqrt(y), z);
    }
    return c;
  }
  /// From annulus to annulus, |x| between the two radii.
  mv::LeafletCurve arch(double x, double step = 0.5) const {
    mv::LeafletCurve c;
    c.region = mv::anterior;
    c.plane_normal = mv::Vec3::UnitX();
    c.name = "arch at x = " + std::to_string(x);
    c.end = mv::CurveEnd::annulus;
    const double half = std::sqrt(annulus * annulus - x * x);
    const int n = static_cast<int>(std::ceil(2 * half / step));
    for (int i = 0; i <= n; ++i) {
      const double y = half - 2 * half * i / n;
      c.points.emplace_back(x, y, (std::hypot(x, y) - annulus) / slope());
      c.point_region.push_back(y > 0 ? mv::anterior : mv::posterior);
    }
    return c;
  }
  /// Curves on planes x = -reach .. reach, `step` apart.
  mv::CurveSet curves(double step, double offset = 0) const {
    mv::CurveSet set;
    int slice = 0;
    for (double x = -annulus + 0.5 * step + offset; x < annulus; x += step, ++slice) {
      if (std::abs(x) < free_edge - 0.3) {
        for (const int region : {mv::anterior, mv::posterior}) set.curves.push_back(curve(x, region));
        set.curves[set.curves.size() - 1].slice = set.curves[set.curves.size() - 2].slice = slice;
      } else if (std::abs(x) > free_edge + 0.3 && std::abs(x) < annulus - 1) {
        set.curves.push_back(arch(x));
        set.curves.back().slice = slice;
      }
    }
    set.stack_normal = mv::Vec3::UnitX();
    return set;
  }

  /// Slices with walls: leaflets of the given thickness, an atrial wall above and around the annulus, papillary muscles.
  std::vector<mv::Slice> slices(double step, double pixel, bool with_walls = true, bool with_names = true) const {
    std::vector<mv::Slice> stack;
    using mv::SlicePart;
    const int w = static_cast<int>(2 * (annulus + 6) / pixel), h = static_cast<int>((height + 24) / pixel);
    int number = 0;
    for (double x = -annulus - step; x <= annulus + step; x += step) {
      mv::Slice s;
      s.name = "slice " + std::to_string(number++);
      s.width = w;
      s.height = h;
      s.origin = {x, -0.5 * (w - 1) * pixel, 6};
      s.step_x = {0, pixel, 0};
      s.step_y = {0, 0, -pixel};
      for (int j = 0; j < h; ++j)
        for (int i = 0; i < w; ++i) {
          const mv::Vec3 p = s.world(i, j);
          SlicePart part = SlicePart::none;
          const double r = std::hypot(p.x(), p.y());
          if (p.z() <= 0 && p.z() >= -height && std::abs(distance(p)) <= 0.5 * thickness)
            part = !with_names ? SlicePart::leaflet : p.y() > 0 ? SlicePart::anterior : SlicePart::posterior;
          else if (with_walls && p.z() > 0 && p.z() < 4 && r > annulus - 1.5 && r < annulus + 3)
            part = SlicePart::atrium;
          else if (with_walls && (p - mv::Vec3(-8, -2, -28)).norm() < 3)
            part = SlicePart::papillary_anterolateral;
          else if (with_walls && (p - mv::Vec3(8, -2, -28)).norm() < 3)
            part = SlicePart::papillary_posteromedial;
          s.parts.push_back(static_cast<std::uint8_t>(part));
        }
      stack.push_back(s);
    }
    return stack;
  }
};

/// Reproducible noise, uniform in [-1, 1].
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : state_(seed * 2862933555777941757ULL + 3037000493ULL) {}
  double operator()() {
    state_ = state_ * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(state_ >> 11) / 4503599627370496.0 - 1;
  }
  mv::Vec3 vector() {
    const double x = (*this)(), y = (*this)();
    return {x, y, (*this)()};
  }

 private:
  std::uint64_t state_;
};

}  // namespace mv_test
