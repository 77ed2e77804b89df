// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The contact belt on the unfolded atrial faces (papers/s0, contact map). Lengths in mm, areas in mm2.

#include <array>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

struct BeltInput {
  std::vector<Vec2> unfolded;                 // (u, v) per point
  std::vector<Vec3> current;                  // deformed points; empty: current area is reported as the unfolded one
  std::vector<std::array<int, 3>> triangles;  // atrial faces; points not named by a triangle are ignored
  std::vector<int> region;                    // Region per triangle
  std::vector<char> in_contact;               // per point: gap below the threshold or pressure above zero
};

struct BeltOptions {
  double spacing_mm = 0;             // widest gap that does not interrupt; 0: mean edge length of the unfolded triangles
  double commissure_reach_mm = 2.0;  // the fold at a commissure cannot close; contact this near to the leaflet's end reaches it
};

struct BeltInterruption {
  int region = 0;
  double u_from = 0, u_to = 0;  // mm on the map, u_from <= u_to
  double v_from = 0, v_to = 0;  // v at u_from and u_to
  double width_mm = 0;          // gap without contact
};

struct LeafletBelt {
  int region = 0;
  double u_min = 0, u_max = 0;  // ends of the leaflet on the map: the two commissures
  bool continuous = false;
  double largest_gap_mm = 0;  // widest gap on the best way from commissure to commissure
  double contact_area_unfolded_mm2 = 0;
  double contact_area_mm2 = 0;  // current
  double width_mean_mm = 0;     // unfolded contact area / (u_max - u_min)
};

struct BeltResult {
  bool continuous = false;            // on each leaflet present
  double width_mean_mm = 0;           // all leaflets: sum of areas / sum of lengths
  double contact_area_mm2 = 0;        // current, both faces counted
  std::vector<LeafletBelt> leaflets;  // in order of region
  std::vector<BeltInterruption> interruptions;
};

/// Of all ways from one end of a leaflet to the other, the one whose widest jump over points without contact is least (a minimum
/// spanning tree over the contact patches). A patch is a set of contact points joined by mesh edges; a jump's width is the
/// distance between two points less one mean edge, because a point stands for half an edge around it. Jumps wider than the
/// spacing are the interruptions. A triangle counts as contact by the share of its points in contact. Throws InputError when
/// sizes do not match.
BeltResult measure_belt(const BeltInput& input, const BeltOptions& options = {});

}  // namespace mv
