// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Tissue and blood in a slab that is periodic in y and a few cells deep, composed from the solver's parts in the order of
// Simulation::advance. SI units. What the kernel spreads beyond y = 0 and y = depth is folded back onto the grid; everything else
// is the solver's own code.

#include <memory>
#include <optional>
#include <vector>

#include "solver/coupling/coupling.h"
#include "solver/coupling/film_drainage.h"
#include "verification/slab_body.h"
#include "verification/slab_tissue.h"

namespace mv::test {

/// Adds what was spread beyond the periodic sides to its image inside and sets the ghost layers to zero, or to the images with
/// `fill`.
void fold_periodic_y(const FluidGrid& grid, FaceField& field, bool fill);

/// What Coupling::relax() acts on: nothing, or all that is unseen, contact and the film's pressure included, as in Simulation::advance.
enum class Relaxation { none, all_forces };

struct SlabSetup {
  FluidGrid grid;
  FluidBoundary boundary;   // y is made periodic
  double density = 1060;    // kg/m3, blood and tissue
  double viscosity = 4e-3;  // Pa s
  Kernel kernel = Kernel::ib4;
  Material material;
  Relaxation relaxation = Relaxation::none;
  bool held_tissue_holds_blood = true;  // else held nodes of the tissue are clamped to something outside the blood
};

class SlabFlow {
 public:
  /// `held_points`: further nodes without tissue that hold the blood at rest. A tissue without elements is allowed.
  SlabFlow(const SlabSetup& setup, const SlabTissue& tissue, const std::vector<double>& held_points);

  /// Atrial faces touch each other; with `drainage` the film between them drains.
  void set_contact(const ContactOptions& contact, const std::optional<FilmDrainageOptions>& drainage);

  /// A rigid body at rest; replaces an earlier one.
  void set_body(SlabBody body);

  /// Normal velocities (m/s) at the end of the following steps on a side of kind inflow, as NavierStokes::set_inflow() wants them.
  void set_inflow(std::size_t axis, std::size_t side, std::span<const double> normal_velocity) {
    fluid_.set_inflow(axis, side, normal_velocity);
  }

  /// One step as in Simulation::advance. `pressure` (Pa) acts on the lower z side at the new time, every other open side is at
  /// zero.
  void advance(double dt, double pressure);

  /// All forces (N) of the last step on the blood: of the moving tissue, of what is held and of the body (on the blood around it).
  Vec3 force_on_blood() const;
  /// Momentum (kg m/s) of the moving tissue.
  Vec3 tissue_momentum() const;

  /// Contact at the present positions without moving its history; nodal forces (N) of contact alone, copies included.
  std::vector<double> contact_forces();
  /// The grid pressure (Pa, padded) that nodal forces alone produce: phi of f = grad phi + divergence-free part, zero on open
  /// sides.
  std::vector<double> pressure_of(std::vector<double> forces);

  /// Of the tissue at the last step.
  const SolidStatistics& statistics() const { return solid_->statistics(); }
  const std::vector<double>& x() const { return x_; }
  const std::vector<double>& v() const { return v_; }
  const FlowState& flow() const { return flow_; }
  const NavierStokes& fluid() const { return fluid_; }
  const SelfContact& contact() const { return *contact_; }
  const ContactSurface& surface() const { return surface_; }

 private:
  std::span<double> leaflet(std::vector<double>& array) const {
    return std::span<double>(array).first(tissue_.mesh.points.size());
  }
  void relax_and_drain(const CoupledNodes& nodes, double dt, double pressure);
  std::vector<double> find_unseen(const std::vector<double>& forces);
  void update_relaxation();

  SlabTissue tissue_;
  SlabSetup setup_;
  NavierStokes fluid_;
  std::optional<LeafletSolid> solid_;  // none when the tissue has no elements
  Coupling coupling_;
  ContactSurface surface_;
  std::unique_ptr<SelfContact> contact_;
  std::optional<FilmDrainage> drainage_;
  FlowState flow_;
  FaceField force_density_, scratch_;
  std::vector<double> rest_, x_, v_, x_before_, forces_, volumes_;
  std::vector<double> holding_, relax_steps_, mean_volume_, relax_shift_, film_gaps_;
  SlabBody body_;
  Vec3 body_force_ = Vec3::Zero();
  std::vector<char> is_still_;  // held or a copy: takes no part in the coupling
  long step_ = 0;
};

}  // namespace mv::test
