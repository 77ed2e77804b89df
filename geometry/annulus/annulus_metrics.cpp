// SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/annulus/annulus_fit.h"
#include "geometry/core/errors.h"

namespace mv {
namespace {

constexpr int rim_points = 144;
constexpr int rings = 24;

/// Points where the curve crosses the plane through `origin` with unit normal `across`, farthest ahead and behind along `along`.
std::pair<Vec3, Vec3> crossing(const ClosedCurve& curve, const Vec3& origin, const Vec3& across, const Vec3& along) {
  constexpr int n = 4096;
  Vec3 ahead = origin, behind = origin;
  for (int i = 0; i < n; ++i) {
    const Vec3 a = curve.at(curve.length() * i / n), b = curve.at(curve.length() * (i + 1) / n);
    const double da = (a - origin).dot(across), db = (b - origin).dot(across);
    if ((da <= 0) == (db <= 0)) continue;
    const Vec3 x = a + (b - a) * (da / (da - db));
    if ((x - ahead).dot(along) > 0) ahead = x;
    if ((x - behind).dot(along) < 0) behind = x;
  }
  return {ahead, behind};
}

double triangle_area(const Vec3& a, const Vec3& b, const Vec3& c) { return 0.5 * (b - a).cross(c - a).norm(); }

/// Area of the surface whose height continues the rim's harmonically into the disc (rings scaled towards the centre): exact for a
/// plane curve, elsewhere an upper bound of the minimal surface, above it by the order (height / radius)^4.
double soap_film_area(const ClosedCurve& curve, const Vec3& origin, const Vec3& normal) {
  std::vector<Vec3> rim = curve.resampled(rim_points);
  std::vector<double> height(rim_points);
  for (int i = 0; i < rim_points; ++i)
    height[static_cast<std::size_t>(i)] = (rim[static_cast<std::size_t>(i)] - origin).dot(normal);
  // Fourier continuation of the rim height into the disc: h(r, t) = sum r^k (a_k cos kt + b_k sin kt), harmonic.
  using std::numbers::pi;
  constexpr int modes = 24;
  std::vector<double> a(modes + 1, 0.0), b(modes + 1, 0.0);
  for (int k = 0; k <= modes; ++k)
    for (int i = 0; i < rim_points; ++i) {
      const double angle = 2 * pi * k * i / rim_points;
      a[static_cast<std::size_t>(k)] += height[static_cast<std::size_t>(i)] * std::cos(angle) * (k ? 2.0 : 1.0) / rim_points;
      b[static_cast<std::size_t>(k)] += height[static_cast<std::size_t>(i)] * std::sin(angle) * 2.0 / rim_points;
    }
  auto point = [&](int ring, int i) -> Vec3 {
    const double r = static_cast<double>(ring) / rings;
    const Vec3& p = rim[static_cast<std::size_t>(i % rim_points)];
    if (ring == rings) return p;
    const Vec3 flat = p - (p - origin).dot(normal) * normal - origin;
    double h = 0;
    for (int k = 0; k <= modes; ++k) {
      const double angle = 2 * pi * k * i / rim_points;
      h += std::pow(r, k) * (a[static_cast<std::size_t>(k)] * std::cos(angle) + b[static_cast<std::size_t>(k)] * std::sin(angle));
    }
    return origin + r * flat + h * normal;
  };
  double area = 0;
  for (int ring = 0; ring < rings; ++ring)
    for (int i = 0; i < rim_points; ++i) {
      const Vec3 p00 = point(ring, i), p01 = point(ring, i + 1), p10 = point(ring + 1, i), p11 = point(ring + 1, i + 1);
      area += triangle_area(p00, p10, p11) + triangle_area(p00, p11, p01);
    }
  return area;
}

}  // namespace

AnnulusMetrics measure_annulus(const Annulus& annulus, const Vec3& anterior_direction) {
  const Vec3 n = annulus.normal;
  const Vec3 flat = anterior_direction - anterior_direction.dot(n) * n;
  if (!(flat.norm() > 1e-6)) throw InputError("annulus metrics: the anterior direction is perpendicular to the annulus plane");
  const Vec3 ap = flat.normalized(), lateral = ap.cross(n);
  const ClosedCurve curve(annulus.points);
  AnnulusMetrics m;
  m.perimeter = curve.length();
  const auto [anterior_point, posterior_point] = crossing(curve, annulus.origin, lateral, ap);
  const auto [al_point, pm_point] = crossing(curve, annulus.origin, ap, lateral);
  m.ap_diameter = (anterior_point - posterior_point).norm();
  m.al_pm_diameter = (al_point - pm_point).norm();
  m.sphericity = m.ap_diameter / m.al_pm_diameter;
  constexpr int samples = 2048;
  double lowest = 1e300, highest = -1e300, twice_area = 0;
  for (int i = 0; i < samples; ++i) {
    const Vec3 a = curve.at(curve.length() * i / samples) - annulus.origin;
    const Vec3 b = curve.at(curve.length() * (i + 1) / samples) - annulus.origin;
    lowest = std::min(lowest, a.dot(n));
    highest = std::max(highest, a.dot(n));
    twice_area += n.dot(a.cross(b));
    const Vec3 chord = b - a;
    m.perimeter_2d += (chord - chord.dot(n) * n).norm();
  }
  m.height = highest - lowest;
  m.height_above = -lowest;  // the normal points to the ventricle
  m.height_below = highest;
  m.area_2d = 0.5 * std::abs(twice_area);
  m.area_3d = soap_film_area(curve, annulus.origin, n);
  m.height_to_al_pm = m.height / m.al_pm_diameter;
  return m;
}

}  // namespace mv
