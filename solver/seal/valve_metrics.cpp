// SPDX-License-Identifier: BSD-3-Clause
#include "solver/seal/valve_metrics.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "geometry/core/errors.h"
#include "solver/seal/polygon.h"

namespace mv {

namespace {

const Vec3& point_of(std::span<const Vec3> points, int i) { return points[static_cast<std::size_t>(i)]; }

Vec3 area_vector(const Vec3& a, const Vec3& b, const Vec3& c) { return 0.5 * (b - a).cross(c - a); }

/// Two unit vectors that complete `up` to a right-handed frame.
std::pair<Vec3, Vec3> plane_axes(const Vec3& up) {
  const Vec3 other = std::abs(up.x()) < 0.6 ? Vec3::UnitX() : Vec3::UnitY();
  const Vec3 e1 = (other - other.dot(up) * up).normalized();
  return {e1, up.cross(e1)};
}

std::vector<Vec2> project(std::span<const Vec3> points, const AnnulusPlane& plane) {
  const auto [e1, e2] = plane_axes(plane.up);
  std::vector<Vec2> out;
  out.reserve(points.size());
  for (const Vec3& p : points) out.emplace_back(e1.dot(p - plane.origin), e2.dot(p - plane.origin));
  return out;
}

}  // namespace

Bulging measure_bulging(std::span<const Vec3> points, const Triangles& triangles, const AnnulusPlane& plane) {
  Bulging out;
  double total = 0, volume = 0;
  for (const auto& t : triangles) {
    std::array<Vec3, 3> p;
    std::array<double, 3> h;
    for (std::size_t i = 0; i < 3; ++i) {
      p[i] = point_of(points, t[i]);
      h[i] = plane.up.dot(p[i] - plane.origin);
      out.height_mm = std::max(out.height_mm, h[i]);
    }
    total += area_vector(p[0], p[1], p[2]).norm();
    // The part above the plane: a polygon of three or four corners, cut into a fan.
    std::array<Vec3, 4> corner;
    std::array<double, 4> height;
    std::size_t n = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3;
      if (h[i] > 0) corner[n] = p[i], height[n++] = h[i];
      if ((h[i] > 0) != (h[j] > 0)) corner[n] = p[i] + h[i] / (h[i] - h[j]) * (p[j] - p[i]), height[n++] = 0;
    }
    for (std::size_t i = 1; i + 1 < n; ++i) {
      const Vec3 a = area_vector(corner[0], corner[i], corner[i + 1]);
      out.area_mm2 += a.norm();
      volume += (height[0] + height[i] + height[i + 1]) / 3 * a.dot(plane.up);
    }
  }
  out.area_ratio = total > 0 ? out.area_mm2 / total : 0;
  out.volume_ml = volume * 1e-3;
  return out;
}

double volume_under_surface(std::span<const Vec3> points, const Triangles& triangles, const AnnulusPlane& plane) {
  double volume = 0;
  for (const auto& t : triangles) {
    const Vec3 a = point_of(points, t[0]), b = point_of(points, t[1]), c = point_of(points, t[2]);
    volume += plane.up.dot((a + b + c) / 3 - plane.origin) * area_vector(a, b, c).dot(plane.up);
  }
  return volume;
}

double swept_volume(std::span<const Vec3> x0, std::span<const Vec3> x1, const Triangles& triangles) {
  if (x0.size() != x1.size()) throw InputError("swept volume: the two states have different numbers of points");
  double volume = 0;
  for (const auto& t : triangles) {
    const Vec3 &a0 = point_of(x0, t[0]), &b0 = point_of(x0, t[1]), &c0 = point_of(x0, t[2]);
    const Vec3 &a1 = point_of(x1, t[0]), &b1 = point_of(x1, t[1]), &c1 = point_of(x1, t[2]);
    const Vec3 shift = (a1 - a0 + b1 - b0 + c1 - c0) / 3;
    const Vec3 area =
        (area_vector(a0, b0, c0) + 4 * area_vector(0.5 * (a0 + a1), 0.5 * (b0 + b1), 0.5 * (c0 + c1)) + area_vector(a1, b1, c1)) /
        6;
    volume += area.dot(shift);
  }
  return volume;
}

double enclosed_volume(std::span<const Vec3> points, const Triangles& triangles) {
  if (triangles.empty()) return 0;
  const Vec3 origin = point_of(points, triangles[0][0]);
  double volume = 0;
  for (const auto& t : triangles)
    volume += (point_of(points, t[0]) - origin)
                  .dot(area_vector(point_of(points, t[0]), point_of(points, t[1]), point_of(points, t[2])));
  return volume / 3;
}

std::vector<std::vector<int>> flagged_boundary_loops(const Triangles& triangles, std::span<const char> flagged) {
  std::map<std::pair<int, int>, int> uses;
  for (const auto& t : triangles)
    for (std::size_t e = 0; e < 3; ++e) ++uses[std::minmax(t[e], t[(e + 1) % 3])];
  std::multimap<int, int> next;
  std::map<int, int> arrivals;
  for (const auto& t : triangles)
    for (std::size_t e = 0; e < 3; ++e) {
      const int a = t[e], b = t[(e + 1) % 3];
      if (uses[std::minmax(a, b)] != 1 || !flagged[static_cast<std::size_t>(a)] || !flagged[static_cast<std::size_t>(b)])
        continue;
      next.emplace(a, b);
      ++arrivals[b];
    }
  std::vector<std::vector<int>> loops;
  while (!next.empty()) {
    auto begin = next.begin();  // an open chain must start where nothing arrives
    for (auto it = next.begin(); it != next.end(); ++it)
      if (!arrivals[it->first]) {
        begin = it;
        break;
      }
    std::vector<int> loop{begin->first};
    for (auto it = begin; it != next.end(); it = next.find(loop.back())) {
      const int to = it->second;
      next.erase(it);
      --arrivals[to];
      if (to == loop.front()) break;
      loop.push_back(to);
    }
    loops.push_back(std::move(loop));
  }
  std::stable_sort(loops.begin(), loops.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return loops;
}

double orifice_area_cm2(std::span<const Vec3> loop, std::span<const Vec3> reference_loop, const AnnulusPlane& plane) {
  if (loop.size() != reference_loop.size())
    throw InputError("orifice: the loop and its reference have different numbers of points");
  std::vector<Vec2> now = project(loop, plane);
  if (now.size() < 3) return 0;
  if (seal::signed_area(project(reference_loop, plane)) < 0) std::reverse(now.begin(), now.end());
  return positively_wound_area(now) * 1e-2;
}

Coaptation measure_coaptation(std::span<const Vec3> points, std::span<const Vec2> unfolded, std::span<const char> in_contact,
                              double u_from, double u_to, const AnnulusPlane& plane) {
  if (points.size() != unfolded.size() || points.size() != in_contact.size())
    throw InputError("coaptation: points, unfolded and in_contact differ in size");
  Coaptation out;
  double top = 0, bottom = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!in_contact[i] || unfolded[i].x() < u_from || unfolded[i].x() > u_to) continue;
    const double h = plane.up.dot(points[i] - plane.origin);
    top = out.present ? std::max(top, h) : h;
    bottom = out.present ? std::min(bottom, h) : h;
    out.present = true;
  }
  out.depth_mm = -top;
  out.height_mm = top - bottom;
  return out;
}

}  // namespace mv
