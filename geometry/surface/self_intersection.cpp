// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/surface/self_intersection.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>
#include <CGAL/intersections.h>

#include <algorithm>
#include <set>

#include "geometry/core/errors.h"

namespace mv {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Triangle = Kernel::Triangle_3;
using Segment = Kernel::Segment_3;
using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, int>;
using Corners = std::array<int, 3>;

class Surface {
 public:
  Surface(const std::vector<Vec3>& points, const std::vector<Corners>& triangles) : triangles_(triangles) {
    for (const Vec3& p : points) points_.emplace_back(p.x(), p.y(), p.z());
  }
  Triangle triangle(int t) const { return {point(t, 0), point(t, 1), point(t, 2)}; }
  bool is_degenerate(int t) const {
    const Corners& c = corners(t);
    return c[0] == c[1] || c[1] == c[2] || c[2] == c[0] || CGAL::collinear(point(t, 0), point(t, 1), point(t, 2));
  }

  /// More than the common vertex or edge. Neither triangle is degenerate.
  bool do_intersect(int s, int t) const {
    // Rotate both so that shared corners come first.
    std::vector<std::size_t> shared_s, shared_t;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j)
        if (corners(s)[i] == corners(t)[j]) {
          shared_s.push_back(i);
          shared_t.push_back(j);
        }
    if (shared_s.empty()) return CGAL::do_intersect(triangle(s), triangle(t));
    if (shared_s.size() == 1) {
      // Both lie in a plane through the common corner: anything else they share reaches the far edge of one of them.
      const Segment far_s(point(s, (shared_s[0] + 1) % 3), point(s, (shared_s[0] + 2) % 3));
      const Segment far_t(point(t, (shared_t[0] + 1) % 3), point(t, (shared_t[0] + 2) % 3));
      return CGAL::do_intersect(far_s, triangle(t)) || CGAL::do_intersect(far_t, triangle(s));
    }
    if (shared_s.size() == 2) {
      // Across a common edge they overlap only when they are coplanar and lie on the same side of it.
      const std::size_t apex_s = 3 - shared_s[0] - shared_s[1], apex_t = 3 - shared_t[0] - shared_t[1];
      const Point &a = point(s, shared_s[0]), &b = point(s, shared_s[1]), &c = point(s, apex_s), &d = point(t, apex_t);
      return CGAL::coplanar(a, b, c, d) && CGAL::coplanar_orientation(a, b, c, d) == CGAL::POSITIVE;
    }
    return true;  // the same triangle twice
  }

 private:
  const Corners& corners(int t) const { return triangles_[static_cast<std::size_t>(t)]; }
  const Point& point(int t, std::size_t corner) const { return points_[static_cast<std::size_t>(corners(t)[corner])]; }
  std::vector<Point> points_;
  const std::vector<Corners>& triangles_;
};

}  // namespace

std::vector<std::pair<int, int>> self_intersections(const std::vector<Vec3>& points,
                                                    const std::vector<std::array<int, 3>>& triangles) {
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!points[i].allFinite()) throw InputError("self-intersection: point " + std::to_string(i) + " is not finite");
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (int v : triangles[t])
      if (v < 0 || static_cast<std::size_t>(v) >= points.size())
        throw InputError("self-intersection: triangle " + std::to_string(t) + " refers to point " + std::to_string(v) + " of " +
                         std::to_string(points.size()));
  const Surface surface(points, triangles);
  std::vector<std::pair<int, int>> pairs;
  std::vector<Box> boxes;
  for (int t = 0; t < static_cast<int>(triangles.size()); ++t) {
    if (surface.is_degenerate(t))
      pairs.emplace_back(t, t);
    else
      boxes.emplace_back(surface.triangle(t).bbox(), t);
  }
  CGAL::box_self_intersection_d(boxes.begin(), boxes.end(), [&](const Box& a, const Box& b) {
    const int s = std::min(a.info(), b.info()), t = std::max(a.info(), b.info());
    if (surface.do_intersect(s, t)) pairs.emplace_back(s, t);
  });
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

Gate gate_self_intersection(const LeafletMesh& mesh, const std::vector<Vec3>& positions, const char* name) {
  if (positions.size() != mesh.points.size())
    throw InputError("self-intersection: " + std::to_string(positions.size()) + " positions for " +
                     std::to_string(mesh.points.size()) + " points");
  const BoundarySurface boundary = extract_boundary(mesh);
  const auto facets = boundary_facets(boundary);
  const auto pairs = self_intersections(positions, facets);
  const int per_face = boundary.quadratic.empty() ? 1 : 4;
  Gate gate{name, pairs.empty(), static_cast<double>(pairs.size()), 0, "==", "pairs", -1, ""};
  if (pairs.empty()) {
    gate.message = "no two of " + std::to_string(facets.size()) + " boundary triangles intersect (exact predicates)";
    return gate;
  }
  auto element = [&](int facet) { return boundary.element[static_cast<std::size_t>(facet / per_face)]; };
  gate.worst_element = element(pairs.front().first);
  gate.message = std::to_string(pairs.size()) + " pairs of boundary triangles intersect, first those of elements " +
                 std::to_string(element(pairs.front().first)) + " and " + std::to_string(element(pairs.front().second));
  return gate;
}

Gate gate_self_intersection(const LeafletMesh& mesh) {
  return gate_self_intersection(mesh, mesh.points, "leaflets.self_intersections");
}

}  // namespace mv
