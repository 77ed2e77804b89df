// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Bijective map of a ring to the strip [0, period) x [0, 1]. Internal to mv_unfold.
//
// u and t minimise sum w_ij (f_i - f_j)^2 with w the cotangent weights (Pinkall & Polthier 1993), clamped to positive values: with both borders on
// straight lines such a map has no folds (Tutte 1963; for the strip see Gortler, Gotsman & Thurston 2006).

#include <Eigen/SparseCore>
#include <vector>

#include "geometry/unfold/ring.h"

namespace mv {

class StripMap {
 public:
  /// The ring's mesh must be refined (no inner edge joins two border points) and turned so that the annulus runs in the direction of growing u.
  StripMap(const Ring& ring, double period);

  /// u per point, given u on ring.annulus (increasing by one period over the loop) and on ring.free_edge, or, when that is empty,
  /// with the natural condition there (columns meet the free edge at right angles).
  std::vector<double> along(const std::vector<double>& u_annulus, const std::vector<double>& u_free_edge) const;
  /// 0 on the annulus, 1 on the free edge.
  std::vector<double> across() const;
  /// Triangles that (u, t) turns over.
  long folds(const std::vector<double>& u, const std::vector<double>& t) const;

 private:
  std::vector<double> solve(const std::vector<double>& fixed_value, const std::vector<char>& is_fixed, double period) const;
  void mark_cut();
  const Ring& ring_;
  double period_;
  std::vector<std::array<double, 3>> cotangent_;  // per triangle, of the angle at corner k; weight of the opposite edge
  std::vector<std::array<char, 3>> beyond_;       // per triangle and corner: the corner is seen one period further
};

/// Shortest way along edges (mm) from any point of `from`; `through_border` false: border points end a way.
std::vector<double> edge_distances(const RawMesh& mesh, const std::vector<int>& from);

}  // namespace mv
