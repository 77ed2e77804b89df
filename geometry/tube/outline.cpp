// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/tube/outline.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/core/errors.h"

namespace mv {
namespace {

using std::numbers::pi;

/// Widening spreads over this angle to either side of a point that sticks out, so that no bump is sharper than the annulus
/// itself.
constexpr double spread_angle = 8 * pi / 180;

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

}  // namespace

double radius_at(const PolarOutline& outline, double angle) {
  const double n = static_cast<double>(outline.size());
  double x = angle / (2 * pi) * n;
  x -= n * std::floor(x / n);
  const auto i = std::min(static_cast<std::size_t>(x), outline.size() - 1);
  const double t = x - static_cast<double>(i);
  return (1 - t) * outline[i] + t * outline[(i + 1) % outline.size()];
}

Vec2 point_at(const PolarOutline& outline, double angle) {
  const double r = radius_at(outline, angle);
  return {r * std::cos(angle), r * std::sin(angle)};
}

PolarOutline smooth_polar_outline(const std::vector<Vec2>& polygon, int harmonics, int samples, double* deviation) {
  std::vector<Vec2> ring = polygon;
  double twice_area = 0;
  for (std::size_t i = 0; i < ring.size(); ++i) twice_area += cross(ring[i], ring[(i + 1) % ring.size()]);
  if (twice_area < 0) std::reverse(ring.begin(), ring.end());
  const std::size_t n = ring.size();
  for (std::size_t i = 0; i < n; ++i)
    if (!(cross(ring[i], ring[(i + 1) % n]) > 0))
      throw InputError("tube: the annulus outline turns back near its point " + std::to_string(i) +
                       " and has no single radius there; smooth the annulus");
  // Ray casting at many angles: walk the edges in step with the angle.
  constexpr int dense = 4096;
  std::vector<double> radius(dense);
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 &a = ring[i], &b = ring[(i + 1) % n];
    const double begin = std::atan2(a.y(), a.x()), sweep = std::atan2(cross(a, b), a.dot(b));
    const int first = static_cast<int>(std::ceil(begin / (2 * pi) * dense)),
              last = static_cast<int>(std::floor((begin + sweep) / (2 * pi) * dense));
    for (int k = first; k <= last; ++k) {
      const Vec2 direction(std::cos(2 * pi * k / dense), std::sin(2 * pi * k / dense));
      radius[static_cast<std::size_t>(((k % dense) + dense) % dense)] = cross(a, b - a) / cross(direction, b - a);
    }
  }
  PolarOutline outline(static_cast<std::size_t>(samples), 0.0);
  for (int h = 0; h <= harmonics; ++h) {
    double c = 0, s = 0;
    for (int k = 0; k < dense; ++k) {
      c += radius[static_cast<std::size_t>(k)] * std::cos(2 * pi * h * k / dense) * (h ? 2.0 : 1.0) / dense;
      s += radius[static_cast<std::size_t>(k)] * std::sin(2 * pi * h * k / dense) * 2.0 / dense;
    }
    for (int i = 0; i < samples; ++i) {
      const double angle = 2 * pi * h * i / samples;
      outline[static_cast<std::size_t>(i)] += c * std::cos(angle) + s * std::sin(angle);
    }
  }
  if (deviation) {
    *deviation = 0;
    for (int k = 0; k < dense; ++k)
      *deviation = std::max(*deviation, std::abs(radius_at(outline, 2 * pi * k / dense) - radius[static_cast<std::size_t>(k)]));
  }
  return outline;
}

double widen_to_contain(PolarOutline& outline, const std::vector<Vec2>& points, double clearance) {
  const int n = static_cast<int>(outline.size());
  std::vector<double> missing(outline.size(), 0.0);
  for (const Vec2& p : points) {
    const double angle = std::atan2(p.y(), p.x());
    const double shortfall = p.norm() + clearance - radius_at(outline, angle);
    if (shortfall <= 0) continue;
    const int i = static_cast<int>(std::floor(angle / (2 * pi) * n));
    for (int k : {i, i + 1}) {
      double& m = missing[static_cast<std::size_t>(((k % n) + n) % n)];
      m = std::max(m, shortfall);
    }
  }
  // Raising to the largest shortfall within the window and then averaging over the same window never falls below the shortfall
  // itself.
  const int window = std::max(1, static_cast<int>(std::lround(spread_angle / (2 * pi) * n)));
  auto wrapped = [&](int i) { return static_cast<std::size_t>(((i % n) + n) % n); };
  std::vector<double> raised(missing.size());
  for (int i = 0; i < n; ++i)
    for (int k = -window; k <= window; ++k) raised[wrapped(i)] = std::max(raised[wrapped(i)], missing[wrapped(i + k)]);
  double largest = 0;
  for (int i = 0; i < n; ++i) {
    double sum = 0, weights = 0;
    for (int k = -window; k <= window; ++k) {
      const double w = 1 + std::cos(pi * k / (window + 1));
      sum += w * raised[wrapped(i + k)];
      weights += w;
    }
    outline[wrapped(i)] += sum / weights;
    largest = std::max(largest, sum / weights);
  }
  return largest;
}

}  // namespace mv
