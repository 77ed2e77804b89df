// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Drainage of the blood film between facing leaflets.
//
// Two surfaces that move with an interpolated velocity cannot touch: once their kernels overlap, the blood between them no longer moves
// relative to them and a film of one to two cells stays, under the ventricle's pressure, although a real film of that thickness would
// drain within microseconds. Here the film drains through the leaflets: within reach of the facing leaflet, both slip relative to the blood,
// towards each other, with
//     v = s(gap) h / T  min(p_film - p_atrium, p - p_contact) / p_scale ,   p = p_ventricle - p_atrium,
// p_film the blood's pressure halfway to the facing leaflet, p_contact what the penalty carries there, h the fluid spacing and T the
// drainage time. The slip ends when the film is at the atrium's pressure; then the leaflets touch and the contact carries p. Where the leaflets
// are near each other but open to the atrium, p_film = p_atrium and nothing slips. The volume that passes is the film's own, once.
// The slip is smoothed over the face, so that it does not shear elements where the facing leaflet ends.
// Forces stay those of the immersed boundary, so momentum is exact; the energy lost is the work of the nodal forces on the slip.

#include <span>
#include <vector>

#include "solver/fluid/grid.h"
#include "solver/time/structure.h"

namespace mv {

struct FilmDrainageOptions {
  double drainage_time = 2e-3;   // s, T: time in which a film as thick as a cell drains under p_scale
  double pressure_scale = 16e3;  // Pa, p_scale
  double reach_full = 1.5;       // cells: full slip up to this gap ...
  double reach_end = 2.5;        // ... and none beyond this one
  int smoothing_passes = 10;     // averages with the neighbours on the face
  double hinge_free = 2.0;       // cells from the annulus within which nothing slips: the hinge is held there, and no film needs to drain ...
  double hinge_full = 4.0;       // ... and from where on it slips fully
};

class FilmDrainage {
 public:
  /// Each node belongs to the atrial-face node nearest to it at rest, so that the leaflet slips as a whole through its thickness.
  FilmDrainage(const Structure& structure, const FluidGrid& grid, const FilmDrainageOptions& options);

  /// Gap (m) of each atrial-face node to the facing leaflet, infinity beyond reach; `gaps` has one entry per leaflet node and is part of the state.
  void find_gaps(std::span<const double> x, std::vector<double>& gaps);

  /// Moves the nodes by one step of slip and adds it to their velocities. `pressure`: padded cell field (Pa), atrium at zero; `forces`: what the
  /// nodes handed to the blood (N). Returns the energy lost (J).
  double slip(std::span<double> x, std::span<double> v, std::span<const double> gaps, const std::vector<double>& pressure, double pressure_difference,
              std::span<const double> forces, double dt);

 private:
  const Structure* structure_;
  FluidGrid grid_;
  FilmDrainageOptions options_;
  std::vector<int> surface_index_;   // per leaflet node: contact-surface index of its atrial-face node, -1 for fixed nodes
  std::vector<double> hinge_fade_;   // per contact-surface node
  std::vector<Eigen::Vector3d> normals_;
  std::vector<Eigen::Vector3d> slip_, smoothed_;  // m/s, per contact-surface node
  std::vector<int> neighbour_start_, neighbours_; // of each atrial-face node on its face
  ClosestGaps closest_;
};

/// Pressure (Pa) at a point (m, tube frame), trilinear in a padded cell field; constant beyond the last cell centres.
double pressure_at(const FluidGrid& grid, const std::vector<double>& pressure, const Eigen::Vector3d& x);

}  // namespace mv
