// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// One slave node against one triangle, and the smooth factors that weigh it. Pure functions, no memory.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <type_traits>

#include "geometry/core/pack.h"

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
/// (b1, b2). T: double, or Pack for several triangles.
template <class T>
struct Projection {
  T l1, l2, b1, b2;
  T lateral_squared;  // squared distance between the two
};

/// Of the point at d from corner a: `d1` = e1 . d, `d2` = e2 . d.
template <class T>
MV_INLINE Projection<T> project(T g11, T g12, T g22, T inverse_det, T d1, T d2) {
  const T zero{}, one = broadcast<T>(1.0);
  const auto unit = [&](T t) { return minimum(one, maximum(zero, t)); };
  Projection<T> q;
  q.l1 = (g22 * d1 - g12 * d2) * inverse_det;
  q.l2 = (g11 * d2 - g12 * d1) * inverse_det;
  const Mask<T> is_inside = (q.l1 >= zero) & (q.l2 >= zero) & (q.l1 + q.l2 <= one);
  if constexpr (std::is_same_v<T, double>)
    if (is_inside) return {q.l1, q.l2, q.l1, q.l2, 0.0};
  const auto distance = [&](T b1, T b2) {
    const T u = q.l1 - b1, v = q.l2 - b2;
    return g11 * u * u + 2.0 * g12 * u * v + g22 * v * v;
  };
  const T s = unit(d1 / g11), t = unit(d2 / g22), w = unit((d2 - d1 + g11 - g12) / (g11 - 2.0 * g12 + g22));
  q.b1 = s;
  q.b2 = zero;
  q.lateral_squared = distance(s, zero);
  const auto take = [&](Mask<T> nearer, T b1, T b2, T squared) {
    q.b1 = select(nearer, b1, q.b1);
    q.b2 = select(nearer, b2, q.b2);
    q.lateral_squared = select(nearer, squared, q.lateral_squared);
  };
  const T on_second = distance(zero, t), on_third = distance(one - w, w);
  take(on_second < q.lateral_squared, zero, t, on_second);
  take(on_third < q.lateral_squared, one - w, w, on_third);
  take(is_inside, q.l1, q.l2, zero);
  return q;
}

/// `d` = x - f.a.
inline Projection<double> project(const Facet& f, const Vec3& d) { return project<double>(f.g11, f.g12, f.g22, f.inverse_det, f.e1.dot(d), f.e2.dot(d)); }

/// 0 below 0, 1 above 1, continuously differentiable between.
template <class T>
MV_INLINE T smooth_step(T t) {
  t = minimum(broadcast<T>(1.0), maximum(T{}, t));
  return t * t * (3.0 - 2.0 * t);
}
inline double smooth_step_slope(double t) { return t > 0 && t < 1 ? 6 * t * (1 - t) : 0.0; }

}  // namespace mv::contact
