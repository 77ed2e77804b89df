// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "solver/fluid/navier_stokes.h"

namespace mv {

/// Energy accounts since the start (J). Losses are positive when energy leaves.
struct EnergyLedger {
  double work_pressure = 0;      // done by the pressures at the ends of the tube (or on the ventricular face without blood)
  double work_moved = 0;         // done by moving papillary tips; negative: set free by cutting chordae
  double boundary_kinetic = 0;   // carried in by the flow through the ends
  double viscous_loss = 0;
  double advection_loss = 0;     // numerical, of the advection scheme
  double friction_loss = 0;
  double damping_loss = 0;       // structural damping
  double coupling_loss = 0;      // taken out where the annulus holds the blood at rest, where films drain and where distortion relaxes
};

/// Every unknown of a run and everything that later steps depend on. Copying it is rollback; writing it is the checkpoint.
struct State {
  double time = 0;                    // s
  long step = 0;
  std::vector<double> x, v;           // node positions (m) and velocities (m/s), tube frame, xyz interleaved
  FlowState flow;
  std::vector<double> holding;        // N, what holds the blood at rest around held nodes (Coupling::hold)
  std::vector<double> relax_steps;    // s, per node: own critical step (Coupling::relax)
  std::vector<double> mean_volume;    // smoothed node volumes at their last evaluation (Coupling::relax)
  std::vector<double> relax_shift;    // m, what the last step relaxed (Coupling::relax)
  std::vector<double> unseen_shift;   // m, what the last step relaxed and slipped together ...
  double unseen_work = 0;             // J, ... and the work of that step's forces on it
  std::vector<double> film_gaps;      // m, per leaflet node: gap to the facing leaflet at the last search (FilmDrainage)
  std::vector<double> friction_slip;  // contact history
  EnergyLedger ledger;

  // step control
  double dt = 0;                      // s, of the last step
  double frequency = 0;               // rad/s, estimate of the stiffest mode
  std::vector<double> mode_shape;     // of that mode, start of the next estimate
  std::string stiffest_part;          // what makes that mode stiff
  double dt_cap = 1e300;              // s, after a rollback
  long cap_until_step = 0;
  long last_estimate = 0, next_estimate = 0;  // steps of the estimates of `frequency`: the last one, and at the latest the next
  double energy_at_estimate = 0, contact_at_estimate = 0;  // J, elastic and contact energy at the last one
  bool is_stiffening = false;         // `frequency` grew quickly from the last estimate but one to the last
  long rollbacks = 0, rollbacks_in_a_row = 0;
  double fastest = 0;                 // m/s, largest component of a node's velocity in the last step
  double flow_step = 1e300;           // s, largest step the flow allows
  double dt_sum = 0, dt_min = 1e300;  // s

  // flow accounts (m3, positive along e3, ventricle to atrium: backwards)
  double volume_backward = 0;
  double volume_swept = 0;            // by the leaflets, same sense
  double flow_rate = 0;               // m3/s
  bool closure_began = false;
  double volume_at_closure_start = 0;
  double closing_volume = 0;          // m3, fixed when the flow first crosses zero after closure began and more than stirring passed
  double closing_time = -1;           // s, -1 before
  double elastic_energy = 0, chordae_energy = 0, contact_energy = 0;  // J, at the last force evaluation
  double initial_energy = 0;          // J, at the start
  double controlled_fraction_max = 0;
  double penetration_max = 0;
  double J_min = 1, J_max = 1;
};

}  // namespace mv
