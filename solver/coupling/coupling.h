// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// How leaflets and blood exchange forces and motion: the one narrow interface behind which a coupling scheme lives.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "solver/coupling/transfer.h"
#include "solver/fluid/navier_stokes.h"

namespace mv {

/// The nodes as a coupling sees them. Arrays xyz interleaved, SI, tube frame.
struct CoupledNodes {
  std::span<double> x;
  std::span<double> v;
  std::span<const char> is_fixed;      // per node: held by the annulus
};

class Coupling {
 public:
  Coupling(Transfer transfer, double fluid_density);

  /// Names the nodes that hold() works on, at the positions x where they stay. Returns how many there are.
  int set_held(std::span<const double> x, std::span<const char> is_fixed);

  /// Points that hold() works on (m, xyz interleaved), the last `axial` of them along z only. Returns how many there are.
  int set_held(std::vector<double> positions, int axial);

  /// Takes all of them to other places, where the blood is to move with `velocities` (m/s). Those with `is_active` 0 hold nothing.
  void carry_held(std::span<const double> positions, std::span<const double> velocities, std::span<const char> is_active);

  /// Makes hold() gentle enough for the held points where they are now, too; called by set_held().
  void allow_for_held_mobility();

  /// The share of hold() in what the step can bear beside tissue whose step is `safety` of its own limit: where tissue and hold move the same blood, a step is stable
  /// for safety^2 + share + share < 1 (spring and damper each), of which 84 % are used, from 0.05 to 0.2.
  void set_hold_share(double safety);

  /// Ties nodes to the nearest fixed one within the kernel's reach: s cells from it at rest, a node moves with the share D of the blood's velocity and with 1 - D of the fixed
  /// node's, and hands the blood D times its force (relieve_tied()); the annulus bears the rest, so that no work is lost. Interpolation smears the clamp over the kernel: a
  /// leaflet that turns about it (velocity s on its side, 0 beyond) is read to move with r(s) > s (Transfer::smeared_ramp); D = s / r(s) gives s back. `rest`: m, 3 per node. Costs nodes times fixed nodes, once; nothing happens without fixed nodes.
  void tie_to_fixed(std::span<const double> rest, std::span<const char> is_fixed);

  /// Sorts the points; must precede the other calls of a step. Returns the number of nodes outside the box.
  int bind(const CoupledNodes& nodes);

  /// Adds the forces (N) of nodes that move with the blood to the force density (N/m3).
  void hand_over(std::span<const double> forces, FaceField& force_density) const { transfer_.spread(forces, force_density); }

  /// Takes the share of the tied nodes' forces (N) that the annulus bears back from the force density. Call after hand_over() and find_unseen(), before move(); `nodes` need
  /// not be bound. Nothing without ties.
  void relieve_tied(const CoupledNodes& nodes, std::span<const double> forces, FaceField& force_density);

  /// The part of the nodal forces that the blood does not see (N, 3 per node): F - V <F> / <V>, F and V a node's force and volume, <.> spread and
  /// interpolated back. A force density that the kernel resolves leaves nothing. Call after hand_over() and before anything else is spread.
  /// `mean_volume` (<V>, 3 per node) is part of the state; it is found anew when empty; clear it every few steps. Zero for nodes without volume
  /// and held ones. Valid until the next call.
  std::span<double> find_unseen(std::span<const double> forces, const FaceField& force_density, std::vector<double>& mean_volume);

  /// Relaxes what the kernel cannot see. Interpolation filters out motion shorter than the kernel, so distortion on that scale (left by
  /// contact, slip and round-off of large motions) would never be undone by the tissue's own stiffness. Each moving node slips by
  ///   dx_n = beta dx_(n-1) + kappa tau^2 / rho_s  R / V ,
  /// R the unseen force and what else acts without the blood's knowledge. tau is the node's own critical step (s), so that (omega tau)^2 <= 4 and the
  /// iteration (heavy ball, Polyak 1964) is stable for 4 kappa < 2 (1 + beta); soft modes relax 1 / (1 - beta) times faster than without beta.
  /// `shift` (dx, 3 per node) is part of the state and begun when empty.
  void relax(const CoupledNodes& nodes, std::span<const double> unseen, std::span<const double> critical_steps, double solid_density, std::vector<double>& shift);

  /// Volumes (m3) of the nodes; nodes without volume do not relax.
  void set_volumes(std::vector<double> volumes);

  struct HoldWork {
    double on_blood = 0, by_motion = 0;  // J; the second by what carries the held points
  };
  /// Nodes held by the annulus keep the blood around them at their own velocity V, at rest if nothing carries them, by integral and proportional control on the blood's
  /// velocity U there:
  ///   F = I - c (U - V),  dI/dt = -k (U - V),
  /// with k and c as stiff as the step, or 50 us if it is shorter, allows: shares (set_hold_share) of the limits k dt^2 < 4 / mobility and c dt < 2 / mobility, the
  /// mobility of the held nodes being found beforehand. Where dt is `tissue_share` of the step at which tissue alone would be unstable, both take no more than 60 % of what that
  /// leaves (1 - tissue_share^2). `holding` (I, N, 3 per held node) is part of the state.
  HoldWork hold(std::vector<double>& holding, const FaceField& velocity, double dt, FaceField& force_density, double tissue_share = 0);

  /// Forces (N) of the last hold() on the blood, 3 per held node in the order of set_held().
  std::span<const double> held_forces() const { return held_force_; }

  /// New velocities and positions after the blood has moved: midpoint rule, dx/dt = u(x). The velocities of fixed nodes must be those of this step. Returns the work
  /// (J) of the fixed nodes' motion on the tied ones, against the forces of relieve_tied().
  double move(const CoupledNodes& nodes, const FaceField& velocity, double dt);

  /// Acceleration (m/s2) that nodal forces cause in the blood `fluid`, the pressure's reply included: the mobility of the bound nodes.
  void accelerate(const CoupledNodes& nodes, std::span<const double> forces, NavierStokes& fluid, FaceField& scratch, std::span<double> out) const;

  const Transfer& transfer() const { return transfer_; }

 private:
  /// Zeroes x and y of the points that hold along z only (3 per held point).
  void leave_axial_part(std::vector<double>& held) const;

  struct Tie {  // tie_to_fixed(); `free`: D
    int node, fixed;
    double free;
  };

  Transfer transfer_;
  std::vector<Tie> ties_;
  std::vector<int> tied_;               // their nodes
  std::vector<double> tied_force_;      // N, 3 per node: minus what the annulus bears, zero but for tied nodes
  std::unique_ptr<Transfer> tied_transfer_;
  double density_;
  double hold_share_ = 0.15;
  std::vector<double> midpoint_;
  std::vector<double> volumes_, volume_vectors_, mean_force_, unseen_;
  FaceField volume_density_;
  std::vector<int> active_;
  std::unique_ptr<Transfer> held_transfer_;
  std::vector<int> held_active_;      // 0, 1, ...: the held nodes' arrays are compact
  int held_axial_ = 0;                // of the last ones
  std::vector<double> held_velocity_, held_force_;
  std::vector<double> held_target_;   // velocities as the kernels see them; empty: at rest
  FaceField all_ones_;                // with targets
  std::vector<char> is_held_active_;  // with targets
  double held_mobility_ = 0;          // 1/kg
};

}  // namespace mv
