// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// One slave node against one triangle, and the smooth factors that weigh it. Pure functions, no memory.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace mv::contact {

using Vec3 = Eigen::Vector3d;

/// What decides, for most pairs, that they do not see each other: one cache line.
struct alignas(64) FacetHead {
  Vec3 n = Vec3::Zero();       // outward unit normal; zero for a degenerate triangle
  Vec3 centre = Vec3::Zero();  // centroid
  double size = 0;             // largest distance from the centroid to a corner
  double area2 = 0;            // twice the area
};

inline FacetHead make_head(const Vec3& a, const Vec3& b, const Vec3& c) {
  FacetHead h;
  const Vec3 m = (b - a).cross(c - a);
  h.centre = (a + b + c) / 3;
  h.size =
      std::sqrt(std::max((a - h.centre).squaredNorm(), std::max((b - h.centre).squaredNorm(), (c - h.centre).squaredNorm())));
  h.area2 = m.norm();
  if (h.area2 > 0) h.n = m / h.area2;
  return h;
}

/// A triangle (a, a + e1, a + e2) ready for projections, with the metric of its edges.
struct Facet {
  Vec3 a, e1, e2;
  double g11, g12, g22, inverse_det;
};

/// `area2`: twice the area, positive.
inline Facet make_facet(const Vec3& a, const Vec3& b, const Vec3& c, double area2) {
  Facet f;
  f.a = a;
  f.e1 = b - a;
  f.e2 = c - a;
  f.g11 = f.e1.squaredNorm();
  f.g12 = f.e1.dot(f.e2);
  f.g22 = f.e2.squaredNorm();
  f.inverse_det = 1 / (area2 * area2);
  return f;
}

/// Foot of the perpendicular (barycentric l1, l2 of corners b, c; may lie outside) and the point of the triangle nearest to it
/// (b1, b2).
struct Projection {
  double l1, l2, b1, b2;
  double lateral_squared;  // squared distance between the two
};

/// `d` = x - f.a.
inline Projection project(const Facet& f, const Vec3& d) {
  const double d1 = f.e1.dot(d), d2 = f.e2.dot(d);
  Projection q;
  q.l1 = (f.g22 * d1 - f.g12 * d2) * f.inverse_det;
  q.l2 = (f.g11 * d2 - f.g12 * d1) * f.inverse_det;
  if (q.l1 >= 0 && q.l2 >= 0 && q.l1 + q.l2 <= 1) {
    q.b1 = q.l1;
    q.b2 = q.l2;
    q.lateral_squared = 0;
    return q;
  }
  const auto distance = [&](double b1, double b2) {
    const double u = q.l1 - b1, v = q.l2 - b2;
    return f.g11 * u * u + 2 * f.g12 * u * v + f.g22 * v * v;
  };
  const auto unit = [](double t) { return std::min(1.0, std::max(0.0, t)); };
  const double s = unit(d1 / f.g11), t = unit(d2 / f.g22);
  const double w = unit((d2 - d1 + f.g11 - f.g12) / (f.g11 - 2 * f.g12 + f.g22));
  q.b1 = s;
  q.b2 = 0;
  q.lateral_squared = distance(s, 0);
  const double on_second = distance(0, t), on_third = distance(1 - w, w);
  if (on_second < q.lateral_squared) {
    q.lateral_squared = on_second;
    q.b1 = 0;
    q.b2 = t;
  }
  if (on_third < q.lateral_squared) {
    q.lateral_squared = on_third;
    q.b1 = 1 - w;
    q.b2 = w;
  }
  return q;
}

/// 0 below 0, 1 above 1, continuously differentiable between.
inline double smooth_step(double t) {
  t = std::min(1.0, std::max(0.0, t));
  return t * t * (3 - 2 * t);
}
inline double smooth_step_slope(double t) { return t > 0 && t < 1 ? 6 * t * (1 - t) : 0.0; }

}  // namespace mv::contact
