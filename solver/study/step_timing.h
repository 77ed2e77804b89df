// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Seconds per step of a simulation by part, from a state that is brought there once.

#include <array>
#include <string>
#include <vector>

#include "solver/time/simulation.h"

namespace mv {

inline constexpr std::size_t part_count = 7;
/// Names of the parts in the order of part_seconds: fluid, coupling, tissue, contact, chordae, step estimate, output.
const std::array<const char*, part_count>& part_names();
std::array<double, part_count> part_seconds(const PartTimes& times);

struct StepTiming {
  double wall = 0;                            // s per step, output included; median of the repeats
  std::array<double, part_count> part{};      // s per step, each the median of the repeats
  double dt = 0;                              // s, mean step
  double spread = 0;                          // (slowest - fastest repeat) / median of the wall time
  State end;                                  // after the timed steps of the last repeat
};

/// Advances copies of `from` by `steps` steps, `repeats` times, after a few steps that are not timed. `steps` should be a multiple of 100, so that
/// what is done every 10, 20 or 50 steps counts with its share. Output is what a run computes for its series and leaflet frames, spread over
/// the steps between them; writing files is not in it.
StepTiming time_steps(Simulation& simulation, const State& from, int steps, int repeats);

/// Advances from rest to `time` (s). Throws TrustError when the run cannot go on.
State bring_to(Simulation& simulation, double time);

double median(std::vector<double> values);

}  // namespace mv
