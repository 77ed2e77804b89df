// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// What the labels around the leaflets tell: annulus, commissures, papillary tips, the way to the ventricle (mm, RAS).

#include <optional>
#include <string>
#include <vector>

#include "geometry/core/case.h"
#include "geometry/image/label_map.h"

namespace mv {

struct LandmarkOptions {
  double contact = 1.5;          // voxel diagonals: leaflet voxels no further than this from a wall touch it
  double head_prominence = 3;    // mm by which a head of a papillary muscle rises over the saddle to a higher one
  double head_cap = 1;           // mm below its top that are averaged to the tip
};

struct LabelLandmarks {
  std::vector<Vec3> annulus_curve;           // closed, ordered; empty without atrium and ventricle labels, or where they hardly touch the leaflets
  std::vector<char> annulus_seen;            // per point of it: 0 where leaflet, atrium and ventricle do not meet and it is bridged
  std::vector<Vec3> commissures;             // two, or none
  std::vector<Vec3> papillary_points;        // tips of the heads, i.e. the ends towards the valve
  std::vector<std::string> papillary_names;  // per tip: "anterolateral", "posteromedial" or ""
  std::optional<Vec3> anterior_hint;         // centre of the aorta's voxels
  std::optional<Vec3> ventricle_direction;   // unit
  std::string direction_rule;
  double hinge_share = 0;                    // of the directions around the annulus in which leaflet, atrium and ventricle meet
  std::vector<std::string> notes;
};

/// - annulus: leaflet voxels that touch both the atrial and the ventricular wall, averaged in directions around their own plane (nearest to both
///   walls counts most); directions without such voxels, as at the curtain towards the aorta, are bridged.
/// - commissures: where the seams between the two leaflets' labels begin at the annulus (without one: at their atrial end).
/// - papillary tips: tops of each muscle in the direction of the valve; lower tops count as heads of their own when prominent.
/// - ventricle_direction: from the leaflets to the papillary muscles, else from the atrium to the ventricle, else by the one of them that is
///   there.
/// Throws InputError when the papillary muscles lie on the side of the atrium.
LabelLandmarks find_landmarks(const LabelledParts& parts, const LandmarkOptions& options, const std::string& name);

}  // namespace mv
