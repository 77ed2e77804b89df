// SPDX-License-Identifier: BSD-3-Clause
#include "solver/time/annulus_skirt.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "geometry/core/errors.h"
#include "geometry/core/tube_ends.h"

namespace mv {
namespace {

constexpr double metres_per_mm = 1e-3;
constexpr double row_step = 0.5;       // fluid cells, between rows and along them
constexpr double outside_allowed = 0.5;  // fluid cells, beyond what lies outside at rest

Vec3 to_tube(const Tube& tube, const Vec3& p) { return metres_per_mm * (tube.axes * (p - tube.origin)); }

/// Points of the closed curve (m, tube frame), `step` apart or a little less.
std::vector<Vec3> resampled(const std::vector<Vec3>& curve, double step) {
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < curve.size(); ++i) {
    const Vec3 &a = curve[i], &b = curve[(i + 1) % curve.size()];
    const int count = std::max(1, static_cast<int>(std::ceil((b - a).norm() / step)));
    for (int k = 0; k < count; ++k) points.push_back(a + (b - a) * k / count);
  }
  return points;
}

void check_room(const Scene& scene, const AnnulusMotion& motion, const std::string& file) {
  const Tube& tube = scene.tube;
  const double cell = metres_per_mm * tube.grid_spacing, room = tube_end_cells_needed * cell;
  double lowest = 1e300, highest = -1e300;
  for (const Vec3& p : scene.mesh.points) {
    const double z = to_tube(tube, p).z();
    lowest = std::min(lowest, z), highest = std::max(highest, z);
  }
  for (const double time : motion.table().times())
    for (std::size_t n = 0; n < motion.nodes().size(); ++n) {
      const Vec3 rest = to_tube(tube, scene.mesh.points[static_cast<std::size_t>(motion.nodes()[n])]), moved = rest + motion.displacement(n, time);
      const double allowed = std::max(0.0, rest.head<2>().norm() - wall_distance(tube, rest)), outside = moved.head<2>().norm() - wall_distance(tube, moved) - allowed;
      if (outside > outside_allowed * cell)
        throw InputError(fmt::format("{}: at {:.4g} s the annulus lies {:.2f} mm outside the wall of the tube; make the case with annulus.motion set, so that the tube has room for it (mvprep tube), or "
                                     "raise tube.clearance",
                                     file, time, 1e3 * outside));
      const double shift = moved.z() - rest.z();
      const bool is_too_low = lowest + shift < metres_per_mm * tube.z_ventricle + room, is_too_high = highest + shift > metres_per_mm * tube.z_atrium - room;
      if (is_too_low || is_too_high)
        throw InputError(fmt::format("{}: at {:.4g} s the annulus has moved {:.2f} mm along the tube and the leaflets would leave it; raise tube.length_{}", file, time, 1e3 * shift,
                                     is_too_low ? "ventricle" : "atrium"));
    }
}

}  // namespace

double wall_distance(const Tube& tube, const Vec3& p) {
  const auto& section = tube.cross_section;
  const Vec2 direction = p.head<2>().normalized();
  const auto cross = [](const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); };
  double distance = 0;
  for (std::size_t i = 0; i < section.size(); ++i) {
    const Vec2 &a = section[i], &b = section[(i + 1) % section.size()];
    const double ca = cross(direction, a), cb = cross(direction, b);
    if ((ca > 0) == (cb > 0)) continue;
    distance = std::max(distance, direction.dot(a + (b - a) * (ca / (ca - cb))));
  }
  return metres_per_mm * distance;
}

AnnulusSkirt::AnnulusSkirt(const Scene& scene, const AnnulusMotion& motion, const std::string& file) : motion_(motion), spacing_(metres_per_mm * scene.tube.grid_spacing) {
  check_room(scene, motion, file);
  const Tube& tube = scene.tube;
  std::vector<Vec3> curve;
  for (const Vec3& p : scene.annulus.points) curve.push_back(to_tube(tube, p));
  for (const Vec3& root : resampled(curve, row_step * spacing_)) {
    const MotionTable::Place place = motion.table().nearest(tube.origin + tube.axes.transpose() * (root / metres_per_mm));
    const double wall = wall_distance(tube, root);
    double gap = 0;
    for (const double time : motion.table().times()) gap = std::max(gap, wall - (root + motion.displacement(place, time)).head<2>().norm());
    const Vec3 radial = Vec3(root.x(), root.y(), 0).normalized();
    for (int row = 1; row * row_step * spacing_ < gap + row_step * spacing_; ++row) points_.push_back({place, root, row * row_step * spacing_ * radial, wall});
  }
}

void AnnulusSkirt::place(double time, std::span<double> positions, std::span<char> is_inside) const {
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Point& p = points_[i];
    const Vec3 x = p.rest + motion_.displacement(p.root, time) + p.outwards;
    Vec3::Map(positions.data() + 3 * i) = x;
    is_inside[i] = x.head<2>().norm() < p.wall + row_step * spacing_;
  }
}

}  // namespace mv
