// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Leaflet curves as slices or files give them, before any surface exists. Lengths mm, frame RAS.

#include <string>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

/// Where a curve's last point lies.
enum class CurveEnd {
  free_edge,  // on the free edge
  annulus,    // on the annulus again: an arch that passes under a commissure
  joined      // where the other leaflet's curve goes on: one half of such an arch
};

struct LeafletCurve {
  std::string name;               // for messages: file and curve, or slice and leaflet
  int region = 0;                 // Region, 0 = not known
  int slice = -1;                 // index of the slice it was cut from, -1 = none
  std::vector<Vec3> points;       // from the annulus to the end
  std::vector<int> point_region;  // Region per point where the label changes along the curve; empty: `region` everywhere
  std::vector<double> thickness;  // per point, mm, as seen in the slice; empty: not known
  Vec3 plane_normal = Vec3::Zero();  // unit normal of the slice; zero: not known
  CurveEnd end = CurveEnd::free_edge;
  bool is_hinge_first = false;    // whether the source knows that the first point is the annulus
};

/// All that a source of curves finds.
struct CurveSet {
  std::vector<LeafletCurve> curves;
  std::vector<Vec3> annulus_points;         // further points on the annulus, without order (slices that only graze it)
  std::vector<Vec3> annulus_curve;          // closed and ordered, when the annulus itself was drawn; else empty
  std::vector<Vec3> papillary_points;
  std::vector<std::string> papillary_names; // per point, "" = not known
  std::vector<std::vector<Vec3>> papillary_clouds;  // voxels of a muscle, of which the tip is still to be found
  std::vector<std::string> papillary_cloud_names;
  double resolution = 0;                    // mm, of the data (pixel size); 0 = not known
  std::vector<Vec3> empty_slices;           // a point on each slice that holds no leaflet
  Vec3 stack_normal = Vec3::Zero();         // common normal of parallel slices; zero: not parallel, or no slices
  std::vector<std::string> notes;
};

}  // namespace mv
