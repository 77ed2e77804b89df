// SPDX-License-Identifier: BSD-3-Clause
#include "solver/contact/intersection.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "geometry/core/errors.h"
#include "geometry/core/parallel.h"
#include "solver/contact/box_grid.h"
#include "solver/contact/exact_predicates.h"

namespace mv {
namespace {

using Vec3 = Eigen::Vector3d;
using Corners = std::array<Vec3, 3>;

/// A coordinate axis along which the projection of the triangle keeps an area, or -1 when its corners are collinear.
int projection_axis(const Vec3& a, const Vec3& b, const Vec3& c) {
  // The largest component of the normal first: it decides without exact arithmetic, except for degenerate triangles.
  const Vec3 n = (b - a).cross(c - a).cwiseAbs();
  int first = 0;
  n.maxCoeff(&first);
  for (int k = 0; k < 3; ++k) {
    const int axis = (first + k) % 3;
    if (orientation_2d(a, b, c, axis) != 0) return axis;
  }
  return -1;
}

/// Point p inside or on the triangle, all coplanar, in the projection along `axis`.
bool coplanar_point_in_triangle(const Vec3& p, const Corners& t, int axis) {
  const int s0 = orientation_2d(t[0], t[1], p, axis);
  const int s1 = orientation_2d(t[1], t[2], p, axis);
  const int s2 = orientation_2d(t[2], t[0], p, axis);
  return (s0 >= 0 && s1 >= 0 && s2 >= 0) || (s0 <= 0 && s1 <= 0 && s2 <= 0);
}

bool within_box_2d(const Vec3& a, const Vec3& b, const Vec3& p, int axis) {
  for (int k = 0; k < 3; ++k) {
    if (k == axis) continue;
    if (p[k] < std::min(a[k], b[k]) || p[k] > std::max(a[k], b[k])) return false;
  }
  return true;
}

/// Closed segments pq and ab in the projection along `axis`.
bool coplanar_segments_intersect(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, int axis) {
  const int pa = orientation_2d(p, q, a, axis), pb = orientation_2d(p, q, b, axis);
  const int ap = orientation_2d(a, b, p, axis), aq = orientation_2d(a, b, q, axis);
  if (pa * pb < 0 && ap * aq < 0) return true;
  return (pa == 0 && within_box_2d(p, q, a, axis)) || (pb == 0 && within_box_2d(p, q, b, axis)) ||
         (ap == 0 && within_box_2d(a, b, p, axis)) || (aq == 0 && within_box_2d(a, b, q, axis));
}

/// Closed segment pq against the closed, non-degenerate triangle t.
bool segment_intersects_triangle(const Vec3& p, const Vec3& q, const Corners& t) {
  const int sp = orientation_3d(t[0], t[1], t[2], p);
  const int sq = orientation_3d(t[0], t[1], t[2], q);
  if (sp * sq > 0) return false;
  if (sp == 0 && sq == 0) {
    const int axis = projection_axis(t[0], t[1], t[2]);
    if (coplanar_point_in_triangle(p, t, axis)) return true;
    for (int e = 0; e < 3; ++e) {
      if (coplanar_segments_intersect(p, q, t[e], t[(e + 1) % 3], axis)) return true;
    }
    return false;
  }
  const int s0 = orientation_3d(p, q, t[0], t[1]);
  const int s1 = orientation_3d(p, q, t[1], t[2]);
  if (s0 * s1 < 0) return false;
  const int s2 = orientation_3d(p, q, t[2], t[0]);
  return (s0 >= 0 && s1 >= 0 && s2 >= 0) || (s0 <= 0 && s1 <= 0 && s2 <= 0);
}

/// All corners of b strictly on one side of the plane of a.
bool plane_separates(const Corners& a, const Corners& b) {
  const int s0 = orientation_3d(a[0], a[1], a[2], b[0]);
  if (s0 == 0) return false;
  return s0 == orientation_3d(a[0], a[1], a[2], b[1]) && s0 == orientation_3d(a[0], a[1], a[2], b[2]);
}

Corners corners_of(std::span<const Vec3> points, const std::array<int, 3>& t) {
  return {points[t[0]], points[t[1]], points[t[2]]};
}

/// Triangles of a mesh, common vertices excepted as the header says.
bool mesh_triangles_intersect(std::span<const Vec3> points, const std::array<int, 3>& ta, const std::array<int, 3>& tb) {
  std::array<int, 3> common_a{}, common_b{};
  int common = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (ta[i] != tb[j]) continue;
      common_a[common] = i;
      common_b[common] = j;
      ++common;
    }
  }
  const Corners a = corners_of(points, ta), b = corners_of(points, tb);
  if (common == 0) return triangles_intersect(a, b);
  if (common == 1) {
    const int i = common_a[0], j = common_b[0];
    return segment_intersects_triangle(b[(j + 1) % 3], b[(j + 2) % 3], a) ||
           segment_intersects_triangle(a[(i + 1) % 3], a[(i + 2) % 3], b);
  }
  if (common == 2) {
    const Vec3& apex_a = a[3 - common_a[0] - common_a[1]];
    const Vec3& apex_b = b[3 - common_b[0] - common_b[1]];
    const Vec3& p = a[common_a[0]];
    const Vec3& q = a[common_a[1]];
    if (orientation_3d(p, q, apex_a, apex_b) != 0) return false;
    const int axis = projection_axis(p, q, apex_a);
    return orientation_2d(p, q, apex_a, axis) == orientation_2d(p, q, apex_b, axis);
  }
  return true;
}

}  // namespace

bool triangles_intersect(const Corners& a, const Corners& b) {
  if (plane_separates(a, b) || plane_separates(b, a)) return false;
  for (int e = 0; e < 3; ++e) {
    if (segment_intersects_triangle(a[e], a[(e + 1) % 3], b) || segment_intersects_triangle(b[e], b[(e + 1) % 3], a)) return true;
  }
  return false;
}

std::vector<std::pair<int, int>> self_intersections(std::span<const Vec3> points, std::span<const std::array<int, 3>> triangles) {
  std::vector<std::pair<int, int>> result;
  const int count = static_cast<int>(triangles.size());
  if (count == 0) return result;
  std::vector<Vec3> low(triangles.size()), high(triangles.size());
  std::vector<char> degenerate(triangles.size()), finite(triangles.size());
  parallel_for(count, [&](std::ptrdiff_t f) {
    const Corners t = corners_of(points, triangles[f]);
    low[f] = t[0].cwiseMin(t[1]).cwiseMin(t[2]);
    high[f] = t[0].cwiseMax(t[1]).cwiseMax(t[2]);
    finite[f] = t[0].allFinite() && t[1].allFinite() && t[2].allFinite();
    degenerate[f] = finite[f] && projection_axis(t[0], t[1], t[2]) < 0;
  });
  Vec3 lower = low[0], upper = high[0];
  double extent_mean = 0;
  for (int f = 0; f < count; ++f) {
    if (!finite[f])
      throw InputError("self_intersections: triangle " + std::to_string(f) + " has coordinates that are not finite");
    lower = lower.cwiseMin(low[f]);
    upper = upper.cwiseMax(high[f]);
    extent_mean += (high[f] - low[f]).maxCoeff() / count;
    if (degenerate[f]) result.emplace_back(f, f);
  }
  // Triangles by the cell of their box's lower corner. Another box that overlaps [low, high] has its lower corner in
  // [low - largest extent, high]; very large triangles would make that window useless, so they are compared with all others.
  const double extent_limit = 4 * extent_mean;
  std::vector<int> regular, large;
  double extent_max = 0;
  for (int f = 0; f < count; ++f) {
    if (degenerate[f]) continue;
    const double extent = (high[f] - low[f]).maxCoeff();
    (extent > extent_limit ? large : regular).push_back(f);
    if (extent <= extent_limit) extent_max = std::max(extent_max, extent);
  }
  const auto boxes_overlap = [&](int f, int g) {
    return (low[f].array() <= high[g].array()).all() && (low[g].array() <= high[f].array()).all();
  };
  BoxGrid grid;
  grid.reset(lower, upper, std::max(extent_mean, 1e-12 * std::max(1e-300, (upper - lower).maxCoeff())));
  grid.sort(static_cast<int>(regular.size()), [&](int r) { return grid.cell_index(grid.cell(low[regular[r]])); });

  std::vector<std::vector<std::pair<int, int>>> found(static_cast<std::size_t>(thread_count()));
  parallel_ranges(static_cast<std::ptrdiff_t>(regular.size()), [&](std::ptrdiff_t begin, std::ptrdiff_t end, int thread) {
    for (std::ptrdiff_t r = begin; r < end; ++r) {
      const int f = regular[r];
      // A margin of one part in 1e9 covers the rounding of the window's corner.
      const Vec3 window = low[f] - Vec3::Constant(extent_max * (1 + 1e-9));
      grid.for_runs(grid.cell(window), grid.cell(high[f]), [&](int first, int last) {
        for (int s = first; s < last; ++s) {
          const int g = regular[grid.item(s)];
          if (g > f && boxes_overlap(f, g) && mesh_triangles_intersect(points, triangles[f], triangles[g]))
            found[thread].emplace_back(f, g);
        }
      });
    }
  });
  for (const auto& part : found) result.insert(result.end(), part.begin(), part.end());
  for (std::size_t i = 0; i < large.size(); ++i) {
    const int f = large[i];
    const auto test = [&](int g) {
      if (boxes_overlap(f, g) && mesh_triangles_intersect(points, triangles[f], triangles[g]))
        result.emplace_back(std::minmax(f, g));
    };
    for (int g : regular) test(g);
    for (std::size_t j = i + 1; j < large.size(); ++j) test(large[j]);
  }
  std::sort(result.begin(), result.end());
  return result;
}

std::vector<std::pair<int, int>> self_intersections(const ContactSurface& surface, std::span<const double> x) {
  std::vector<Vec3> points(surface.nodes.size());
  for (std::size_t s = 0; s < points.size(); ++s)
    points[s] = Eigen::Map<const Vec3>(x.data() + 3 * static_cast<std::size_t>(surface.nodes[s]));
  return self_intersections(points, surface.triangles);
}

}  // namespace mv
