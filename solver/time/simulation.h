// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// One run of a scene: owns the models, advances a State.
//
// With blood (immersed boundary, papers/s1): forces of tissue, chordae and contact at x are spread onto the grid, the blood advances,
// and the nodes move with the interpolated velocity. Without blood every node moves on its own mass under the pressure on its face.
// Semi-implicit (symplectic) Euler; the step follows the current tangent (stable_step.h).

#include <functional>
#include <memory>
#include <optional>

#include "solver/contact/crossing_guard.h"
#include "solver/coupling/coupling.h"
#include "solver/coupling/film_drainage.h"
#include "solver/coupling/wall_limit.h"
#include "solver/time/annulus_skirt.h"
#include "solver/time/scene.h"
#include "solver/time/stable_step.h"
#include "solver/time/structure.h"
#include "solver/time/waveform.h"

namespace mv {

class Simulation {
 public:
  /// Throws what preflight() finds wrong with the scene.
  explicit Simulation(Scene scene);

  State initial_state();

  /// Advances by one step of the length that stability allows, at most up to `stop_time`. A step that fails (not finite, an element inverted, a
  /// node outside the box or moving too fast) is rolled back to the last good state and repeated with smaller steps. Throws TrustError
  /// with the reason when that does not help either. Returns the name of what limited the step.
  std::string step(State& state, double stop_time);

  double pressure_difference(double time) const { return waveform_.at(time); }  // Pa, ventricle minus atrium
  double flow_backward(const State& state) const;   // m3/s, ventricle to atrium
  double total_energy(const State& state) const;    // J, kinetic + elastic
  double kinetic_energy(const State& state) const;  // J
  /// What the discrete budget leaves unexplained over the work done (DESIGN, section 6).
  double energy_residual(const State& state) const;

  /// Recomputes forces and contact at the state's positions without moving anything, so that per-node results belong to this state.
  void refresh(State& state);

  /// Pressure (Pa, padded cell field, zero at the open ends) that the spread contact forces of the last evaluation alone cause; blood and contact needed.
  const std::vector<double>& pressure_of_contact(const State& state);

  /// The state a rollback returns to, for the checkpoint; null before the first step.
  const State* snapshot() const { return has_snapshot_ ? &snapshot_ : nullptr; }
  void restore_snapshot(const State& snapshot) {
    snapshot_ = snapshot;
    has_snapshot_ = true;
  }

  const Scene& scene() const { return scene_; }
  Structure& structure() { return *structure_; }
  const Structure& structure() const { return *structure_; }
  const NavierStokes* fluid() const { return fluid_ ? &*fluid_ : nullptr; }
  const Coupling* coupling() const { return coupling_ ? &*coupling_ : nullptr; }
  PartTimes& times() { return times_; }
  const std::vector<double>& forces() const { return forces_; }

 private:
  void advance(State& state, double dt);
  void update_relaxation(State& state);
  /// Moves held nodes to where the annulus is at the end of the step and books the work.
  void move_annulus(State& state, double dt);
  /// Positions x of a moving annulus' nodes and of its skirt at `time`, and which of them hold.
  void place_hold(double time, std::vector<double>& x);
  /// Where a moving annulus and its skirt hold the blood at `time` and how they move during the next dt > 0.
  void carry_hold(double time, double dt);
  /// Names what holds the blood at the annulus.
  void hold_annulus();
  /// Books what relaxation and slip, which the blood does not feel, take from the budget.
  void book_unseen_motion(State& state);
  /// Takes what the guard stopped from the velocities of nodes that move on their own mass; returns the energy (J) lost.
  double slow_down(State& state, double dt) const;
  double work_on(const std::vector<double>& shift) const;
  /// Largest component of the motion of this step (m) over the first `count` coordinates; NaN when one of them is.
  double largest_motion(const State& state, std::size_t count) const;
  /// Takes from the step what would carry leaflets through the tube's wall or through each other, and books its loss.
  void guard_motion(State& state, double dt);
  /// Adds motion that the blood does not see to this step's, with the work of the forces on it.
  void add_unseen(State& state, std::span<const int> nodes, std::span<const Eigen::Vector3d> shifts);
  double choose_step(State& state, double stop_time, std::string& limiter);
  /// Why the step just made cannot stand, or empty; notes the largest velocity of a node.
  std::string failure(State& state, int outside) const;
  double motion_scale() const;  // m, what motions of one step are measured against

  Scene scene_;
  Waveform waveform_;
  std::optional<Structure> structure_;
  std::optional<NavierStokes> fluid_;
  std::optional<Coupling> coupling_;
  std::optional<FilmDrainage> drainage_;
  std::optional<StableStep> stable_step_;
  std::optional<CrossingGuard> guard_;   // with contact
  std::optional<WallLimit> wall_limit_;  // with blood in a tube
  std::optional<AnnulusSkirt> skirt_;    // with blood and a moving annulus
  FaceField force_density_;
  std::vector<double> forces_;
  std::vector<double> x_before_;
  std::vector<double> element_steps_;
  std::vector<double> hold_place_, hold_velocity_;  // of a moving annulus: its nodes, then its skirt
  std::vector<char> is_hold_active_;
  State snapshot_;
  bool has_snapshot_ = false, has_warned_of_step_ = false;
  int outside_ = 0, held_count_ = 0;
  PartTimes times_;
};

}  // namespace mv
