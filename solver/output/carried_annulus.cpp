// SPDX-License-Identifier: BSD-3-Clause
#include "solver/output/carried_annulus.h"

#include <Eigen/Geometry>
#include <vector>

namespace mv {
namespace {

constexpr double at_rest = 1e-9;  // mm: rounding of the solver's frame

Vec3 area_vector(const std::vector<Vec3>& curve) {
  Vec3 area = Vec3::Zero();
  for (std::size_t i = 0; i < curve.size(); ++i) area += 0.5 * (curve[i] - curve[0]).cross(curve[(i + 1) % curve.size()] - curve[0]);
  return area;
}

}  // namespace

Annulus carried_annulus(const Annulus& rest, const LeafletMesh& mesh, std::span<const Vec3> points) {
  std::vector<std::size_t> held;
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    if (mesh.on_annulus[i] && (points[i] - mesh.points[i]).norm() > at_rest) held.push_back(i);
  if (held.empty()) return rest;
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    if (mesh.on_annulus[i] && (points[i] - mesh.points[i]).norm() <= at_rest) held.push_back(i);
  Annulus now = rest;
  for (Vec3& p : now.points) {
    std::size_t nearest = 0;
    double least = 1e300;
    for (const std::size_t i : held)
      if (const double d = (mesh.points[i] - p).squaredNorm(); d < least) least = d, nearest = i;
    const Vec3 moved = points[nearest] - mesh.points[nearest];
    p += moved;
    now.origin += moved / static_cast<double>(now.points.size());
  }
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(area_vector(rest.points), area_vector(now.points));
  now.normal = turn * rest.normal;
  now.axis_major = turn * rest.axis_major;
  return now;
}

}  // namespace mv
