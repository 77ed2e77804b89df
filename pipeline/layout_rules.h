// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// What to change in a chordae layout so that a hole of the closed valve shrinks. Pure functions of one run's result; the search that uses
// them is layout.h.
//
// Near a hole each leaflet's border lies at a depth below the annulus plane. The leaflet whose border lies more than `level_difference` higher
// prolapses there: its chordae are shortened, or it gets one more where the nearest is far; the lower one's are lengthened. At equal depths the
// borders are apart sideways: taut chordae hold them back and are lengthened; slack ones do not hold and are shortened, or the border
// gets another.

#include <optional>
#include <string>
#include <vector>

#include "geometry/chordae/leaflet_chart.h"
#include "geometry/core/case.h"

namespace mv {

struct LayoutHole {
  std::string location;
  Vec3 place = Vec3::Zero();  // mm
  double area = 0;            // mm2
};

/// End of one run.
struct LayoutObservation {
  std::vector<Vec3> points;     // leaflet points, deformed, mm
  std::vector<double> tension;  // N per segment
  std::vector<LayoutHole> holes;
  double area = 0;              // mm2, all holes
};

struct LayoutChange {
  enum Action { shorten, lengthen, add } action = shorten;
  int leaflet = 0;            // Region; 0: both
  std::vector<int> segments;  // whose rest lengths change
  double amount = 0;          // mm
  double arc = 0;             // border arc length (mm) of the place; add: of the new end
  std::string reason;

  /// Says which change it is, for the search's memory: action, leaflet and place along the border.
  std::string name() const;
};

struct LayoutRules {
  double level_difference = 2.0;  // mm
  double step_most = 2.0;         // mm, of one change of length
  double step_least = 0.5;
  double reach = 7.0;             // mm, chordae ends nearer to the hole than this (and the square root of its area) change
  double far = 4.0;               // mm along the border: no chorda nearer than this: add one first
  double taut = 0.01;             // N
};

/// Changes that may help at this hole, the likeliest first.
std::vector<LayoutChange> propose_changes(const LeafletMesh& mesh, const LeafletChart& chart, const Annulus& annulus, const Chordae& chordae, const LayoutObservation& seen,
                                          const LayoutHole& hole, const LayoutRules& rules = {});

/// Changes lengths (not `add`). No chorda starts stretched by more than 15 %. Returns false when nothing could change.
bool change_lengths(Chordae& chordae, const LayoutChange& change);

}  // namespace mv
