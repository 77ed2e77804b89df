// SPDX-License-Identifier: BSD-3-Clause
#include "solver/time/annulus_barrier.h"

#include <algorithm>
#include <map>
#include <utility>

namespace mv {
namespace {

constexpr double metres_per_mm = 1e-3;

/// Faces of the tetrahedra that belong to one element only and are held at every corner.
std::vector<std::array<int, 3>> held_faces(const LeafletMesh& mesh) {
  constexpr std::array<std::array<std::size_t, 3>, 4> corners{{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
  std::map<std::array<int, 3>, std::pair<int, std::array<int, 3>>> count;
  for (const auto& tet : mesh.tets)
    for (const auto& c : corners) {
      const std::array<int, 3> face{tet[c[0]], tet[c[1]], tet[c[2]]};
      if (!std::all_of(face.begin(), face.end(), [&](int i) { return mesh.on_annulus[static_cast<std::size_t>(i)] != 0; })) continue;
      std::array<int, 3> key = face;
      std::sort(key.begin(), key.end());
      auto& entry = count[key];
      ++entry.first;
      entry.second = face;
    }
  std::vector<std::array<int, 3>> faces;
  for (const auto& [key, entry] : count)
    if (entry.first == 1) faces.push_back(entry.second);
  return faces;
}

}  // namespace

std::vector<RestTriangle> annulus_barrier(const Scene& scene) {
  const Tube& tube = scene.tube;
  const auto to_tube = [&](const Vec3& p) { return Vec3(metres_per_mm * (tube.axes * (p - tube.origin))); };
  double reach = 0;  // m, beyond every point of the wall
  for (const Vec2& p : tube.cross_section) reach = std::max(reach, metres_per_mm * p.norm());
  reach += 2 * metres_per_mm * tube.grid_spacing;
  const auto outside = [&](const Vec3& p) {
    const double radius = p.head<2>().norm();
    return Vec3(p.x() * reach / radius, p.y() * reach / radius, p.z());
  };
  std::vector<RestTriangle> triangles;
  const auto add_skirt = [&](const Vec3& a, const Vec3& b) {
    const Vec3 far_a = outside(a), far_b = outside(b);
    triangles.push_back({a, b, far_b});
    triangles.push_back({a, far_b, far_a});
  };

  const std::vector<std::array<int, 3>> faces = held_faces(scene.mesh);
  std::vector<Vec3> points;
  for (const Vec3& p : scene.mesh.points) points.push_back(to_tube(p));
  std::map<std::pair<int, int>, std::vector<int>> opposite;  // of an edge: the third corners of its faces
  for (const auto& f : faces) {
    const auto at = [&](std::size_t i) { return points[static_cast<std::size_t>(f[i])]; };
    triangles.push_back({at(0), at(1), at(2)});
    for (std::size_t i = 0; i < 3; ++i) opposite[std::minmax(f[(i + 1) % 3], f[(i + 2) % 3])].push_back(f[i]);
  }
  for (const auto& [edge, third] : opposite) {
    if (third.size() != 1) continue;
    const Vec3 &a = points[static_cast<std::size_t>(edge.first)], &b = points[static_cast<std::size_t>(edge.second)];
    const Vec3 middle = 0.5 * (a + b);
    const bool is_outer = (middle - points[static_cast<std::size_t>(third[0])]).head<2>().dot(middle.head<2>()) > 0;
    if (is_outer) add_skirt(a, b);
  }
  if (faces.empty())
    for (std::size_t i = 0; i < scene.annulus.points.size(); ++i)
      add_skirt(to_tube(scene.annulus.points[i]), to_tube(scene.annulus.points[(i + 1) % scene.annulus.points.size()]));
  return triangles;
}

}  // namespace mv
