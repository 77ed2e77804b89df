// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Leaflet curves from segmented slices: from a thick, ragged, partly broken mask to one line from annulus to free edge. OpenCV stays
// inside the .cpp files.

#include "geometry/image/slice.h"
#include "geometry/loft/leaflet_curve.h"

namespace mv {

struct SliceCurveOptions {
  double bridge_gap = 2.5;   // mm, gaps in a leaflet up to this are closed
  double island_area = 2;    // mm2, what is left smaller than this is no leaflet
  double wall_reach = 1.5;   // pixels, leaflet pixels so close to a wall touch it
  double join_gap = 2.5;     // mm, leaflets whose ends point at each other across at most this are one sheet at the commissure
};

/// For each slice:
/// 1. groups of leaflet pixels, of either label; gaps up to bridge_gap are closed (never between two groups with a hinge each), islands left out, bubbles filled;
/// 2. hinge: middle of the contact with the atrium's wall, else the ventricle's; without walls the ends stay unordered (is_hinge_first = false);
/// 3. end: the point farthest from the hinge along the mask (geodesic);
/// 4. the cheapest path between them for a cost of 1/depth^2 (depth: distance from the mask's border), so that it follows the middle of the mask;
///    cut where it leaves the middle for a corner and drawn straight on to the mask's border;
/// 5. cubic smoothing spline, weight by the discrepancy principle with half a pixel; thickness = twice the depth, scaled so that thickness x length = area.
/// A curve belongs to the leaflet that most of its half at the hinge is labelled as; its points keep their own labels.
/// A group with two hinges and nothing beyond the line between them is an arch under a commissure when it lies in the outer slices (an unbroken row of such slices, up to
/// a third); elsewhere, or with something beyond, the leaflets coapt and are told apart by their labels. A group that touches the wall along most of itself only gives a
/// point on the annulus.
/// Slices are sorted along their normal when they are parallel; throws InputError when two of them lie in one place, when all are empty, or fewer than three show a leaflet.
CurveSet curves_of_slices(std::vector<Slice> slices, const SliceCurveOptions& options = {});

}  // namespace mv
