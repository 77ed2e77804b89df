// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What closes the gap between a moving annulus and the wall of the tube. The wall is rigid; an annulus that contracts leaves it. The heart's own wall would follow, and
// no blood pass beside the leaflets; here points in rows from the annulus outwards, which are carried along with it, keep the blood between annulus and wall from
// moving along the tube otherwise than the annulus does.

#include <span>
#include <vector>

#include "solver/time/boundary_motion.h"
#include "solver/time/scene.h"

namespace mv {

class AnnulusSkirt {
 public:
  /// Rows as far as the largest gap at the times of the motion's rows, half a fluid cell apart. Throws InputError when a held node of the annulus lies further outside the wall at
  /// one of these times than at rest, by more than half a fluid cell, or too near to an end of the tube for what hangs on it; `file` is named.
  AnnulusSkirt(const Scene& scene, const AnnulusMotion& motion, const std::string& file);

  std::size_t points() const { return points_.size(); }
  /// Where they are at `time` (m, 3 per point) and whether they lie between annulus and wall.
  void place(double time, std::span<double> positions, std::span<char> is_inside) const;

 private:
  struct Point {
    MotionTable::Place root;
    Vec3 rest;         // m, tube frame, of the root
    Vec3 outwards;     // m, from the root
    double wall;       // m, distance of the wall from the axis in this direction
  };
  AnnulusMotion motion_;
  std::vector<Point> points_;
  double spacing_;     // m, of the fluid
};

/// Distance (m) of the tube's wall from its axis in the direction of p (m, tube frame).
double wall_distance(const Tube& tube, const Vec3& p);

}  // namespace mv
