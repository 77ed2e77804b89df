// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Balanced master-slave self-contact with a penalty on the averaged normal gap and Coulomb friction (s0, section 2.2).
//
// For slave node i and a triangle f that faces it: p_f = n_f . (x_i - f) is the signed distance along the triangle's outward
// normal, l_f the distance in the triangle's plane from the foot of the perpendicular to the triangle.
//   gap          g_i = sum_f w_f p_f / W,   W = sum_f w_f,   w_f = chi_f (1 - l_f^2 / (R_f^2 + gamma^2 p_f^2))^2  (0 beyond)
//   energy       E_i = (k_i / 2) a(W) Phi(threshold - g_i)   for g_i < threshold;  forces are -dE_i/dx with chi_f held
//   Phi(o) = o^2 / 2 + hardening o^14 / (14 threshold^12): linear for light contact, stiff before faces could pass through each other;
//            continued with the tangent of gap 0 for g < 0
//   k_i          = stiffness * A_i (reference tributary area), or the caller's value (N/m)
// R_f is the averaging radius, chi_f a smooth factor for opposing normals, depth and the nearest sheet, a(W) fades the force
// where the slave leaves the surface's border. E_i does not change under rigid motions, hence force and moment balance to
// round-off. Both surfaces are slaves in turn with half the stiffness each: two parallel sheets feel the pressure stiffness *
// Phi'(threshold - gap).

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "solver/contact/closest_gaps.h"
#include "solver/contact/surface.h"

namespace mv {

/// SI units. A value of 0 marked "auto" is replaced in the constructor by the rule given; `SelfContact::options()` returns the
/// result.
struct ContactOptions {
  double threshold = 0.2e-3;      // m, a node pushes when its gap is smaller
  // Nodes on a rim use threshold + border_offset wherever a formula says threshold.
  double stiffness = 1e9;         // Pa/m, pressure per unit of (threshold - gap)
  double hardening = 0;           // 0: linear; else faces at gap 0 carry 1 + hardening times what the linear law gives
  double friction = 0.2;          // Coulomb coefficient; 0 leaves friction out (no cost)
  double tangential_ratio = 0.5;  // tangential over normal stiffness of the elastic slip
  double thickness = 1e-3;        // m, leaflet thickness; sets the defaults below (0 for open surfaces without a back side)
  double border_offset = 0;       // m, nodes of a rim push from this much further away: sharp borders, which cut faces between nodes
  double penetration_limit =
      0;  // m, deeper than this a triangle is taken as seen from behind; auto: half the thickness (or mean edge)
  double exclusion_radius = 0;    // m, reference distance along the solid within which node and triangle of the same face never
                                  // touch; auto: max(2 mean edges, thickness)
  double exclusion_radius_through = 0;  // m, the same for different faces; auto: exclusion_radius, or if that is auto
                                        // too, max(exclusion_radius, 1.5 thickness)
  double averaging_ratio = 0.35;  // R_f over the edge of the equilateral triangle of the facet's reference area
  double skin = 0;                // m, extra search distance; auto: 0.6 mean edges
  int search_every = 0;           // largest number of steps between searches; 0: only when the skin is used up
};

/// Totals of one evaluation.
struct ContactResult {
  double normal_force = 0;     // N, carried across the interface, counted once: half the sum of the nodes' normal forces
  double friction_force = 0;   // N, the same for the magnitude of friction
  double contact_area = 0;     // m2, half the current tributary area of the active nodes
  double penetration_max = 0;  // m, largest depth of an active node behind a facing triangle that it is over (foot within); 0: no node is in a face
  double min_gap = std::numeric_limits<double>::infinity();  // m, averaged, over active nodes; negative also beside a border, where planes go on and no faces overlap
  double potential_energy = 0;                               // J, sum of E_i
  double friction_energy = 0;                                // J, stored in elastic slip
  double friction_dissipation = 0;                           // J, lost to friction in this step (never negative)
  int active_nodes = 0;                                      // nodes with gap < threshold and a force
  bool searched = false;                                     // candidates were renewed in this call
};

class SelfContact {
 public:
  /// The surface is kept by reference and must outlive this object. Throws InputError on meaningless options.
  SelfContact(const ContactSurface& surface, const ContactOptions& options);
  ~SelfContact();
  SelfContact(SelfContact&&) noexcept;
  SelfContact& operator=(SelfContact&&) = delete;

  /// Penalty stiffness per surface node (N/m), for instance alpha * m / dt^2; empty: back to stiffness * area. Copied.
  /// Central differences need alpha well below 1 (both passes act on a node): at most 0.5.
  void set_node_stiffness(std::span<const double> stiffness);

  /// Renews the candidate pairs now. Results never depend on when this is called, only the time does.
  void update_candidates(std::span<const double> x);

  /// Adds contact forces (N) to `forces` and moves the friction history on by dt. x (m), v (m/s), forces: 3 * solid_nodes,
  /// interleaved. Renews candidates when the skin is used up. Does not allocate, except when more pairs are near, or press, than ever
  /// before. Throws TrustError on positions that are not finite. Same bytes for every thread count.
  ContactResult evaluate(std::span<const double> x, std::span<const double> v, double dt, std::span<double> forces);

  /// Nearest facing triangle of each surface node up to `max_distance`; `atrial_only` asks for atrial nodes against atrial
  /// triangles. Own search, independent of evaluate(); reuses the vectors in `out`.
  void closest_gaps(std::span<const double> x, double max_distance, bool atrial_only, ClosestGaps& out) const;

  // Per surface node, as of the last evaluate().
  std::span<const double> gap() const;           // m, averaged; infinity when nothing faces the node nearby
  std::span<const double> visibility() const;    // a(W): 1 where facing triangles surround the node's foot, 0 where it sees none within reach
  std::span<const double> normal_force() const;  // N, k_i a Phi'(threshold - gap): what the node's whole tributary area carries
  std::span<const double> pressure() const;      // Pa, normal_force over the current tributary area
  std::span<const Eigen::Vector3d> friction_force() const;  // N, on the node's whole tributary area
  std::span<const Eigen::Vector3d> normal() const;          // unit, from the opposing face towards the node; zero when inactive
  std::span<const int> partner() const;                     // opposing triangle of largest weight, -1 when none
  std::span<const Eigen::Vector3d> nodal_force() const;     // N, all that evaluate() added at the node (slave and master parts)

  /// Friction history: elastic slip (m), 3 per surface node. All of the state that influences later steps.
  std::vector<double> export_history() const;
  void export_history(std::vector<double>& slip) const;  // reuses its memory
  void import_history(std::span<const double> slip);

  const ContactOptions& options() const;

  /// Tangent stiffness (N/m) of each node's penalty at the last evaluate(): k_i Phi''(threshold - gap); 0 when inactive.
  double tangent_stiffness(int node) const;
  double search_reach() const;  // m, distance up to which evaluate() may see a triangle
  long candidate_pairs() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace mv
