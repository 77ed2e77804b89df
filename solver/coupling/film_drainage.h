// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Drainage of the blood film between facing leaflets.
//
// Two surfaces that move with an interpolated velocity cannot touch: once their kernels overlap, the blood between them no longer moves
// relative to them and a film of one to two cells stays, under the ventricle's pressure, although a real film of that thickness would
// drain within microseconds. The blood on the grid cannot push such leaflets together either, because there the film has the pressure that in truth
// it has lost. Both are made good here, for nodes within reach of the facing leaflet:
// - slip(): the leaflet slips through the blood, along its normal n towards the film, by what its forces F (N; tissue, chordae and contact, summed over a column
//   through the leaflet) leave unbalanced of the pressure p_out, the larger of those behind the leaflet and halfway to the facing one, the film's own being the atrium's, zero:
//     v = s(gap) h / (T p_scale) (p_out + F . n / A) ,
//   h the fluid spacing, T the drainage time, A the area. It ends in equilibrium, whatever T: flat sheets come to rest when contact carries the
//   pressure, a fold when its bending does; a leaflet that carries the pressure by its tension, as beside the belt, does not slip at all.
// - press(): what of that pressure the leaflet's own forces do not carry, p_out + (F - F_contact) . n / A, is what presses the leaflet towards the film. It acts on the face
//   that contact presses, along +n, as a force that the blood does not feel, so that Coupling::relax() finds contact and film in balance instead of squeezing the leaflet.
// Within a thickness of the free border nothing is pressed together, only apart: there the film opens into the ventricle and has its pressure.
// The slip is smoothed over the face, so that it does not shear elements where the facing leaflet ends.
// Forces on the blood stay those of the immersed boundary, so momentum is exact; the energy lost is the work of the nodal forces on the slip.

#include <span>
#include <vector>

#include "solver/contact/self_contact.h"
#include "solver/fluid/grid.h"

namespace mv {

struct FilmDrainageOptions {
  double drainage_time = 5e-3;   // s, T: time in which a film as thick as a cell drains under p_scale
  double pressure_scale = 16e3;  // Pa, p_scale
  double reach_full = 1.5;       // cells: full slip up to this gap ...
  double reach_end = 2.5;        // ... and none beyond this one
  int smoothing_passes = 10;     // averages with the neighbours on the face
  double hinge_free = 2.0;       // cells from the annulus within which nothing slips: the hinge is held there, and no film needs to drain ...
  double hinge_full = 4.0;       // ... and from where on it slips fully
};

class FilmDrainage {
 public:
  /// Each node belongs to the column of the atrial-face node nearest to it at rest, so that the leaflet slips as a whole through its thickness.
  /// `surface` and `contact` are kept by reference and must outlive this object; `rest_positions`: 3 per leaflet node (m, tube frame); `is_fixed`: per
  /// leaflet node (entries beyond the leaflet are ignored).
  FilmDrainage(const ContactSurface& surface, const SelfContact& contact, std::span<const double> rest_positions, std::span<const char> is_fixed,
               const FluidGrid& grid, const FilmDrainageOptions& options);

  /// Gap (m) of each atrial-face node to the facing leaflet, infinity beyond reach; `gaps` has one entry per leaflet node and is part of the state.
  void find_gaps(std::span<const double> x, std::vector<double>& gaps);

  /// Finds what is unbalanced and adds the film's pressure to `unseen` (N, 3 per node). `pressure`: padded cell field (Pa), atrium at zero;
  /// `pressure_difference` (Pa), ventricle less atrium, bounds p_out and the film's pressure; `forces` (N): of tissue, chordae and contact, as handed to the blood.
  void press(std::span<const double> x, std::span<const double> gaps, const std::vector<double>& pressure, double pressure_difference,
             std::span<const double> forces, std::span<double> unseen);

  /// Moves the nodes by one step of slip, after press() at the same positions.
  void slip(std::span<double> x, std::span<const double> gaps, double dt);

 private:
  void find_reached(std::span<const double> gaps);

  const ContactSurface* surface_;
  const SelfContact* contact_;
  FluidGrid grid_;
  FilmDrainageOptions options_;
  std::vector<int> surface_index_;   // per leaflet node: contact-surface index of its atrial-face node, -1 for fixed nodes
  std::vector<double> hinge_fade_, border_fade_;  // per contact-surface node: 0 at the hinge, at the free border
  std::vector<int> column_start_, column_;  // leaflet nodes of each contact-surface node's column
  std::vector<Eigen::Vector3d> normals_;
  std::vector<double> areas_, fade_;        // m2; s(gap); per contact-surface node
  std::vector<double> unbalanced_, film_, film_smoothed_;  // Pa
  std::vector<Eigen::Vector3d> slip_, smoothed_;  // m/s, per contact-surface node
  std::vector<int> neighbour_start_, neighbours_; // of each atrial-face node on its face
  // Contact-surface nodes that the slip can reach for the gaps it was last called with: sources and what smoothing spreads them to.
  std::vector<double> known_gaps_;
  std::vector<int> reached_;
  std::vector<char> is_reached_;
  std::vector<int> leaflet_reached_;  // leaflet nodes that belong to them
  ClosestGaps closest_;
};

/// Pressure (Pa) at a point (m, tube frame), trilinear in a padded cell field; constant beyond the last cell centres.
double pressure_at(const FluidGrid& grid, const std::vector<double>& pressure, const Eigen::Vector3d& x);

}  // namespace mv
