// SPDX-License-Identifier: BSD-3-Clause
#include "solver/seal/polygon.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "solver/seal/valve_metrics.h"

namespace mv {

namespace seal {

double signed_area(std::span<const Vec2> polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 a = polygon[i] - polygon[0], b = polygon[(i + 1) % polygon.size()] - polygon[0];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return 0.5 * twice;
}

bool polygon_contains(std::span<const Vec2> polygon, const Vec2& p) {
  bool inside = false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2& a = polygon[i];
    const Vec2& b = polygon[(i + 1) % polygon.size()];
    if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()))
      inside = !inside;
  }
  return inside;
}

NearestOnLoop nearest_on_loop(std::span<const Vec2> polygon, const Vec2& p) {
  NearestOnLoop best;
  double best_squared = std::numeric_limits<double>::max();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2& a = polygon[i];
    const Vec2 e = polygon[(i + 1) % polygon.size()] - a;
    const double length2 = e.squaredNorm();
    const double s = length2 > 0 ? std::clamp(e.dot(p - a) / length2, 0.0, 1.0) : 0.0;
    const double d2 = (p - a - s * e).squaredNorm();
    if (d2 < best_squared) {
      best_squared = d2;
      best.edge = i;
      best.along = s;
    }
  }
  best.distance = std::sqrt(best_squared);
  return best;
}

}  // namespace seal

// Between two neighbouring levels (heights of corners and of crossings) no two edges cross, so that the wound region is a row of
// trapezoids.
double positively_wound_area(std::span<const Vec2> polygon) {
  const std::size_t n = polygon.size();
  if (n < 3) return 0;
  const auto corner = [&](std::size_t i) -> const Vec2& { return polygon[i % n]; };
  std::vector<double> levels;
  for (const Vec2& p : polygon) levels.push_back(p.y());
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) {
      const Vec2 &a = corner(i), &b = corner(i + 1), &c = corner(j), &d = corner(j + 1);
      if (std::max(a.y(), b.y()) < std::min(c.y(), d.y()) || std::max(c.y(), d.y()) < std::min(a.y(), b.y()) ||
          std::max(a.x(), b.x()) < std::min(c.x(), d.x()) || std::max(c.x(), d.x()) < std::min(a.x(), b.x()))
        continue;
      const Vec2 e = b - a, f = d - c, g = c - a;
      const double cross = e.x() * f.y() - e.y() * f.x();
      if (cross == 0) continue;
      const double s = (g.x() * f.y() - g.y() * f.x()) / cross, t = (g.x() * e.y() - g.y() * e.x()) / cross;
      if (s >= 0 && s <= 1 && t >= 0 && t <= 1) levels.push_back(a.y() + s * e.y());
    }
  std::sort(levels.begin(), levels.end());
  levels.erase(std::unique(levels.begin(), levels.end()), levels.end());

  struct Flank {
    double middle, bottom, top;
    int winding;
  };
  std::vector<Flank> sides;
  double area = 0;
  for (std::size_t k = 0; k + 1 < levels.size(); ++k) {
    const double y0 = levels[k], y1 = levels[k + 1], ym = 0.5 * (y0 + y1);
    sides.clear();
    for (std::size_t i = 0; i < n; ++i) {
      const Vec2 &a = corner(i), &b = corner(i + 1);
      if ((a.y() > ym) == (b.y() > ym)) continue;
      const auto x_at = [&](double y) { return a.x() + (y - a.y()) / (b.y() - a.y()) * (b.x() - a.x()); };
      sides.push_back({x_at(ym), x_at(y0), x_at(y1), b.y() > a.y() ? -1 : 1});
    }
    std::sort(sides.begin(), sides.end(), [](const Flank& l, const Flank& r) { return l.middle < r.middle; });
    int winding = 0;  // counter-clockwise: the left side of a region runs downwards
    for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
      winding += sides[i].winding;
      if (winding > 0) area += 0.5 * (y1 - y0) * (sides[i + 1].bottom - sides[i].bottom + sides[i + 1].top - sides[i].top);
    }
  }
  return area;
}

}  // namespace mv
