// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/unfold/surface_distance.h"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>

#include <cmath>

namespace mv {

std::vector<double> distances_to_surface(const std::vector<Vec3>& from, const std::vector<Vec3>& points,
                                         const std::vector<std::array<int, 3>>& triangles) {
  using Kernel = CGAL::Simple_cartesian<double>;
  using Shapes = std::vector<Kernel::Triangle_3>;
  using Traits = CGAL::AABB_traits<Kernel, CGAL::AABB_triangle_primitive<Kernel, Shapes::const_iterator>>;
  const auto point = [](const Vec3& x) { return Kernel::Point_3(x.x(), x.y(), x.z()); };
  Shapes shapes;
  for (const auto& t : triangles) {
    const Kernel::Triangle_3 shape(point(points[static_cast<std::size_t>(t[0])]), point(points[static_cast<std::size_t>(t[1])]),
                                   point(points[static_cast<std::size_t>(t[2])]));
    if (!shape.is_degenerate()) shapes.push_back(shape);
  }
  CGAL::AABB_tree<Traits> tree(shapes.cbegin(), shapes.cend());
  tree.accelerate_distance_queries();
  std::vector<double> distances;
  for (const Vec3& x : from) distances.push_back(std::sqrt(tree.squared_distance(point(x))));
  return distances;
}

}  // namespace mv
