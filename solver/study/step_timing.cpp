// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/step_timing.h"

#include <algorithm>
#include <chrono>

#include "solver/solid/stress.h"
#include "solver/time/measure.h"

namespace mv {
namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// Steps before the clock starts: searches, warm caches, and the two-step scheme's first step.
constexpr int warm_up = 20;

/// What one output instant of each kind costs, over the steps of length dt between two of them.
double output_per_step(Simulation& simulation, State state, double dt) {
  const Config& config = simulation.scene().config;
  auto start = Clock::now();
  measure_series(simulation, state, measure_contact(simulation, state, true));
  const double series = seconds_since(start);
  start = Clock::now();
  simulation.refresh(state);
  measure_contact(simulation, state);
  element_stress(simulation.structure().solid(), std::span<const double>(state.x.data(), 3 * static_cast<std::size_t>(simulation.structure().leaflet_nodes())));
  const double frame = seconds_since(start);
  return dt * (series / config.number("output.series_every") + frame / config.number("output.frames_every"));
}

}  // namespace

const std::array<const char*, part_count>& part_names() {
  static const std::array<const char*, part_count> names{"fluid", "coupling", "tissue", "contact", "chordae", "step estimate", "output"};
  return names;
}

std::array<double, part_count> part_seconds(const PartTimes& t) { return {t.fluid, t.coupling, t.solid, t.contact, t.chordae, t.step_estimate, t.output}; }

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

StepTiming time_steps(Simulation& simulation, const State& from, int steps, int repeats) {
  constexpr double far = 1e9;
  StepTiming out;
  std::vector<double> walls;
  std::array<std::vector<double>, part_count> parts;
  for (int r = 0; r < repeats; ++r) {
    State state = from;
    simulation.restore_snapshot(state);
    for (int s = 0; s < warm_up; ++s) simulation.step(state, far);
    const auto before = part_seconds(simulation.times());
    const double time_before = state.time;
    const auto start = Clock::now();
    for (int s = 0; s < steps; ++s) simulation.step(state, far);
    const double wall = seconds_since(start) / steps;
    const auto after = part_seconds(simulation.times());
    out.dt = (state.time - time_before) / steps;
    out.end = state;
    const double output = output_per_step(simulation, state, out.dt);
    walls.push_back(wall + output);
    for (std::size_t p = 0; p + 1 < part_count; ++p) parts[p].push_back((after[p] - before[p]) / steps);
    parts[part_count - 1].push_back(output);
  }
  out.wall = median(walls);
  const auto [low, high] = std::minmax_element(walls.begin(), walls.end());
  out.spread = out.wall > 0 ? (*high - *low) / out.wall : 0;
  for (std::size_t p = 0; p < part_count; ++p) out.part[p] = median(parts[p]);
  return out;
}

State bring_to(Simulation& simulation, double time) {
  State state = simulation.initial_state();
  while (state.time < time) simulation.step(state, time);
  return state;
}

}  // namespace mv
