// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// The thick leaflets seen from a point in space: nearest place of the mid-surface, how far border and annulus are from it, and
// whether a straight chorda passes through the tissue. Needs neither a flat pattern nor a ring: any number of leaflets.

#include <array>
#include <optional>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

class LeafletProbe {
 public:
  /// Throws InputError when a face, the border or the annulus is missing (point arrays side, free_edge, annulus).
  explicit LeafletProbe(const LeafletMesh& mesh);

  struct Place {
    Vec3 position = Vec3::Zero();  // mm, half way between the faces
    Vec3 normal = Vec3::UnitZ();   // unit, towards the atrial face
    double thickness = 0;          // mm
    double distance = 0;           // mm, of the asked point from `position`
    int region = 0;                // Region
    double to_border = 0;          // mm, straight, to the free border and to the annulus
    double to_annulus = 0;
    double height() const { return to_border + to_annulus; }
  };
  Place nearest(const Vec3& x) const;

  /// Where the segment from `a` to `b` (mm) first enters a leaflet that it leaves again more than `spared` mm before `b`, if it does. To enter
  /// the one it ends in is no crossing, however flat the way.
  std::optional<Vec3> crossing(const Vec3& a, const Vec3& b, double spared) const;

  double border_length() const { return border_length_; }  // mm, of the atrial face
  double mean_edge() const { return mean_edge_; }           // mm

 private:
  struct Face {
    std::vector<std::array<int, 3>> triangles;
    std::vector<int> regions;
  };
  struct Hit {
    Vec3 position;
    int region;
    double distance2;
  };
  Hit nearest_on(const Face& face, const Vec3& x) const;

  std::vector<Vec3> points_;
  Face atrial_, ventricular_;
  std::vector<Vec3> border_, annulus_;
  double border_length_ = 0, mean_edge_ = 0;
};

/// Influence sphere about `place`, made larger by a quarter at a time (at most `tries` times) while it does not reach both faces;
/// through the thickness the end stays at the centroid of the weights, along the leaflet it is `end` (default: `place`).
struct InfluenceSphere;
class LeafletGraph;
struct GrownSphere {
  double radius = 0;  // mm, used
  bool was_enlarged = false;
};
InfluenceSphere sphere_at(const LeafletGraph& graph, const Vec3& centre, const Vec3& end, const Vec3& normal, double radius, GrownSphere* grown = nullptr,
                          int tries = 6);

}  // namespace mv
