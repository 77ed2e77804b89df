// SPDX-License-Identifier: BSD-3-Clause
#include "solver/seal/triangle_set.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace mv::seal {

namespace {

constexpr std::size_t max_buckets = 4'000'000;

/// Side of (x, y) from the line a-b: exact ties are decided as if the point stood at (x + e, y + e^2). The end points are taken
/// in a fixed order, so that both triangles of an edge get the same rounding.
int side_of_edge(const Vec3& a, const Vec3& b, double x, double y, double& value) {
  const bool swapped = b.x() < a.x() || (b.x() == a.x() && b.y() < a.y());
  const Vec3& p = swapped ? b : a;
  const Vec3& q = swapped ? a : b;
  const double dx = q.x() - p.x(), dy = q.y() - p.y();
  double s = dx * (y - p.y()) - dy * (x - p.x());
  int sign = (s > 0) - (s < 0);
  if (sign == 0) sign = dy != 0 ? (dy > 0 ? -1 : 1) : (dx > 0) - (dx < 0);
  value = swapped ? -s : s;
  return swapped ? -sign : sign;
}

}  // namespace

TriangleSet::TriangleSet(std::vector<Vec3> points, std::vector<std::array<int, 3>> triangles)
    : points_(std::move(points)), triangles_(std::move(triangles)) {
  if (triangles_.empty()) return;
  lower_.setConstant(std::numeric_limits<double>::max());
  upper_ = -lower_;
  for (const auto& t : triangles_)
    for (int i : t) {
      lower_ = lower_.cwiseMin(points_[static_cast<std::size_t>(i)]);
      upper_ = upper_.cwiseMax(points_[static_cast<std::size_t>(i)]);
    }
  const Vec3 middle = 0.5 * (lower_ + upper_);
  double volume = 0;
  for (const auto& t : triangles_) {
    const Vec3 a = points_[static_cast<std::size_t>(t[0])] - middle, b = points_[static_cast<std::size_t>(t[1])] - middle,
               c = points_[static_cast<std::size_t>(t[2])] - middle;
    volume += a.dot(b.cross(c));
  }
  if (volume < 0)
    for (auto& t : triangles_) std::swap(t[1], t[2]);
  normals_.reserve(triangles_.size());
  for (const auto& t : triangles_) {
    const Vec3& a = points_[static_cast<std::size_t>(t[0])];
    const Vec3& b = points_[static_cast<std::size_t>(t[1])];
    const Vec3& c = points_[static_cast<std::size_t>(t[2])];
    corners_.push_back({a, b, c});
    const Vec3 lo = a.cwiseMin(b).cwiseMin(c), hi = a.cwiseMax(b).cwiseMax(c);
    middles_.push_back(0.5 * (lo + hi));
    radii_.push_back(std::sqrt(std::max(
        {(a - middles_.back()).squaredNorm(), (b - middles_.back()).squaredNorm(), (c - middles_.back()).squaredNorm()})));
    const Vec3 n = (b - a).cross(c - a);
    const double length = n.norm();
    normals_.push_back(length > 0 ? Vec3(n / length) : Vec3(Vec3::Zero()));
  }
  make_buckets();
}

void TriangleSet::make_buckets() {
  const Vec3 extent = upper_ - lower_;
  double mean = 0;
  for (const auto& t : triangles_)
    mean += (points_[static_cast<std::size_t>(t[1])] - points_[static_cast<std::size_t>(t[0])]).norm();
  mean = std::max(mean / static_cast<double>(triangles_.size()), 1e-6 * (1 + extent.maxCoeff()));
  bucket_ = 1.5 * mean;
  column_ = 0.6 * mean;
  const auto count = [](double length, double size) { return static_cast<std::size_t>(length / size) + 1; };
  while (count(extent.x(), bucket_) * count(extent.y(), bucket_) * count(extent.z(), bucket_) > max_buckets) bucket_ *= 1.3;
  while (count(extent.x(), column_) * count(extent.y(), column_) > max_buckets) column_ *= 1.3;
  for (int k = 0; k < 3; ++k) buckets_[static_cast<std::size_t>(k)] = static_cast<int>(count(extent[k], bucket_));
  for (int k = 0; k < 2; ++k) columns_[static_cast<std::size_t>(k)] = static_cast<int>(count(extent[k], column_));

  const auto box = [&](int t, Vec3& lo, Vec3& hi) {
    const auto& c = triangles_[static_cast<std::size_t>(t)];
    lo = hi = points_[static_cast<std::size_t>(c[0])];
    for (int i = 1; i < 3; ++i) {
      lo = lo.cwiseMin(points_[static_cast<std::size_t>(c[static_cast<std::size_t>(i)])]);
      hi = hi.cwiseMax(points_[static_cast<std::size_t>(c[static_cast<std::size_t>(i)])]);
    }
    lo -= lower_;
    hi -= lower_;
  };
  const auto fill = [&](auto&& for_each_bucket, std::size_t total, std::vector<int>& start, std::vector<int>& items) {
    start.assign(total + 1, 0);
    for (int t = 0; t < size(); ++t) for_each_bucket(t, [&](std::size_t b) { ++start[b + 1]; });
    for (std::size_t b = 0; b < total; ++b) start[b + 1] += start[b];
    items.resize(static_cast<std::size_t>(start[total]));
    std::vector<int> next(start.begin(), start.end() - 1);
    for (int t = 0; t < size(); ++t) for_each_bucket(t, [&](std::size_t b) { items[static_cast<std::size_t>(next[b]++)] = t; });
  };
  const auto index = [](double x, double size, int n) { return std::clamp(static_cast<int>(x / size), 0, n - 1); };
  fill(
      [&](int t, auto&& add) {
        Vec3 lo, hi;
        box(t, lo, hi);
        for (int k = index(lo.z(), bucket_, buckets_[2]); k <= index(hi.z(), bucket_, buckets_[2]); ++k)
          for (int j = index(lo.y(), bucket_, buckets_[1]); j <= index(hi.y(), bucket_, buckets_[1]); ++j)
            for (int i = index(lo.x(), bucket_, buckets_[0]); i <= index(hi.x(), bucket_, buckets_[0]); ++i)
              add((static_cast<std::size_t>(k) * static_cast<std::size_t>(buckets_[1]) + static_cast<std::size_t>(j)) *
                      static_cast<std::size_t>(buckets_[0]) +
                  static_cast<std::size_t>(i));
      },
      static_cast<std::size_t>(buckets_[0]) * static_cast<std::size_t>(buckets_[1]) * static_cast<std::size_t>(buckets_[2]),
      bucket_start_, bucket_items_);
  fill(
      [&](int t, auto&& add) {
        Vec3 lo, hi;
        box(t, lo, hi);
        for (int j = index(lo.y(), column_, columns_[1]); j <= index(hi.y(), column_, columns_[1]); ++j)
          for (int i = index(lo.x(), column_, columns_[0]); i <= index(hi.x(), column_, columns_[0]); ++i)
            add(static_cast<std::size_t>(j) * static_cast<std::size_t>(columns_[0]) + static_cast<std::size_t>(i));
      },
      static_cast<std::size_t>(columns_[0]) * static_cast<std::size_t>(columns_[1]), column_start_, column_items_);
  stamp_.assign(triangles_.size(), 0);
}

// Regions of a triangle in the order of Ericson, Real-Time Collision Detection (2005), section 5.1.5; written anew.
Vec3 TriangleSet::closest_point(int t, const Vec3& p) const {
  const auto& [a, b, d] = corners_[static_cast<std::size_t>(t)];
  const Vec3 ab = b - a, ad = d - a, ap = p - a;
  const double ab_ap = ab.dot(ap), ad_ap = ad.dot(ap);
  if (ab_ap <= 0 && ad_ap <= 0) return a;
  const Vec3 bp = p - b;
  const double ab_bp = ab.dot(bp), ad_bp = ad.dot(bp);
  if (ab_bp >= 0 && ad_bp <= ab_bp) return b;
  const double at_ab = ab_ap * ad_bp - ab_bp * ad_ap;
  if (at_ab <= 0 && ab_ap >= 0 && ab_bp <= 0) return a + (ab_ap > ab_bp ? ab_ap / (ab_ap - ab_bp) : 0.0) * ab;
  const Vec3 dp = p - d;
  const double ab_dp = ab.dot(dp), ad_dp = ad.dot(dp);
  if (ad_dp >= 0 && ab_dp <= ad_dp) return d;
  const double at_ad = ab_dp * ad_ap - ab_ap * ad_dp;
  if (at_ad <= 0 && ad_ap >= 0 && ad_dp <= 0) return a + (ad_ap > ad_dp ? ad_ap / (ad_ap - ad_dp) : 0.0) * ad;
  const double at_bd = ab_bp * ad_dp - ab_dp * ad_bp;
  const double along = ad_bp - ab_bp, back = ab_dp - ad_dp;
  if (at_bd <= 0 && along >= 0 && back >= 0) return b + (along + back > 0 ? along / (along + back) : 0.0) * (d - b);
  const double sum = at_bd + at_ad + at_ab;
  if (!(sum > 0)) return a;
  return a + (at_ad / sum) * ab + (at_ab / sum) * ad;
}

void TriangleSet::within(const Vec3& p, double radius, NearTriangles& out) const {
  out.centre = p;
  out.items.clear();
  if (empty()) return;
  std::array<int, 3> from, to;
  for (int k = 0; k < 3; ++k) {
    const auto s = static_cast<std::size_t>(k);
    const double x = p[k] - lower_[k];
    if (x + radius < 0 || x - radius > upper_[k] - lower_[k]) return;
    from[s] = std::clamp(static_cast<int>(std::floor((x - radius) / bucket_)), 0, buckets_[s] - 1);
    to[s] = std::clamp(static_cast<int>(std::floor((x + radius) / bucket_)), 0, buckets_[s] - 1);
  }
  ++stamp_now_;
  const double limit = radius * radius;
  for (int k = from[2]; k <= to[2]; ++k)
    for (int j = from[1]; j <= to[1]; ++j) {
      const std::size_t row =
          (static_cast<std::size_t>(k) * static_cast<std::size_t>(buckets_[1]) + static_cast<std::size_t>(j)) *
          static_cast<std::size_t>(buckets_[0]);
      const auto begin = static_cast<std::size_t>(bucket_start_[row + static_cast<std::size_t>(from[0])]);
      const auto end = static_cast<std::size_t>(bucket_start_[row + static_cast<std::size_t>(to[0]) + 1]);
      for (std::size_t n = begin; n < end; ++n) {
        const int t = bucket_items_[n];
        if (stamp_[static_cast<std::size_t>(t)] == stamp_now_) continue;
        stamp_[static_cast<std::size_t>(t)] = stamp_now_;
        if (is_farther(t, p, radius)) continue;
        if (const double d2 = squared_distance(t, p); d2 <= limit) out.items.push_back({std::sqrt(d2), t});
      }
    }
  std::sort(out.items.begin(), out.items.end());
}

double TriangleSet::distance_to(const NearTriangles& near, const Vec3& p, double cap, double floor) const {
  const double moved = (p - near.centre).norm();
  double best = cap, squared = cap * cap;
  for (const auto& [distance, t] : near.items) {
    if (distance - moved >= best) break;
    if (is_farther(t, p, best)) continue;
    const double d2 = squared_distance(t, p);
    if (!(d2 < squared)) continue;
    squared = d2;
    best = std::sqrt(d2);
    if (best <= floor) break;
  }
  return best;
}

int TriangleSet::nearest(const Vec3& p) const {
  if (empty()) return -1;
  NearTriangles found;
  const double farthest = (p.cwiseMax(upper_) - p.cwiseMin(lower_)).norm() * 1.001 + bucket_;
  for (double radius = bucket_; found.items.empty(); radius = std::min(2 * radius, farthest)) within(p, radius, found);
  return found.items.front().triangle;
}

int TriangleSet::crossing_sign(int t, double x, double y, double& z) const {
  const auto& c = triangles_[static_cast<std::size_t>(t)];
  const Vec3& p0 = points_[static_cast<std::size_t>(c[0])];
  const Vec3& p1 = points_[static_cast<std::size_t>(c[1])];
  const Vec3& p2 = points_[static_cast<std::size_t>(c[2])];
  double w0, w1, w2;
  const int s2 = side_of_edge(p0, p1, x, y, w2);
  const int s0 = side_of_edge(p1, p2, x, y, w0);
  if (s0 != s2 || s0 == 0) return 0;
  if (side_of_edge(p2, p0, x, y, w1) != s0) return 0;
  const double sum = w0 + w1 + w2;
  const double low = std::min({p0.z(), p1.z(), p2.z()}), high = std::max({p0.z(), p1.z(), p2.z()});
  z = sum != 0 ? std::clamp((w0 * p0.z() + w1 * p1.z() + w2 * p2.z()) / sum, low, high) : 0.5 * (low + high);
  return s0;
}

int TriangleSet::winding(const Vec3& p) const {
  if (empty() || (p.array() < lower_.array()).any() || (p.array() > upper_.array()).any()) return 0;
  const int i = std::clamp(static_cast<int>((p.x() - lower_.x()) / column_), 0, columns_[0] - 1);
  const int j = std::clamp(static_cast<int>((p.y() - lower_.y()) / column_), 0, columns_[1] - 1);
  const std::size_t b = static_cast<std::size_t>(j) * static_cast<std::size_t>(columns_[0]) + static_cast<std::size_t>(i);
  int winding = 0;
  for (auto n = static_cast<std::size_t>(column_start_[b]); n < static_cast<std::size_t>(column_start_[b + 1]); ++n)
    crossing(column_items_[n], p.x(), p.y(), [&](double z, int sign) {
      if (z > p.z()) winding += sign;
    });
  return winding;
}

}  // namespace mv::seal
