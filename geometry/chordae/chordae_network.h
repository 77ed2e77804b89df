// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Graph of straight segments. Internal to mv_chordae_geometry.

#include <functional>
#include <limits>
#include <vector>

#include "geometry/chordae/chordae_file.h"

namespace mv {

struct Network {
  struct Segment {
    int a = -1, b = -1;
    double area = 0;         // mm2 or NaN
    double rest_length = 0;  // mm or NaN
    double length = 0;       // mm, along what was segmented
    int kind = -1;
  };
  using Ask = std::function<bool(int point)>;

  explicit Network(const RawChordae& raw);

  std::vector<Vec3> points;
  std::vector<char> is_root, is_leaflet_end;
  std::vector<Segment> segments;

  std::vector<int> degrees() const;
  const std::vector<int>& segments_at(int point) const;  // indices into segments
  int other(int segment, int point) const;
  /// Connected part of every point, named by one of its points.
  std::vector<int> pieces() const;
  /// Connected part of every segment after cutting the network at every point that `cuts`.
  std::vector<int> pieces_of_segments(const Ask& cuts) const;
  /// A new segment over a gap.
  void join(int a, int b);
  /// Removes segments from a loose end up to the first point that `keeps` or where the network goes on in two directions.
  int prune(int loose_end, const Ask& keeps);
  int erase_segments(const std::function<bool(const Segment&)>& goes);
  /// Independent loops of the network after cutting it at every point that `cuts`.
  int loops(const Ask& cuts) const;
  /// Makes one segment of every run of `may_vanish` points with two segments each: lengths add up, and the area gives the same
  /// stiffness (sum of lengths over sum of length / area).
  void merge_runs(const Ask& may_vanish);

  struct Paths {
    std::vector<double> distance;           // per point, mm along the network to the nearest root; max() when there is none
    std::vector<int> segment_towards_root;  // -1 at roots
    std::vector<int> root_of;               // -1 when there is none
  };
  /// Shortest ways from all roots (Dijkstra) that do not pass through points that `blocks`.
  Paths paths_from(const Ask& is_root_point, const Ask& blocks) const;

 private:
  void index() const;
  mutable std::vector<std::vector<int>> at_;
  mutable bool is_indexed_ = false;
};

}  // namespace mv
