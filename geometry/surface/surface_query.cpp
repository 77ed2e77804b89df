// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/surface/surface_query.h"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>

#include <Eigen/Geometry>

#include "geometry/core/errors.h"

namespace mv {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Point = Kernel::Point_3;

using Triangle = Kernel::Triangle_3;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, std::vector<Triangle>::const_iterator>;
using Aabb = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

Point cgal_point(const Vec3& p) { return {p.x(), p.y(), p.z()}; }

}  // namespace

struct SurfaceQuery::Tree {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;
  std::vector<Triangle> shapes;  // the triangles with an area
  std::vector<int> index;        // of each shape
  Aabb aabb;
};

SurfaceQuery::SurfaceQuery(const std::vector<Vec3>& points, const std::vector<std::array<int, 3>>& triangles)
    : tree_(std::make_unique<Tree>()) {
  tree_->points = points;
  tree_->triangles = triangles;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Vec3 &a = points[static_cast<std::size_t>(triangles[t][0])], &b = points[static_cast<std::size_t>(triangles[t][1])],
               &c = points[static_cast<std::size_t>(triangles[t][2])];
    if (!((b - a).cross(c - a).norm() > 0)) continue;
    tree_->shapes.emplace_back(cgal_point(a), cgal_point(b), cgal_point(c));
    tree_->index.push_back(static_cast<int>(t));
  }
  if (tree_->shapes.empty()) throw InputError("surface: no triangle with an area");
  tree_->aabb.insert(tree_->shapes.cbegin(), tree_->shapes.cend());
  tree_->aabb.build();
  tree_->aabb.accelerate_distance_queries();
}

SurfaceQuery::~SurfaceQuery() = default;
SurfaceQuery::SurfaceQuery(SurfaceQuery&&) noexcept = default;
SurfaceQuery& SurfaceQuery::operator=(SurfaceQuery&&) noexcept = default;

SurfaceQuery::Nearest SurfaceQuery::nearest(const Vec3& x) const {
  const auto [point, id] = tree_->aabb.closest_point_and_primitive(cgal_point(x));
  Nearest out;
  out.triangle = tree_->index[static_cast<std::size_t>(id - tree_->shapes.cbegin())];
  out.point = Vec3(point.x(), point.y(), point.z());
  out.distance = (out.point - x).norm();
  const auto& t = tree_->triangles[static_cast<std::size_t>(out.triangle)];
  out.weights = barycentric(out.point, tree_->points[static_cast<std::size_t>(t[0])], tree_->points[static_cast<std::size_t>(t[1])],
                            tree_->points[static_cast<std::size_t>(t[2])]);
  return out;
}

Vec3 barycentric(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 n = (b - a).cross(c - a);
  const double n2 = n.squaredNorm();
  if (!(n2 > 0)) return {1, 0, 0};
  const double wb = (x - a).cross(c - a).dot(n) / n2, wc = (b - a).cross(x - a).dot(n) / n2;
  return {1 - wb - wc, wb, wc};
}

}  // namespace mv
