// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Forces of everything that is not blood: tissue, chordae, contact, and the pressure put straight on the ventricular face when a scene
// has no blood.

#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <optional>

#include "solver/chordae/chordae_tension.h"
#include "solver/contact/self_contact.h"
#include "solver/solid/leaflet_solid.h"
#include "solver/time/boundary_motion.h"
#include "solver/time/scene.h"
#include "solver/time/state.h"

namespace mv {

/// Seconds spent in each part of a run.
struct PartTimes {
  double fluid = 0, coupling = 0, solid = 0, contact = 0, chordae = 0, step_estimate = 0, output = 0;
  double sum() const { return fluid + coupling + solid + contact + chordae + step_estimate + output; }
};

/// Law and parameters of a leaflet ("anterior" or "posterior"). Throws ConfigError.
Material material_of(const Config& config, const std::string& leaflet);

class Structure {
 public:
  /// Positions in the scene (mm, world) become SI in the tube frame.
  Structure(const Scene& scene, double largest_pressure);

  int node_count() const { return static_cast<int>(is_fixed_.size()); }
  int leaflet_nodes() const { return leaflet_nodes_; }
  const std::vector<double>& rest_positions() const { return rest_; }
  const std::vector<char>& is_fixed() const { return is_fixed_; }
  const std::vector<double>& masses() const { return masses_; }  // kg per node; without blood times mass_factor()
  double mass_factor() const { return mass_factor_; }
  double damping_rate() const { return damping_rate_; }  // 1/s, of all motion; 0 with blood
  const std::vector<Eigen::Vector3d>& tips() const { return tips_; }

  /// All nodal forces (N) at the state's positions with papillary tips and cuts as at the end of the step, overwriting `forces`; moves the friction history on by dt. `ventricular_pressure` (Pa) acts on
  /// the ventricular face when the scene has no blood. Updates the energies and statistics in `state`.
  void evaluate(State& state, double dt, double ventricular_pressure, std::span<double> forces, PartTimes& times);

  /// Sets the positions x (kept by reference until the last product) of the following stiffness_times().
  void begin_products(std::span<const double> x);

  /// out = K v with K = -dF/dx at the x of begin_products(); `shares` receives the parts of v.K.v: tissue, chordae, contact.
  void stiffness_times(std::span<const double> v, std::span<double> out, std::array<double, 3>& shares);

  LeafletSolid& solid() { return *solid_; }
  const LeafletSolid& solid() const { return *solid_; }
  ChordaeTension* chordae() { return chordae_ ? &*chordae_ : nullptr; }
  const ChordaeTension* chordae() const { return chordae_ ? &*chordae_ : nullptr; }
  SelfContact* contact() { return contact_.get(); }
  const SelfContact* contact() const { return contact_.get(); }
  const ContactSurface& surface() const { return surface_; }
  const std::vector<double>& hinge_distances() const { return hinge_distances_; }  // m at rest, per surface node, to the annulus
  const ContactResult& contact_result() const { return contact_result_; }
  double contact_threshold() const { return threshold_; }   // m, gap below which faces count as touching
  const std::vector<std::array<int, 3>>& ventricular_faces() const { return ventricular_faces_; }
  const std::vector<std::array<int, 3>>& atrial_faces() const { return atrial_faces_; }
  double reference_volume() const { return reference_volume_; }

 private:
  std::span<const double> x_of_products_;
  std::vector<double> tissue_forces_;  // at x_of_products_
  void move_boundary(State& state, double dt);
  void stand_in_for_blood(const Config& config, double largest_pressure);

  int leaflet_nodes_ = 0;
  std::vector<double> rest_, masses_;
  std::vector<char> is_fixed_;
  std::vector<Eigen::Vector3d> tips_;
  std::optional<BoundaryMotion> motion_;   // only when something moves
  std::optional<LeafletSolid> solid_;
  std::optional<ChordaeTension> chordae_;
  ContactSurface surface_;
  std::vector<double> hinge_distances_;
  std::unique_ptr<SelfContact> contact_;
  ContactResult contact_result_;
  double threshold_ = 0, reference_volume_ = 0;
  double mass_factor_ = 1, damping_rate_ = 0;
  bool has_fluid_ = true;
  std::vector<std::array<int, 3>> ventricular_faces_, atrial_faces_;
};

}  // namespace mv
