// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/loft/surface_distance.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/core/errors.h"

namespace mv {
namespace {

struct Sample {
  Vec3 x;
  double area;
};

void sample_triangle(const Vec3& a, const Vec3& b, const Vec3& c, double spacing, std::vector<Sample>& samples) {
  const double longest = std::max({(a - b).norm(), (b - c).norm(), (c - a).norm()});
  if (longest > spacing) {
    const Vec3 ab = 0.5 * (a + b), bc = 0.5 * (b + c), ca = 0.5 * (c + a);
    sample_triangle(a, ab, ca, spacing, samples);
    sample_triangle(ab, b, bc, spacing, samples);
    sample_triangle(ca, bc, c, spacing, samples);
    sample_triangle(ab, bc, ca, spacing, samples);
    return;
  }
  samples.push_back({(a + b + c) / 3, 0.5 * (b - a).cross(c - a).norm()});
}

std::vector<Sample> sample_surface(const std::vector<Vec3>& points, const std::vector<std::array<int, 3>>& triangles, double spacing) {
  std::vector<Sample> samples;
  for (const auto& t : triangles)
    sample_triangle(points[static_cast<std::size_t>(t[0])], points[static_cast<std::size_t>(t[1])], points[static_cast<std::size_t>(t[2])], spacing, samples);
  return samples;
}

double segment_distance(const Vec3& x, const Vec3& a, const Vec3& b) {
  const Vec3 d = b - a;
  const double t = d.squaredNorm() > 0 ? std::clamp((x - a).dot(d) / d.squaredNorm(), 0.0, 1.0) : 0.0;
  return (x - a - t * d).norm();
}

}  // namespace

double triangle_distance(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 n = (b - a).cross(c - a);
  const double area2 = n.squaredNorm();
  if (area2 > 0) {
    const double u = (c - b).cross(x - b).dot(n), v = (a - c).cross(x - c).dot(n), w = (b - a).cross(x - a).dot(n);
    if (u >= 0 && v >= 0 && w >= 0) return std::abs((x - a).dot(n)) / std::sqrt(area2);
  }
  return std::min({segment_distance(x, a, b), segment_distance(x, b, c), segment_distance(x, c, a)});
}

std::vector<double> distances_to_surface(std::span<const Vec3> from, const std::vector<Vec3>& points, const std::vector<std::array<int, 3>>& triangles) {
  if (triangles.empty()) throw InputError("surface distance: a surface has no triangles");
  struct Ball {
    Vec3 center;
    double radius;
  };
  std::vector<Ball> balls;
  for (const auto& t : triangles) {
    for (const int k : t)
      if (k < 0 || k >= static_cast<int>(points.size())) throw InputError("surface distance: a triangle names a point that is not there");
    const Vec3 &a = points[static_cast<std::size_t>(t[0])], &b = points[static_cast<std::size_t>(t[1])], &c = points[static_cast<std::size_t>(t[2])];
    const Vec3 center = (a + b + c) / 3;
    balls.push_back({center, std::max({(a - center).norm(), (b - center).norm(), (c - center).norm()})});
  }
  std::vector<double> result;
  std::size_t last = 0;  // neighbours in `from` are near each other: their nearest triangle is a good first bound
  for (const Vec3& x : from) {
    const auto at = [&](std::size_t t) {
      const auto& k = triangles[t];
      return triangle_distance(x, points[static_cast<std::size_t>(k[0])], points[static_cast<std::size_t>(k[1])], points[static_cast<std::size_t>(k[2])]);
    };
    double best = at(last);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      const double reach = best + balls[t].radius;
      if ((x - balls[t].center).squaredNorm() >= reach * reach) continue;
      const double d = at(t);
      if (d < best) best = d, last = t;
    }
    result.push_back(best);
  }
  return result;
}

SurfaceDistance surface_distance(const std::vector<Vec3>& points_a, const std::vector<std::array<int, 3>>& triangles_a, const std::vector<Vec3>& points_b,
                                 const std::vector<std::array<int, 3>>& triangles_b, double spacing) {
  SurfaceDistance result;
  std::vector<std::pair<double, double>> all;  // distance, weight
  for (const bool forward : {true, false}) {
    const auto samples = forward ? sample_surface(points_a, triangles_a, spacing) : sample_surface(points_b, triangles_b, spacing);
    std::vector<Vec3> x;
    double area = 0;
    for (const Sample& s : samples) x.push_back(s.x), area += s.area;
    if (!(area > 0)) throw InputError("surface distance: a surface has no area");
    const auto d = forward ? distances_to_surface(x, points_b, triangles_b) : distances_to_surface(x, points_a, triangles_a);
    double& mean = forward ? result.mean_a_to_b : result.mean_b_to_a;
    for (std::size_t i = 0; i < d.size(); ++i) {
      mean += d[i] * samples[i].area / area;
      all.emplace_back(d[i], 0.5 * samples[i].area / area);
      result.max = std::max(result.max, d[i]);
    }
  }
  result.mean = 0.5 * (result.mean_a_to_b + result.mean_b_to_a);
  std::sort(all.begin(), all.end());
  double sum = 0;
  for (const auto& [d, weight] : all) {
    sum += weight;
    result.p95 = d;
    if (sum >= 0.95) break;
  }
  return result;
}

}  // namespace mv
