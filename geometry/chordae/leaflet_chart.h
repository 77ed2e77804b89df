// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// The leaflets seen through their flat pattern: from (u, v) to the mid-surface in space, and the free border as an ordered closed
// curve with its commissures and notches.

#include <array>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

class LeafletChart {
 public:
  struct SurfacePoint {
    Vec3 position;  // mm, half way between the two faces
    Vec3 normal;    // unit, towards the atrial face
    int region;     // Region
  };
  struct BorderPoint {
    Vec2 uv;        // u increases along the border and is not wrapped
    Vec3 position;  // mm, half way between the two faces
    double arc;     // mm, length of the border in space from its first point
    int region;     // Region of the border after this point
  };
  struct Junction {
    int border_index;    // index into border()
    bool is_commissure;  // the leaflets change here; otherwise a notch between two scallops of one leaflet
  };

  /// Needs a closed ring with one free border and both regions. Throws InputError saying what is missing.
  explicit LeafletChart(const LeafletMesh& mesh);

  /// Point of the mid-surface at (u, v); outside the pattern, the nearest point of it.
  SurfacePoint at(const Vec2& uv) const;

  /// Starts at a commissure behind which the anterior leaflet follows; the last point is not repeated.
  const std::vector<BorderPoint>& border() const { return border_; }
  double border_length() const { return border_length_; }
  double period() const { return period_; }

  /// (u, v) of the border at an arc length, which is wrapped; u lies within a period of the first border point's.
  Vec2 border_uv(double arc) const;

  /// Largest v of the border at u, mm.
  double height(double u) const;

  /// Commissures and notches in the order of the border; the first is border point 0. A notch is a local minimum of v that lies
  /// at least 10 % of the leaflet's height below the borders on its two sides.
  const std::vector<Junction>& junctions() const { return junctions_; }

 private:
  struct Face {
    std::vector<std::array<int, 3>> triangles;
    std::vector<int> regions;
    std::vector<std::vector<int>> bins;  // triangles that reach into each strip of u, ascending
  };
  struct Hit {
    Vec3 position;
    int region;
  };
  void sort_into_bins(Face& face) const;
  static Face side_face(const LeafletMesh& mesh, int side);
  void build_border(const LeafletMesh& mesh);
  void find_junctions();
  Hit locate(const Face& face, const Vec2& uv) const;

  std::vector<Vec3> points_;
  std::vector<Vec2> unfolded_;
  double period_ = 0;
  Face atrial_, ventricular_;
  std::vector<BorderPoint> border_;  // the first is a commissure
  double border_length_ = 0;
  std::vector<Junction> junctions_;
};

}  // namespace mv
