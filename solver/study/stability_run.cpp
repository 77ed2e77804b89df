// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/stability_run.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <ctime>
#include <map>

#include "geometry/core/errors.h"
#include "solver/contact/intersection.h"
#include "solver/output/contact_map.h"
#include "solver/time/measure.h"

namespace mv {
namespace {

constexpr double watch_every = 0.5e-3;     // s, simulated, between two looks at the run
constexpr double late_share = 0.2;         // of the run, over which the late leak is the mean
// The coarse valve takes some 25 beats to settle: until then its mean shape moves by 0.7 mm, without a trend afterwards (film of blood, means of ten beats).
constexpr int beats_averaged = 10, beats_settling = 45;

/// Of this process: what a case costs must not depend on what else the machine does.
double processor_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// What is gathered while a case runs.
class Watch {
 public:
  Watch(Simulation& simulation, const StabilityCase& stability_case) : simulation_(simulation), case_(stability_case) {}

  void look(const State& state) {
    const Structure& structure = simulation_.structure();
    volume_drift = std::max(volume_drift, std::abs(structure.solid().statistics().volume / structure.reference_volume() - 1.0));
    if (const NavierStokes* fluid = simulation_.fluid()) peak_velocity = std::max(peak_velocity, fluid->peak_velocity(state.flow));
    pressure_peak = std::max(pressure_peak, std::abs(simulation_.pressure_difference(state.time)));
    if (late_time_ < 0 && state.time >= (1 - late_share) * case_.end) {
      late_time_ = state.time;
      late_volume_ = passed(state);
    }
    if (case_.behaviour == Behaviour::beats) look_at_beat(state);
  }

  /// m3/s, net of what the leaflets sweep; not a number where the end was not looked at
  double late_leak(const State& state) const { return late_time_ >= 0 && state.time > late_time_ ? (passed(state) - late_volume_) / (state.time - late_time_) : std::numeric_limits<double>::quiet_NaN(); }

  void put_beats(CaseOutcome& outcome) const {
    if (late_beats_.count < 2 || early_beats_.count < 2) return;
    double sum = 0, scatter = 0;
    for (std::size_t a = 0; a < early_beats_.x.size(); ++a) {
      const double moved = late_beats_.x[a] / late_beats_.count - early_beats_.x[a] / early_beats_.count;
      sum += moved * moved;
      scatter += variance(early_beats_.x[a], early_beats_.x2[a], early_beats_.count) + variance(late_beats_.x[a], late_beats_.x2[a], late_beats_.count);
    }
    const double nodes = static_cast<double>(early_beats_.x.size()) / 3.0;
    outcome.beat_drift_mm = 1e3 * std::sqrt(sum / nodes);
    outcome.beat_scatter_mm = 1e3 * std::sqrt(0.5 * scatter / nodes);
    outcome.beat_volume_ml = 1e6 * early_beats_.volume / early_beats_.count;
    outcome.beat_volume_drift_ml = 1e6 * (late_beats_.volume / late_beats_.count - early_beats_.volume / early_beats_.count);
    outcome.beat_volume_scatter_ml =
        1e6 * std::sqrt(0.5 * (variance(early_beats_.volume, early_beats_.volume2, early_beats_.count) + variance(late_beats_.volume, late_beats_.volume2, late_beats_.count)));
    outcome.beats_averaged = std::min(early_beats_.count, late_beats_.count);
  }

  double volume_drift = 0, peak_velocity = 0, pressure_peak = 0, chordae_energy = 0;

 private:
  struct Beats {
    std::vector<double> x, x2;        // summed positions and their squares
    double volume = 0, volume2 = 0;   // summed backward volumes and their squares
    int count = 0;
  };
  static double variance(double sum, double squares, int count) { return std::max(0.0, squares - sum * sum / count) / (count - 1); }

  static double passed(const State& state) { return state.volume_backward - state.volume_swept; }

  void look_at_beat(const State& state) {
    // Mid-hold of each beat; the volume is that of the beat before.
    const double phase = state.time / beat_length - beat_hold_middle;
    if (phase < beats_seen_) return;
    const double volume = state.volume_backward - volume_last_;
    volume_last_ = state.volume_backward;
    const int beat = beats_seen_++;
    Beats* beats = beat >= beat_count - beats_averaged                                  ? &late_beats_
                   : beat >= beats_settling && beat < beats_settling + beats_averaged ? &early_beats_
                                                                                      : nullptr;
    if (!beats) return;
    beats->x.resize(state.x.size(), 0.0);
    beats->x2.resize(state.x.size(), 0.0);
    for (std::size_t a = 0; a < state.x.size(); ++a) beats->x[a] += state.x[a], beats->x2[a] += state.x[a] * state.x[a];
    beats->volume += volume;
    beats->volume2 += volume * volume;
    ++beats->count;
  }

  Simulation& simulation_;
  const StabilityCase& case_;
  double late_time_ = -1, late_volume_ = 0, volume_last_ = 0;
  int beats_seen_ = 0;
  Beats early_beats_, late_beats_;
};

bool is_finite(const std::vector<double>& values) {
  for (double v : values)
    if (!std::isfinite(v)) return false;
  return true;
}

bool is_finite(const State& state) {
  bool all = is_finite(state.x) && is_finite(state.v) && is_finite(state.flow.pressure);
  for (const auto& c : state.flow.velocity.c) all = all && is_finite(c);
  return all && std::isfinite(state.volume_backward) && std::isfinite(state.elastic_energy);
}

double area_of(const std::vector<Vec3>& loop) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < loop.size(); ++i) sum += (loop[i] - loop[0]).cross(loop[(i + 1) % loop.size()] - loop[0]);
  return 0.5 * sum.norm();
}

void put_state(CaseOutcome& outcome, Simulation& simulation, const State& state, const Watch& watch) {
  const Scene& scene = simulation.scene();
  outcome.simulated_s = state.time;
  outcome.steps = state.step;
  outcome.rollbacks = state.rollbacks;
  outcome.dt_mean_s = state.step > 0 ? state.dt_sum / static_cast<double>(state.step) : 0.0;
  outcome.dt_min_s = state.step > 0 ? state.dt_min : 0.0;
  outcome.energy_residual = simulation.energy_residual(state);
  outcome.volume_drift = watch.volume_drift;
  outcome.J_min = state.J_min;
  outcome.controlled_fraction = state.controlled_fraction_max;
  outcome.is_finite = is_finite(state);
  outcome.pressure_peak_Pa = watch.pressure_peak;
  outcome.annulus_area_mm2 = area_of(scene.annulus.points);
  outcome.fluid_density = scene.config.number("fluid.density");
  outcome.has_fluid = scene.has_fluid();
  outcome.has_chordae = scene.has_chordae();
  outcome.peak_velocity_m_s = watch.peak_velocity;
  outcome.has_closed = state.closing_time >= 0;
  outcome.closing_volume_ml = 1e6 * state.closing_volume;
  outcome.backward_volume_ml = 1e6 * state.volume_backward;
  outcome.late_leak_ml_s = 1e6 * watch.late_leak(state);
  if (const ChordaeTension* chordae = simulation.structure().chordae())
    for (const auto& pull : chordae->papillary_forces()) outcome.papillary_force_N += pull.norm();
  outcome.chordae_energy_J = watch.chordae_energy;
  outcome.tissue_volume_mm3 = 1e9 * simulation.structure().reference_volume();
  watch.put_beats(outcome);
}

/// Crossing triangles of the leaflets' surface, as the gate of `mvsolve run` counts them.
long crossings_of(const Simulation& simulation, const State& state) {
  return static_cast<long>(self_intersections(world_points(simulation, state), boundary_faces(simulation.scene().mesh).triangles).size());
}

}  // namespace

CaseOutcome run_stability_case(const StabilityCase& stability_case, const std::filesystem::path& case_directory, double seconds) {
  const double begun = processor_seconds();
  auto elapsed = [&] { return processor_seconds() - begun; };
  CaseOutcome outcome;
  std::optional<Simulation> simulation;
  try {
    Scene scene = load_scene(case_directory, stability_case.settings);
    if (stability_case.alter) stability_case.alter(scene);
    simulation.emplace(std::move(scene));
  } catch (const Error& error) {
    outcome.end = CaseEnd::refused;
    outcome.reason = error.what();
    outcome.seconds = elapsed();
    return outcome;
  }
  State state = simulation->initial_state();
  Watch watch(*simulation, stability_case);
  std::map<std::string, long> limiters;
  outcome.end = CaseEnd::finished;
  for (long look = 0; state.time < stability_case.end - 1e-12;) {
    const double next = std::min(static_cast<double>(look + 1) * watch_every, stability_case.end);
    try {
      ++limiters[simulation->step(state, next)];
      watch.chordae_energy = std::max(watch.chordae_energy, state.chordae_energy);
    } catch (const TrustError& error) {
      outcome.end = CaseEnd::stopped;
      outcome.reason = error.what();
      break;
    }
    if (state.time >= next - 1e-12) {
      ++look;
      watch.look(state);
    }
    if (elapsed() > seconds) {
      outcome.end = CaseEnd::late;
      outcome.reason = fmt::format("reached {:.4g} of {:.4g} s in its {:.0f} s of processor time", state.time, stability_case.end, seconds);
      break;
    }
  }
  limiters.erase("output");
  for (const auto& [name, count] : limiters)
    if (outcome.limiter.empty() || count > limiters[outcome.limiter]) outcome.limiter = name;
  put_state(outcome, *simulation, state, watch);
  if (outcome.is_finite) outcome.self_intersections = crossings_of(*simulation, state);
  outcome.seconds = elapsed();
  return outcome;
}

}  // namespace mv
