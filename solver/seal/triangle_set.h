// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Exact distance and inside tests against a closed triangle surface, with buckets. Internal to solver/seal; one thread at a time.

#include <array>
#include <vector>

#include "geometry/core/case.h"

namespace mv::seal {

/// Triangles around a centre, nearest first, so that a search near the centre can stop early.
struct NearTriangles {
  struct Item {
    double distance;
    int triangle;
    bool operator<(const Item& o) const { return distance != o.distance ? distance < o.distance : triangle < o.triangle; }
  };
  Vec3 centre = Vec3::Zero();
  std::vector<Item> items;
};

class TriangleSet {
 public:
  /// Orientation is turned outwards when the enclosed volume is negative. An empty set is allowed.
  TriangleSet(std::vector<Vec3> points, std::vector<std::array<int, 3>> triangles);

  int size() const { return static_cast<int>(triangles_.size()); }
  bool empty() const { return triangles_.empty(); }
  const std::vector<Vec3>& points() const { return points_; }
  const std::array<int, 3>& triangle(int t) const { return triangles_[static_cast<std::size_t>(t)]; }
  const Vec3& lower() const { return lower_; }
  const Vec3& upper() const { return upper_; }

  Vec3 closest_point(int t, const Vec3& p) const;
  double squared_distance(int t, const Vec3& p) const { return (closest_point(t, p) - p).squaredNorm(); }

  /// Ball around the triangle's bounding box.
  const Vec3& middle(int t) const { return middles_[static_cast<std::size_t>(t)]; }
  double radius(int t) const { return radii_[static_cast<std::size_t>(t)]; }

  /// True when the triangle is certainly further than `limit` from p.
  bool is_farther(int t, const Vec3& p, double limit) const {
    const double sum = limit + radius(t);
    return (p - middle(t)).squaredNorm() > sum * sum;
  }

  /// Unit normal, outwards; zero for a degenerate triangle.
  const Vec3& normal(int t) const { return normals_[static_cast<std::size_t>(t)]; }

  /// Triangles no further than `radius` from `p`; `out` is overwritten.
  void within(const Vec3& p, double radius, NearTriangles& out) const;

  /// Distance from p to the nearest of `near`, at most `cap`; where it is no more than `floor`, any number up to `floor`.
  double distance_to(const NearTriangles& near, const Vec3& p, double cap, double floor = -1) const;

  /// Nearest triangle, -1 for an empty set.
  int nearest(const Vec3& p) const;

  /// In how many solids p lies, by signed crossings of the ray towards +z. Edges and vertices hit exactly are decided by a
  /// symbolic shift that is the same for all triangles around them.
  int winding(const Vec3& p) const;
  bool is_inside(const Vec3& p) const { return winding(p) > 0; }

  /// Calls found(z, sign) for every crossing of the vertical line through (x, y) with triangle t (at most one); sign +1 where the
  /// line leaves the solid upwards.
  template <class Found>
  void crossing(int t, double x, double y, Found&& found) const {
    double z = 0;
    if (const int sign = crossing_sign(t, x, y, z)) found(z, sign);
  }

 private:
  int crossing_sign(int t, double x, double y, double& z) const;
  void make_buckets();

  std::vector<Vec3> points_;
  std::vector<std::array<int, 3>> triangles_;
  std::vector<std::array<Vec3, 3>> corners_;  // of each triangle, side by side
  std::vector<Vec3> normals_, middles_;
  std::vector<double> radii_;
  Vec3 lower_ = Vec3::Zero(), upper_ = Vec3::Zero();
  // space buckets and column buckets, compressed rows
  double bucket_ = 1, column_ = 0.5;
  std::array<int, 3> buckets_{0, 0, 0};
  std::array<int, 2> columns_{0, 0};
  std::vector<int> bucket_start_, bucket_items_, column_start_, column_items_;
  mutable std::vector<int> stamp_;
  mutable int stamp_now_ = 0;
};

}  // namespace mv::seal
