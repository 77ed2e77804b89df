// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/core/errors.h"
#include "geometry/generic/generic_valve.h"

namespace mv {
namespace {

/// The wall is straight until it has used this share of the distance to the centre ...
constexpr double straight_share = 0.5;
/// ... and vertical from here on, so that at least a third of every radius stays open.
constexpr double largest_share = 0.65;

Vec3 in_plane(const Vec3& v, const Vec3& normal) { return v - v.dot(normal) * normal; }

/// Counter-clockwise seen from the atrium, that is about -normal.
std::vector<Vec3> oriented(const Annulus& annulus) {
  double twice_area = 0;
  const auto& p = annulus.points;
  for (std::size_t i = 0; i < p.size(); ++i)
    twice_area -= annulus.normal.dot((p[i] - annulus.origin).cross(p[(i + 1) % p.size()] - annulus.origin));
  std::vector<Vec3> points = p;
  if (twice_area < 0) std::reverse(points.begin(), points.end());
  return points;
}

}  // namespace

ConeWrap::ConeWrap(const Annulus& annulus, const Vec3& anterior_direction, const FlatPattern& pattern, double inward_slope)
    : curve_(oriented(annulus)), axis_(annulus.normal), slope_(inward_slope), pattern_(pattern) {
  if (!(inward_slope >= 0 && inward_slope <= 2)) throw ConfigError("generic.inward_slope must lie between 0 and 2");
  if (std::abs(curve_.length() - pattern.perimeter()) > 1e-6 * pattern.perimeter())
    throw InputError("generic valve: the pattern's base (" + std::to_string(pattern.perimeter()) +
                     " mm) is not as long as the annulus (" + std::to_string(curve_.length()) + " mm)");
  const Vec3 ahead = in_plane(anterior_direction, axis_).normalized();
  const Vec3 left = ahead.cross(axis_);  // u grows from -left over ahead to left: counter-clockwise about -axis
  constexpr int n = 2880;
  const double h = curve_.length() / n;
  // Area centroid of the projection; the height of the centre is the mean height of the curve.
  double twice_area = 0, mean_height = 0;
  Vec3 moment = Vec3::Zero();
  for (int i = 0; i < n; ++i) {
    const Vec3 a = in_plane(curve_.at(i * h) - annulus.origin, axis_),
               b = in_plane(curve_.at((i + 1) * h) - annulus.origin, axis_);
    const double cross = -axis_.dot(a.cross(b));
    twice_area += cross;
    moment += cross * (a + b) / 3;
    mean_height += (curve_.at(i * h) - annulus.origin).dot(axis_) / n;
  }
  centre_ = annulus.origin + moment / twice_area + mean_height * axis_;
  double crossing = -1;
  for (int i = 0; i < n; ++i) {
    const Vec3 a = curve_.at(i * h) - centre_, b = curve_.at((i + 1) * h) - centre_;
    if (!(-axis_.dot(a.cross(b)) > 0))
      throw InputError(fmt::format("generic valve: the annulus is not star-shaped about its centre: seen from there it turns back near ({:.1f}, {:.1f}, {:.1f}) mm; smooth it more "
                                   "(generic.smoothing_harmonics), or correct its points there",
                                   curve_.at(i * h).x(), curve_.at(i * h).y(), curve_.at(i * h).z()));
    if (a.dot(ahead) > 0 && a.dot(left) <= 0 && b.dot(left) > 0) crossing = h * (i + a.dot(left) / (a.dot(left) - b.dot(left)));
  }
  u_offset_ = crossing - pattern.parameters().anterior_radius;
  for (int i = 0; i < n; ++i) mean_radius_ += column(i * h).radius / n;
}

ConeWrap::Column ConeWrap::column(double u) const {
  Column c;
  c.start = curve_.at(u_offset_ + u);
  const Vec3 towards = in_plane(centre_ - c.start, axis_);
  c.radius = towards.norm();
  c.inward = towards / c.radius;
  return c;
}

ConeWrap::Profile ConeWrap::profile(double v, double radius) const {
  const double slope = slope_ * radius / mean_radius_;
  const double cosine = 1 / std::sqrt(1 + slope * slope), sine = slope * cosine;
  if (sine == 0) return {v, 0, 1, 0};
  const double straight = straight_share * radius / sine;
  if (v <= straight) return {cosine * v, sine * v, cosine, sine};
  // Circular arc of curvature k that uses up the remaining travel while turning from the cone's angle to vertical.
  const double k = (1 - cosine) / ((largest_share - straight_share) * radius);
  const double angle = std::asin(sine), turned = k * (v - straight);
  if (turned >= angle) {
    const double arc = angle / k;
    return {cosine * straight + sine / k + (v - straight - arc), largest_share * radius, 1, 0};
  }
  const double left = angle - turned;
  return {cosine * straight + (sine - std::sin(left)) / k, straight_share * radius + (std::cos(left) - cosine) / k,
          std::cos(left), std::sin(left)};
}

Vec3 ConeWrap::position(const Vec2& uv) const {
  const Column c = column(uv.x());
  const Profile p = profile(uv.y(), c.radius);
  return c.start + p.depth * axis_ + p.travel * c.inward;
}

Vec3 ConeWrap::along_v(const Vec2& uv) const {
  const Column c = column(uv.x());
  const Profile p = profile(uv.y(), c.radius);
  return p.cosine * axis_ + p.sine * c.inward;
}

Vec3 ConeWrap::along_u(const Vec2& uv) const {
  const double h = 1e-4 * curve_.length();
  return (position({uv.x() + h, uv.y()}) - position({uv.x() - h, uv.y()})) / (2 * h);
}

Vec3 ConeWrap::normal(const Vec2& uv) const { return along_u(uv).cross(along_v(uv)).normalized(); }

double ConeWrap::smallest_orifice_radius() const {
  double smallest = 1e300;
  constexpr int n = 1440;
  for (int i = 0; i < n; ++i) {
    const double u = pattern_.perimeter() * i / n;
    const Column c = column(u);
    smallest = std::min(smallest, c.radius - profile(pattern_.height(u), c.radius).travel);
  }
  return smallest;
}

}  // namespace mv
