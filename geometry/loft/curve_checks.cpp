// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/loft/curve_checks.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/core/errors.h"

namespace mv {
namespace {

constexpr double annulus_off_hinges = 15;  // mm

constexpr double shortest = 1, longest = 150;  // mm, of any leaflet curve
constexpr std::size_t neighbours = 4;          // curves that vote on a direction

double length_of(const std::vector<Vec3>& points) {
  double sum = 0;
  for (std::size_t i = 1; i < points.size(); ++i) sum += (points[i] - points[i - 1]).norm();
  return sum;
}

void remove_repeated_points(LeafletCurve& curve, std::vector<std::string>& notes) {
  LeafletCurve clean = curve;
  clean.points.clear();
  clean.thickness.clear();
  clean.point_region.clear();
  for (std::size_t i = 0; i < curve.points.size(); ++i) {
    if (!clean.points.empty() && (curve.points[i] - clean.points.back()).norm() < 1e-6) continue;
    clean.points.push_back(curve.points[i]);
    if (!curve.thickness.empty()) clean.thickness.push_back(curve.thickness[i]);
    if (!curve.point_region.empty()) clean.point_region.push_back(curve.point_region[i]);
  }
  const auto removed = curve.points.size() - clean.points.size();
  if (removed > 0) notes.push_back(fmt::format("{}: {} repeated points removed", curve.name, removed));
  curve = clean;
}

/// The curve seen along the direction in which it is flattest.
std::vector<Vec2> flattened(const std::vector<Vec3>& points) {
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) mean += p / static_cast<double>(points.size());
  Mat3 covariance = Mat3::Zero();
  for (const Vec3& p : points) covariance += (p - mean) * (p - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(covariance);
  std::vector<Vec2> flat;
  for (const Vec3& p : points) flat.emplace_back((p - mean).dot(eigen.eigenvectors().col(2)), (p - mean).dot(eigen.eigenvectors().col(1)));
  return flat;
}

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

void check_crossing(const LeafletCurve& curve) {
  const std::vector<Vec2> p = flattened(curve.points);
  const double close = 0.1 * length_of(curve.points);
  for (std::size_t i = 0; i + 1 < p.size(); ++i)
    for (std::size_t j = i + 2; j + 1 < p.size(); ++j) {
      const Vec2 a = p[i + 1] - p[i], b = p[j + 1] - p[j], c = p[j] - p[i];
      const double d = cross(a, b);
      if (d == 0) continue;
      const double s = cross(c, b) / d, t = cross(c, a) / d;
      if (s < 0 || s > 1 || t < 0 || t > 1) continue;
      const Vec3 x = curve.points[i] + s * (curve.points[i + 1] - curve.points[i]);
      const Vec3 y = curve.points[j] + t * (curve.points[j + 1] - curve.points[j]);
      if ((x - y).norm() > close) continue;  // passes over itself at a distance
      throw InputError(fmt::format("{}: the curve crosses itself at ({:.2f}, {:.2f}, {:.2f}) mm, between points {}-{} and {}-{}; expected "
                                   "points in order from annulus to free edge, one curve of one leaflet",
                                   curve.name, x.x(), x.y(), x.z(), i + 1, i + 2, j + 1, j + 2));
    }
}

void check_curve(const LeafletCurve& curve) {
  if (curve.points.size() < 3)
    throw InputError(fmt::format("{}: {} distinct points, at least 3 are needed from annulus to free edge", curve.name, curve.points.size()));
  const double length = length_of(curve.points);
  if (length < shortest || length > longest)
    throw InputError(fmt::format("{}: the curve is {:.4g} mm long; a leaflet curve has {} to {} mm. Is the file in millimetres?", curve.name,
                                 length, shortest, longest));
  for (std::size_t i = 1; i < curve.points.size(); ++i) {
    const double step = (curve.points[i] - curve.points[i - 1]).norm();
    if (curve.points.size() > 4 && step > 0.5 * length && step > 5)
      throw InputError(fmt::format("{}: the curve jumps {:.1f} mm from point {} to {}, half of its length or more; two curves under one name, or "
                                   "points out of order?",
                                   curve.name, step, i, i + 1));
  }
  check_crossing(curve);
}

void turn(LeafletCurve& curve) {
  std::reverse(curve.points.begin(), curve.points.end());
  std::reverse(curve.thickness.begin(), curve.thickness.end());
  std::reverse(curve.point_region.begin(), curve.point_region.end());
}

double distance_to(const std::vector<Vec3>& points, const Vec3& x) {
  double best = HUGE_VAL;
  for (const Vec3& p : points) best = std::min(best, (p - x).norm());
  return best;
}

/// Positive when the curve runs against its neighbours.
double disagreement(const CurveSet& set, std::size_t i) {
  std::vector<std::pair<double, double>> votes;  // distance, disagreement
  const LeafletCurve& c = set.curves[i];
  for (std::size_t j = 0; j < set.curves.size(); ++j) {
    const LeafletCurve& d = set.curves[j];
    if (j == i || d.end == CurveEnd::annulus || (c.region != 0 && d.region != 0 && c.region != d.region)) continue;
    const double same = (c.points.front() - d.points.front()).norm() + (c.points.back() - d.points.back()).norm();
    const double opposite = (c.points.front() - d.points.back()).norm() + (c.points.back() - d.points.front()).norm();
    votes.emplace_back(std::min(same, opposite), (same - opposite) * (d.is_hinge_first ? 3 : 1));
  }
  std::sort(votes.begin(), votes.end());
  double sum = 0;
  for (std::size_t k = 0; k < std::min(neighbours, votes.size()); ++k) sum += votes[k].second;
  return sum;
}

void agree_with_neighbours(CurveSet& set, std::vector<char>& turned) {
  for (int pass = 0; pass < 20; ++pass) {
    std::size_t worst = set.curves.size();
    double most = 1e-6;
    for (std::size_t i = 0; i < set.curves.size(); ++i) {
      if (set.curves[i].is_hinge_first || set.curves[i].end == CurveEnd::annulus) continue;
      const double d = disagreement(set, i);
      if (d > most) most = d, worst = i;
    }
    if (worst == set.curves.size()) return;
    turn(set.curves[worst]);
    turned[worst] ^= 1;
  }
}

Vec3 mean_end(const CurveSet& set, bool last) {
  Vec3 sum = Vec3::Zero();
  double n = 0;
  for (const auto& c : set.curves)
    if (c.end != CurveEnd::annulus) sum += last ? c.points.back() : c.points.front(), ++n;
  return sum / std::max(n, 1.0);
}

double ring_size(const CurveSet& set, bool last) {
  const Vec3 center = mean_end(set, last);
  double sum = 0;
  for (const auto& c : set.curves)
    if (c.end != CurveEnd::annulus) sum += ((last ? c.points.back() : c.points.front()) - center).norm();
  return sum;
}

std::vector<Vec3> papillary_evidence(const CurveSet& set) {
  std::vector<Vec3> points = set.papillary_points;
  for (const auto& cloud : set.papillary_clouds) points.insert(points.end(), cloud.begin(), cloud.end());
  return points;
}

/// Whether the free edge is at the curves' first points; `sure`: the papillary muscles say so.
bool is_all_backwards(const CurveSet& set, bool is_order_meant, bool& sure) {
  const std::vector<Vec3> muscles = papillary_evidence(set);
  sure = false;
  if (!muscles.empty()) {
    Vec3 center = Vec3::Zero();
    for (const Vec3& p : muscles) center += p / static_cast<double>(muscles.size());
    const double front = (mean_end(set, false) - center).norm(), back = (mean_end(set, true) - center).norm();
    sure = std::abs(front - back) > 2;
    if (sure) return front < back;
  }
  return !is_order_meant && ring_size(set, false) < ring_size(set, true);
}

}  // namespace

void clean_curves(CurveSet& set) {
  for (LeafletCurve& curve : set.curves) {
    for (std::size_t i = 0; i < curve.points.size(); ++i)
      if (!curve.points[i].allFinite()) throw InputError(fmt::format("{}: point {} is not finite", curve.name, i + 1));
    remove_repeated_points(curve, set.notes);
    check_curve(curve);
  }
  std::vector<LeafletCurve> kept;
  for (const LeafletCurve& curve : set.curves) {
    const auto twin = std::find_if(kept.begin(), kept.end(), [&](const LeafletCurve& other) {
      if (other.points.size() != curve.points.size()) return false;
      double most = 0;
      for (std::size_t i = 0; i < curve.points.size(); ++i) most = std::max(most, (other.points[i] - curve.points[i]).norm());
      return most < 1e-6;
    });
    if (twin == kept.end()) kept.push_back(curve);
    else set.notes.push_back(fmt::format("{}: the same points as {}; left out", curve.name, twin->name));
  }
  set.curves = kept;
}

void orient_curves(CurveSet& set, bool is_order_meant) {
  std::vector<char> turned(set.curves.size(), 0);
  if (!set.annulus_curve.empty()) {
    for (std::size_t i = 0; i < set.curves.size(); ++i) {
      LeafletCurve& c = set.curves[i];
      if (c.is_hinge_first || c.end == CurveEnd::annulus) continue;
      if (distance_to(set.annulus_curve, c.points.back()) < distance_to(set.annulus_curve, c.points.front())) turn(c), turned[i] ^= 1;
    }
    std::vector<double> off;
    for (const LeafletCurve& c : set.curves) off.push_back(distance_to(set.annulus_curve, c.points.front()));
    std::nth_element(off.begin(), off.begin() + static_cast<std::ptrdiff_t>(off.size() / 2), off.end());
    if (!off.empty() && off[off.size() / 2] > annulus_off_hinges)
      throw InputError(fmt::format("the drawn annulus lies {:.0f} mm from the ends of the leaflet curves (median); expected them on it: another space (RAS, LPS), unit or valve?", off[off.size() / 2]));
  } else {
    agree_with_neighbours(set, turned);
    const bool some_known = std::any_of(set.curves.begin(), set.curves.end(), [](const auto& c) { return c.is_hinge_first; });
    bool sure = false;
    if (!some_known && is_all_backwards(set, is_order_meant, sure)) {
      for (std::size_t i = 0; i < set.curves.size(); ++i)
        if (set.curves[i].end != CurveEnd::annulus) turn(set.curves[i]), turned[i] ^= 1;
      if (is_order_meant) set.notes.push_back("all curves were drawn from the free edge to the annulus, as the papillary points tell; turned");
    }
    if (is_order_meant && !some_known && !sure)
      set.notes.push_back(fmt::format("the curves are taken as drawn from annulus to free edge; nothing in the data confirms it (papillary points or a drawn annulus would){}",
                                      ring_size(set, false) < ring_size(set, true) ? ", and their first ends form the smaller ring" : ""));
  }
  const auto count = std::count(turned.begin(), turned.end(), 1);
  if (!is_order_meant || count == static_cast<long>(set.curves.size())) return;
  for (std::size_t i = 0; i < turned.size(); ++i)
    if (turned[i]) set.notes.push_back(fmt::format("{}: drawn from the free edge to the annulus, against the others; turned", set.curves[i].name));
}

void assign_regions(CurveSet& set) {
  // Arches without a leaflet stay so: their points belong to either side of the commissure.
  const auto is_one_sided = [](const LeafletCurve& c) { return c.end != CurveEnd::annulus; };
  const auto count_all = std::count_if(set.curves.begin(), set.curves.end(), is_one_sided);
  const auto unknown = std::count_if(set.curves.begin(), set.curves.end(), [&](const LeafletCurve& c) { return is_one_sided(c) && c.region == 0; });
  if (unknown == 0) return;
  if (unknown != count_all)
    throw InputError(fmt::format("{} of {} curves belong to no leaflet; expected anterior or posterior for all of them, or for none", unknown, count_all));
  if (set.stack_normal.norm() == 0)
    throw InputError("the curves name no leaflet and do not come from parallel slices; expected anterior or posterior for each curve");
  // Across the slices' common direction within the annulus: the direction in which the hinge points of one slice lie apart.
  const Vec3 center = mean_end(set, false), depth = (mean_end(set, true) - center).normalized();
  const Vec3 side = set.stack_normal.cross(depth).normalized();
  double length[2] = {0, 0}, count[2] = {0, 0};
  std::vector<int> of_curve;
  for (const auto& c : set.curves) {
    const int k = (c.points.front() - center).dot(side) > 0 ? 1 : 0;
    of_curve.push_back(k);
    if (!is_one_sided(c)) continue;
    length[k] += length_of(c.points), ++count[k];
  }
  if (count[0] < 3 || count[1] < 3)
    throw InputError(fmt::format("the mask names no leaflet, and its curves fall into sides of {} and {}: expected at least 3 of each leaflet", count[0], count[1]));
  const double mean[2] = {length[0] / count[0], length[1] / count[1]};
  const int front = mean[1] > mean[0] ? 1 : 0;
  for (std::size_t i = 0; i < set.curves.size(); ++i)
    if (is_one_sided(set.curves[i])) set.curves[i].region = of_curve[i] == front ? anterior : posterior;
  set.notes.push_back(fmt::format("the mask names no leaflet: the side with the longer curves ({:.1f} mm against {:.1f} mm) was taken as anterior", mean[front],
                                  mean[1 - front]));
}

std::vector<std::vector<int>> join_arches(CurveSet& set) {
  std::vector<LeafletCurve> result;
  std::vector<std::vector<int>> regions;
  std::vector<char> used(set.curves.size(), 0);
  for (std::size_t i = 0; i < set.curves.size(); ++i) {
    if (used[i]) continue;
    LeafletCurve curve = set.curves[i];
    const auto regions_of = [](const LeafletCurve& c) { return c.point_region.empty() ? std::vector<int>(c.points.size(), c.region) : c.point_region; };
    std::vector<int> region = regions_of(curve);
    if (curve.end == CurveEnd::joined) {
      std::size_t partner = set.curves.size();
      double best = HUGE_VAL;
      for (std::size_t j = i + 1; j < set.curves.size(); ++j) {
        const auto& other = set.curves[j];
        if (used[j] || other.end != CurveEnd::joined || other.slice != curve.slice) continue;
        const double d = (other.points.back() - curve.points.back()).norm();
        if (d < best) best = d, partner = j;
      }
      if (partner < set.curves.size()) {
        LeafletCurve other = set.curves[partner];
        used[partner] = 1;
        turn(other);
        curve.points.insert(curve.points.end(), other.points.begin(), other.points.end());
        if (!curve.thickness.empty() && !other.thickness.empty())
          curve.thickness.insert(curve.thickness.end(), other.thickness.begin(), other.thickness.end());
        else curve.thickness.clear();
        const std::vector<int> more = regions_of(other);
        region.insert(region.end(), more.begin(), more.end());
        curve.name += " with " + other.name;
        curve.end = CurveEnd::annulus;
      }
    }
    result.push_back(curve);
    regions.push_back(region);
  }
  set.curves = result;
  return regions;
}

}  // namespace mv
