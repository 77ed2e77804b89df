// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Motion of tissue and contact without blood, the step of Simulation::advance without a fluid:
//   v += dt F(x) / m,  v /= 1 + dt damping,  x += dt v      (semi-implicit Euler; v lives half a step after x), then what the crossing guard stops.
// SI units.

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "solver/contact/crossing_guard.h"
#include "solver/contact/self_contact.h"
#include "verification/solid/box_mesh.h"

namespace mv::test {

struct DryEnergies {
  double kinetic = 0;   // J, from the velocities half a step before and after x: what the scheme keeps
  double elastic = 0, contact = 0;
  double friction_loss = 0, damping_loss = 0;   // J, since the start
  double total() const { return kinetic + elastic + contact; }
};

class DryMotion {
 public:
  DryMotion(const SolidMesh& mesh, const Material& material);
  /// Contact of the whole boundary, or of the atrial faces only when `side` (mv::Side per node) is given.
  void add_contact(const ContactOptions& options, const std::vector<int>& side = {});

  /// Keeps the surface of add_contact from passing through itself. Nodes of which a component is held now are never moved by it.
  void add_guard();

  void step(double dt);
  double critical_step() { return solid_->critical_step(x); }

  std::vector<double> x, v, external, masses;   // 3 n; external: dead forces (N); masses: kg, per component
  std::vector<char> is_held;                    // per component: velocity stays as it is (0 unless set)
  double damping = 0;                           // 1/s
  std::function<void(std::span<const double>, std::span<double>)> load;  // adds further forces

  LeafletSolid& solid() { return *solid_; }
  SelfContact& contact() { return *contact_; }
  const ContactSurface& surface() const { return surface_; }
  const ContactResult& contact_result() const { return contact_result_; }
  const std::vector<double>& forces() const { return forces_; }  // N, of the last step, at its start; external and load included
  const DryEnergies& energies() const { return energies_; }      // at the start of the last step
  Vec3 guard_force() const { return guard_force_; }              // N, on all nodes together in the last step: what held nodes gave
  long guard_impulses() const { return guard_impulses_; }        // since the start
  Vec3 momentum() const;
  Vec3 angular_momentum() const;

 private:
  void guard(double dt);

  std::unique_ptr<LeafletSolid> solid_;
  ContactSurface surface_;
  std::unique_ptr<SelfContact> contact_;
  ContactResult contact_result_;
  std::optional<CrossingGuard> guard_;
  Vec3 guard_force_ = Vec3::Zero();
  long guard_impulses_ = 0;
  std::vector<double> x_before_;
  std::vector<double> forces_;
  DryEnergies energies_;
};

/// Young's modulus and Poisson ratio of the neo-Hookean law at small strain.
struct SmallStrain {
  double youngs, poisson;
};
SmallStrain small_strain(double shear, double bulk);
/// Bulk modulus for a Poisson ratio.
inline double bulk_of(double shear, double poisson) { return 2 * shear * (1 + poisson) / (3 * (1 - 2 * poisson)); }

}  // namespace mv::test
