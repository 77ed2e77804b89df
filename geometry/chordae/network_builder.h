// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Collects segments of a chordae file into a RawChordae with welded points. Internal to mv_chordae_geometry.

#include <limits>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "geometry/chordae/chordae_file.h"

namespace mv {

class NetworkBuilder {
 public:
  /// Throws ConfigError for an unknown unit.
  NetworkBuilder(std::filesystem::path file, const ChordaeFileOptions& options);

  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

  struct Segment {
    double area = unknown;         // file units squared
    double rest_length = unknown;  // file units
    int kind = -1;
  };

  /// Index of the point at `x` (file units); the one already there when it is closer than the weld distance. Throws InputError naming
  /// `where` when not finite.
  int point(const Vec3& x, const std::string& where);
  void mark_root(int p) { raw_.is_root[static_cast<std::size_t>(p)] = 1; }
  void mark_leaflet_end(int p) { raw_.is_leaflet_end[static_cast<std::size_t>(p)] = 1; }
  /// `scale` (optional) replaces the unit for area and rest length: factors to mm2 and mm.
  void segment(int a, int b, const Segment& values, const std::string& where, double area_scale = 0, double length_scale = 0);
  double scale() const { return scale_; }
  const std::filesystem::path& file() const { return file_; }
  void note(const std::string& text) { raw_.notes.push_back(text); }

  /// Throws InputError when there is no segment.
  RawChordae take();

 private:
  std::filesystem::path file_;
  double scale_, weld_, flip_;
  RawChordae raw_;
  std::map<std::tuple<long, long, long>, std::vector<int>> cells_;
  std::map<std::pair<int, int>, int> seen_;
  int without_length_ = 0, repeated_ = 0;
};

/// pi r2; negative for a negative radius, so that segment() finds it.
double area_of_radius(double radius);

RawChordae read_chordae_vtk(const std::filesystem::path& file, const ChordaeFileOptions& options);   // .vtp and .vtk
/// Every line and polyline as its points, as they stand in the file.
std::vector<std::vector<Vec3>> read_polylines(const std::filesystem::path& file);
RawChordae read_chordae_swc(const std::filesystem::path& file, const ChordaeFileOptions& options);
RawChordae read_chordae_csv(const std::filesystem::path& file, const ChordaeFileOptions& options);

}  // namespace mv
