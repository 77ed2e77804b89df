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
    int border_index;     // index into border()
    bool is_commissure;   // the leaflets change here; otherwise a notch between two scallops of one leaflet
  };

  /// Needs a closed ring with one free border and both regions. Throws InputError saying what is missing.
  explicit LeafletChart(const LeafletMesh& mesh);

  /// Point of the mid-surface at (u, v); outside the pattern, the nearest point of it.
  SurfacePoint at(const Vec2& uv) const;

  const std::vector<BorderPoint>& border() const { return border_; }
  double border_length() const { return border_length_; }
  double period() const { return period_; }

  /// (u, v) of the border at an arc length (wrapped) and the other way round for a border vertex.
  Vec2 border_uv(double arc) const;

  /// Largest v of the border at u, mm.
  double height(double u) const;

  /// Commissures and notches in the order of the border; the first is a commissure behind which the anterior leaflet follows.
  const std::vector<Junction>& junctions() const { return junctions_; }

 private:
  struct FaceMap {
    std::vector<std::array<int, 3>> triangles;
    std::vector<int> regions;
    std::vector<std::vector<int>> buckets;
  };
  struct Hit {
    Vec3 position;
    Vec3 normal;
    int region;
    double distance;
  };
  void build_faces(const LeafletMesh& mesh);
  void build_border(const LeafletMesh& mesh);
  void find_junctions();
  Hit locate(const FaceMap& face, const Vec2& uv) const;
  double unwrap(double u, double near_u) const;

  std::vector<Vec3> points_;
  std::vector<Vec2> unfolded_;
  double period_ = 0, u_min_ = 0, v_min_ = 0, cell_ = 1;
  int columns_ = 0, rows_ = 0;
  FaceMap atrial_, ventricular_;
  std::vector<BorderPoint> border_;
  double border_length_ = 0;
  std::vector<Junction> junctions_;
};

}  // namespace mv
