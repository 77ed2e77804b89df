// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Positions of points over time from a CSV, as displacements from each point's first row. Between rows a cubic with slopes that never overshoot
// (Fritsch & Carlson 1980), at rest at the first and the last row; constant outside. Displacement and velocity are continuous.

#include <filesystem>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

class MotionTable {
 public:
  /// Columns point,time_s,x_mm,y_mm,z_mm in any order; points numbered 0, 1, 2 ...; the rows of one point in the order of time, those of different points
  /// in any order. All points need the same times, the first not after 0 s, and two rows or more. Throws IoError, InputError (file, line, column).
  static MotionTable read(const std::filesystem::path& file);

  /// Displacements per point and time, mm.
  MotionTable(std::vector<double> times, std::vector<Vec3> rest, std::vector<std::vector<Vec3>> displacements);

  int points() const { return static_cast<int>(rest_.size()); }
  const std::vector<Vec3>& rest() const { return rest_; }  // mm, world frame
  Vec3 displacement(int point, double time) const;         // mm
  double largest() const;                                  // mm, over all points and times
  bool changes(double t0, double t1) const { return t1 > times_.front() && t0 < times_.back(); }

 private:
  std::vector<double> times_;
  std::vector<Vec3> rest_;
  std::vector<std::vector<Vec3>> displacements_, slopes_;  // per point
};

/// Writes such a file. Throws IoError.
void write_motion(const std::filesystem::path& file, const std::vector<double>& times, const std::vector<Vec3>& rest,
                  const std::vector<std::vector<Vec3>>& displacements);

}  // namespace mv
