// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/annulus/annulus_check.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/annulus/annulus_fit.h"
#include "geometry/core/errors.h"

namespace mv {
namespace {

constexpr double smallest = 1, largest = 300;           // mm across, of any annulus
constexpr double human_smallest = 12, human_largest = 80;  // mm across
constexpr double most_turning = 4;                      // angle passed about the middle, to and fro, over a turn: noise reaches 2
constexpr double most_missing = 1.0 / 3, odd_missing = 0.2;  // of the curve, between two points ...
constexpr double odd_step = 4;                          // ... and over the mean distance of points
constexpr double farthest_tip = 200, odd_tip = 80;      // mm
constexpr int samples = 360;                            // of the curve, for its crossings
constexpr std::size_t most_points = 2000;               // of a curve that is not smoothed
constexpr double smallest_loop = 0.05;                  // of the curve's length; noise of dense points ties smaller ones

Vec3 middle(const std::vector<Vec3>& points) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

std::string place(const Vec3& p) { return fmt::format("({:.1f}, {:.1f}, {:.1f}) mm", p.x(), p.y(), p.z()); }

void check_size(const std::vector<Vec3>& curve, const std::string& name, std::vector<std::string>& notes) {
  const Vec3 centre = middle(curve);
  double across = 0;
  std::size_t far = 0;
  std::vector<double> distance;
  for (std::size_t i = 0; i < curve.size(); ++i) {
    distance.push_back((curve[i] - centre).norm());
    if (distance[i] > distance[far]) far = i;
    for (std::size_t j = 0; j < i; j += 1 + curve.size() / samples) across = std::max(across, (curve[i] - curve[j]).norm());
  }
  std::nth_element(distance.begin(), distance.begin() + static_cast<std::ptrdiff_t>(distance.size() / 2), distance.end());
  const double median = distance[distance.size() / 2];
  const std::string size = fmt::format("the annulus is {:.3g} mm across", across);
  if (across > largest && across > 6 * median)
    throw InputError(fmt::format("{}: {}, because of the point at {}, most lie within {:.3g} mm of their middle; correct or delete it", name, size, place(curve[far]), median));
  if (!(across >= smallest && across <= largest))
    throw InputError(fmt::format("{}: {}; expected 20 to 60 mm, from 1 to 300 mm are taken: are the coordinates in {} instead of millimetres?", name, size, across < smallest ? "metres" : "micrometres"));
  if (across < human_smallest || across > human_largest)
    notes.push_back(fmt::format("{}: {}; human ones measure 20 to 60 mm: are the coordinates in millimetres?", name, size));
}

/// Projection on the plane of the principal axes, about the middle of the curve, which dense points on one part of it do not move.
std::vector<Vec2> projected(const std::vector<Vec3>& curve, const Annulus& plane) {
  const Vec3 centre = plane.origin, x = plane.axis_major, y = plane.normal.cross(x);
  std::vector<Vec2> flat;
  for (const Vec3& p : curve) flat.emplace_back((p - centre).dot(x), (p - centre).dot(y));
  return flat;
}

void check_order(const std::vector<Vec2>& flat, const std::string& name) {
  double turned = 0, passed = 0;
  for (std::size_t i = 0; i < flat.size(); ++i) {
    const Vec2 &a = flat[i], &b = flat[(i + 1) % flat.size()];
    const double angle = std::atan2(cross(a, b), a.dot(b));
    turned += angle;
    passed += std::abs(angle);
  }
  const int times = static_cast<int>(std::lround(std::abs(turned) / (2 * std::numbers::pi)));
  if (passed > most_turning * 2 * std::numbers::pi * std::max(times, 1))
    throw InputError(name + ": the points of the annulus are not in order: from each to the next the curve jumps to and fro; list them one after the other around the annulus");
  if (times > 1) throw InputError(fmt::format("{}: the annulus goes round {} times: is the curve listed more than once? Expected each point once, in order", name, times));
  if (times == 0)
    throw InputError(name + ": the annulus does not go round its middle: a part of its points is listed backwards or missing; list them one after the other around the annulus");
}

void check_gaps(const std::vector<Vec3>& curve, const std::string& name, std::vector<std::string>& notes) {
  double length = 0, longest = 0;
  std::size_t where = 0;
  for (std::size_t i = 0; i < curve.size(); ++i) {
    const double step = (curve[(i + 1) % curve.size()] - curve[i]).norm();
    length += step;
    if (step > longest) longest = step, where = i;
  }
  if (longest < odd_missing * length || longest < odd_step * length / static_cast<double>(curve.size())) return;
  const std::string gap = fmt::format("{}: between {} and {} the annulus has no points over {:.0f} mm, {:.0f} % of its length", name, place(curve[where]), place(curve[(where + 1) % curve.size()]),
                                      longest, 100 * longest / length);
  if (longest > most_missing * length) throw InputError(gap + ": a part of the annulus is missing; expected a closed curve");
  notes.push_back(gap + ": it is closed by a straight line");
}

void check_crossings(const std::vector<Vec3>& curve, const std::vector<Vec2>& flat, const std::string& name) {
  const std::size_t n = flat.size();
  std::vector<double> passed{0};  // mm, from the first point
  for (std::size_t i = 0; i < n; ++i) passed.push_back(passed[i] + (curve[(i + 1) % n] - curve[i]).norm());
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 2; j < n; ++j) {
      const double loop = passed[j] - passed[i];
      if (std::min(loop, passed[n] - loop) < smallest_loop * passed[n]) continue;
      const Vec2 &a = flat[i], &b = flat[i + 1], &c = flat[j], &d = flat[(j + 1) % n];
      if (cross(b - a, c - a) * cross(b - a, d - a) < 0 && cross(d - c, a - c) * cross(d - c, b - c) < 0)
        throw InputError(fmt::format("{}: the annulus crosses itself near {} and goes through there again after {:.0f} % of its points: is a part of them listed in another order?", name, place(curve[i]),
                                     100.0 * static_cast<double>(j - i) / static_cast<double>(n)));
    }
}

}  // namespace

std::vector<std::string> check_annulus_curve(const std::vector<Vec3>& curve, const std::string& name, int harmonics) {
  std::vector<std::string> notes;
  check_size(curve, name, notes);
  Annulus plane;
  try {
    plane = fit_annulus_plane(curve);
  } catch (const InputError& e) {
    throw InputError(name + ": " + e.what());
  }
  check_order(projected(curve, plane), name);
  check_gaps(curve, name, notes);
  std::vector<Vec3> smooth;
  if (harmonics > 0) smooth = smooth_closed_curve(curve, harmonics, samples);
  else
    for (std::size_t i = 0; i < curve.size(); i += 1 + curve.size() / most_points) smooth.push_back(curve[i]);
  check_crossings(smooth, projected(smooth, plane), name);
  return notes;
}

std::vector<std::string> check_papillary_points(const std::vector<Vec3>& points, const std::vector<Vec3>& curve, const std::string& name) {
  const Vec3 centre = middle(curve);
  double most = 0;
  Vec3 far = centre;
  for (const Vec3& p : points)
    if (const double d = (p - centre).norm(); d > most) most = d, far = p;
  if (most <= odd_tip) return {};
  const std::string text = fmt::format("{}: the papillary point {} lies {:.0f} mm from the middle of the annulus {}; expected 15 to 50 mm: another unit, or another space (RAS, LPS)?", name, place(far), most, place(centre));
  if (most > farthest_tip) throw InputError(text);
  return {text};
}

}  // namespace mv
