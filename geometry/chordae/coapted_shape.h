// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Where a patient's closed valve holds its leaflets: ClosedShape (generic_chordae.h) for patterns that keep neither lengths nor a
// plane annulus.
//
// s in [0, 1] is the fraction of the way between the commissures, the same on both leaflets. A meridian leaves the annulus at A(s), runs
// straight to the top of the coaptation belt T(s) and hangs straight along the annulus normal n for what is left of its length, which is
// measured on the surface:
//   C(s) = A_ant + f (A_post - A_ant),  f = L_ant / (L_ant + L_post)   (longest meridians)
//   T(s) = C(s) + (d(s) + max(0, height of C above the annulus plane)) n
// so that the belt lies below the annulus plane everywhere. d(s) is the asked depth, or less where the leaflets are too short to
// overlap there by `belt_wanted`; never less than `depth_least`.

#include <vector>

#include "geometry/chordae/leaflet_chart.h"
#include "geometry/core/case.h"

namespace mv {

class CoaptedShape {
 public:
  static constexpr double belt_wanted = 2.0;  // mm
  static constexpr double depth_least = 1.0;  // mm

  /// `chart` must outlive this.
  CoaptedShape(const LeafletChart& chart, const Annulus& annulus, double coaptation_depth);

  Vec3 at(const Vec2& uv) const;
  double fraction(double u) const;
  bool is_anterior(double u) const;
  double u_at(bool on_anterior, double fraction) const;
  double commissure_u(int which) const { return which == 0 ? u_first_ : u_second_; }

  /// Length (mm) of the meridian u from the annulus to v, measured on the mid-surface.
  double along(const Vec2& uv) const;

  struct Meridian {
    double fraction = 0;
    double depth = 0;           // mm, used
    double belt_anterior = 0;   // mm left below the top of the belt; negative: the leaflet does not reach it
    double belt_posterior = 0;
  };
  const std::vector<Meridian>& meridians() const { return meridians_; }

 private:
  Vec3 top_at(double s) const;
  const LeafletChart* chart_;
  Vec3 normal_;
  double u_first_ = 0, u_second_ = 0;
  std::vector<Meridian> meridians_;
  std::vector<Vec3> tops_;
};

}  // namespace mv
