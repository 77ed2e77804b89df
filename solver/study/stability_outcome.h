// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// How a case of `mvsolve stability` ended, and what that is worth.

#include <string>
#include <vector>

#include "solver/output/summary.h"
#include "solver/study/stability_cases.h"

namespace mv {

enum class CaseEnd {
  finished,   // reached its simulated time
  refused,    // by mvprep or mvsolve before the first step, with a reason
  stopped,    // the run gave up with a reason
  late,       // did not reach its simulated time within its time limit
  hung,       // did not answer and was ended
  crashed     // a signal, or an error that is our bug
};

/// What a case tells about itself. Lengths in mm, volumes in ml, as in summary.json.
struct CaseOutcome {
  CaseEnd end = CaseEnd::crashed;
  std::string reason;                 // "" when finished
  double simulated_s = 0;
  double seconds = 0;                 // processor time; for a case that crashed or hung, by the clock
  long steps = 0, rollbacks = 0;
  double dt_mean_s = 0, dt_min_s = 0;
  std::string limiter;                // what limited most steps
  double energy_residual = 0, volume_drift = 0, J_min = 1, controlled_fraction = 0;
  long self_intersections = 0;
  bool is_finite = true;              // every position, velocity and flow
  double pressure_peak_Pa = 0, annulus_area_mm2 = 0, fluid_density = 1060;
  bool has_fluid = false, has_chordae = false;
  double peak_velocity_m_s = 0;
  bool has_closed = false;
  double closing_volume_ml = 0, backward_volume_ml = 0, late_leak_ml_s = 0;   // the latter net of the leaflets, over the last fifth of the run
  double papillary_force_N = 0;
  double chordae_energy_J = 0, tissue_volume_mm3 = 0;   // largest energy that the chordae held
  // Cases that beat: means over the last ten beats against those of beats 46 to 55, when the valve has settled.
  double beat_drift_mm = 0;           // root mean square over the points in mid-hold
  double beat_volume_ml = 0, beat_volume_drift_ml = 0;   // backward volume a beat, and its change
  double beat_scatter_mm = 0, beat_volume_scatter_ml = 0;   // root mean square difference of a beat from the mean of its ten
  int beats_averaged = 0;             // in each mean
};

Json to_json(const CaseOutcome& outcome);
CaseOutcome outcome_from_json(const Json& json);

enum class Verdict { stable, refused, unstable, crashed, hung, unexpected };

std::string name_of(Verdict verdict);

struct Judgement {
  Verdict verdict = Verdict::crashed;
  std::string reason;   // why, in words; for `stable` what was checked last is left out
};

/// The verdict: `stable` needs the simulated time, finite numbers, the trust gates (crossings, energy, volume) and the physics of the case's behaviour;
/// `refused` needs a reason. An end other than the declared one is `unexpected`.
Judgement judge(const StabilityCase& stability_case, const CaseOutcome& outcome);

/// Gate of `mvsolve run` on the solid's volume, which the study does not ask of its coarse grid.
inline constexpr double run_volume_drift_limit = 0.01;

/// Neither stable nor refused, or not as declared.
inline bool is_bad(Verdict verdict) { return verdict != Verdict::stable && verdict != Verdict::refused; }

}  // namespace mv
