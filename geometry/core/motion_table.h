// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Positions of points over time from a CSV, as displacements from each point's first row. Between rows a cubic with slopes that never overshoot
// (Fritsch & Carlson 1980), at rest at the first and the last row; constant outside. Displacement and velocity are continuous.

#include <filesystem>
#include <string>
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
  const std::vector<double>& times() const { return times_; }  // s, of the rows

  /// Between point a and the next one, b, at `share` of the way.
  struct Place {
    int a = 0, b = 0;
    double share = 0;
  };
  /// The place nearest to x (mm) of the closed curve through the points at rest; `distance`: how far x lies from it, mm.
  Place nearest(const Vec3& x, double* distance = nullptr) const;
  /// The same for each held node of the mesh, in ascending order. Throws InputError, beginning with `name`, when one of them lies further from the curve than a leaflet's
  /// thickness explains (3 mm).
  std::vector<Place> places_of_annulus(const LeafletMesh& mesh, const std::string& name) const;
  /// Throws InputError, beginning with `name`, unless the file holds a point for each tip (mm), not far from it (10 mm).
  void check_tips(const std::vector<Vec3>& tips, const std::string& name) const;
  /// Throws InputError, beginning with `name`, when a point moves faster than 20 m/s between two rows (times in another unit), or has moved by more than 0.1 mm before the run
  /// starts at 0 s, where the valve is at rest.
  void check_course(const std::string& name) const;
  /// mm, linear between the two points.
  Vec3 displacement(const Place& place, double time) const;
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
