// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "solver/output/summary.h"
#include "solver/time/measure.h"

namespace mv {

/// What the end of a run adds to the state.
struct RunFacts {
  double wall_seconds = 0;
  double leak_rate = 0;          // m3/s, mean net leak of the last 50 ms
  double leak_window = 0;        // s, over which it is the mean
  double peak_velocity = 0;      // m/s, over the whole run
  double volume_drift_max = 0;   // over the whole run
  std::string end;               // "finished", or the reason of an early end
};

/// summary.json of DESIGN section 2: seal by topology, contact belt, bulging, chordae, energy. `contact` belongs to `state`.
Summary summarize(Simulation& simulation, const State& state, const ContactMeasure& contact, const RunFacts& facts);

/// Trust gates that failed, one line each (DESIGN, section 5); empty when the run can be believed.
std::vector<std::string> failed_trust_gates(const Summary& summary);

}  // namespace mv
