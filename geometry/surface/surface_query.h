// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Nearest point of a triangle surface, quickly (CGAL's AABB tree, kept inside the .cpp).

#include <array>
#include <memory>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

class SurfaceQuery {
 public:
  /// Triangles without area are left out. Copies what it needs. Throws InputError when no triangle remains.
  SurfaceQuery(const std::vector<Vec3>& points, const std::vector<std::array<int, 3>>& triangles);
  ~SurfaceQuery();
  SurfaceQuery(SurfaceQuery&&) noexcept;
  SurfaceQuery& operator=(SurfaceQuery&&) noexcept;

  struct Nearest {
    int triangle = -1;
    Vec3 point = Vec3::Zero();
    Vec3 weights = Vec3::Zero();  // barycentric coordinates of `point` in the triangle
    double distance = 0;          // mm, not squared
  };
  /// Safe from several threads at once.
  Nearest nearest(const Vec3& x) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

/// Barycentric coordinates of the point of the plane of a, b, c nearest to x.
Vec3 barycentric(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace mv
