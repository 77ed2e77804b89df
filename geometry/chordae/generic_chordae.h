// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Generic chordae (papers/s0 2.1: 14 primary ones on the border; secondary ones inside the leaflets), and the closed shape from
// which their rest lengths follow.
//
// Primary: one at each commissure and each notch between scallops (left open, a notch leaks), the others spread so that the
// longest stretch of border between neighbours is as short as possible, evenly within each arc between two junctions.
// Secondary: two struts in the belly of the anterior leaflet, the others shared evenly by the posterior scallops.
// Muscle: each papillary tip belongs to the commissure nearer to it; a chorda hangs on the nearest tip of its own half of the valve. A chorda within
// `midline_band` of the middle of a leaflet hangs on both sides by two segments of half the area.
//
// Rest length = max( slack |tip - X_c|, |tip - X_0| ), with slack junction_slack at commissures and notches: the distance to
// the end's place X_c in the closed shape, but never less than the initial one, so that no chorda is stretched at the start.
// Closed shape X_c(u, v): the meridian u leaves the annulus at A(u), runs straight to the top of the coaptation belt
// T(u) = C(u) + depth n and hangs straight along n (towards the ventricle) for what is left of v:
//   C(u) = A_ant(s) + f (A_post(s) - A_ant(s)),  f = h_ant / (h_ant + h_post)   (largest leaflet heights)
// where s in [0, 1] is the fraction of the way between the commissures, the same on both leaflets.

#include <optional>
#include <string>
#include <vector>

#include "geometry/chordae/insertion.h"
#include "geometry/chordae/leaflet_chart.h"
#include "geometry/core/case.h"

namespace mv {

struct ChordaeOptions {
  int primary = 14;  // 0, or at least one per commissure and notch
  int secondary = 8;
  double slack = 1.0;             // multiplies the distance to the closed place
  double junction_slack = 1.0;    // the same, on top of it, for the chordae at commissures and notches
  double coaptation_depth = 5.0;  // mm, top of the coaptation belt below the annulus
  double area_primary = 0.4;      // mm2
  double area_secondary = 0.8;    // mm2
  std::optional<double> radius;   // mm, influence radius R; default influence_radius()
  double end_inset = 0.2;         // a primary's end lies this share of R inside the border, so that nodes surround it
  double strut_height = 0.55;     // place of the anterior secondaries: share of the local height, measured from the annulus
  double strut_spread = 0.24;     // and distance from the leaflet's middle as a share of its width
  double posterior_height = 0.5;  // place of the posterior secondaries: share of the local height
  double midline_band = 0.02;     // half width, share of the way between the commissures
  bool bifurcated = false;        // primaries end in two branches with R/2 each
  double branch_at = 0.7;         // branch point: share of the way from the tip
  std::vector<int> removed;       // chordae to leave out, numbered as generated: primaries along the border, then secondaries
};

/// Where the closed valve holds a leaflet point; see above. All mm.
class ClosedShape {
 public:
  ClosedShape(const LeafletChart& chart, const Vec3& normal, double coaptation_depth);
  Vec3 at(const Vec2& uv) const;
  /// Fraction of the way between the commissures at which u lies, and its leaflet.
  double fraction(double u) const;
  bool is_anterior(double u) const;
  double commissure_u(int which) const { return which == 0 ? u_first_ : u_second_; }

 private:
  double u_at(bool on_anterior, double fraction) const;
  const LeafletChart* chart_;
  Vec3 normal_;
  double depth_, share_, u_first_, u_second_;
};

/// Builds the chordae. `annulus.normal` points to the ventricle; `papillary.tips` at least two. Throws ConfigError (counts,
/// `removed` out of range) and InputError (mesh, tips).
Chordae generic_chordae(const LeafletMesh& mesh, const Annulus& annulus, const Papillary& papillary,
                        const ChordaeOptions& options);

/// Longest stretch of the border (mm) between neighbouring chordae ends; an end counts at the border point nearest to it.
/// Ends of primary chordae count.
double largest_border_gap(const LeafletChart& chart, const Chordae& chordae);

}  // namespace mv
