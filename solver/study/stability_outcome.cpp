// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/stability_outcome.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <type_traits>

#include "geometry/core/errors.h"

namespace mv {
namespace {

constexpr std::array<const char*, 6> end_names{"finished", "refused", "stopped", "late", "hung", "crashed"};
constexpr std::array<const char*, 6> verdict_names{"stable", "refused", "unstable", "crashed", "hung", "unexpected"};

// Gates of `mvsolve run`, but for the volume, for which that asks 1 %: on a grid of 3 mm plain closures drift by about 1 %, 300 mmHg in one step
// by 3 %. 4 % was set above these, it does not follow from an estimate; the page counts the stable cases that `mvsolve run` would not pass.
constexpr double energy_residual_allowed = 0.05, volume_drift_allowed = 0.04;

// What physics allows, wide enough for a grid of three cells a leaflet's width; a wrong answer is beyond them by far.
constexpr double jet_factor = 2.0;              // peak velocity over that of a steady jet, sqrt(2 p / rho); inertia and recoil add to it
constexpr double jet_pressure_least = 20 * 133.322;   // Pa, so that a case without much pressure has a scale
constexpr double closing_volume_least = 1.0, closing_volume_most = 30.0;   // ml; papers/s1 and s4: 10.8 and 11.6
constexpr double leak_share = 0.02;             // late net leak over the flow of a jet through the whole annulus
constexpr double papillary_share_least = 0.02, papillary_share_most = 1.5;   // over pressure times annulus area
constexpr double prolapse_share = 0.1;          // the same flow for a valve that nothing holds
constexpr double beat_drift_allowed_mm = 0.5, beat_volume_drift_allowed = 0.1;
constexpr double scatter_allowed = 2.0;         // times what the scatter from beat to beat alone would make two means differ

/// What of the behaviour's physics is not met; empty when it is.
std::string physics_defect(const StabilityCase& c, const CaseOutcome& o) {
  if (!o.has_fluid) return "";
  const double jet = std::sqrt(2 * std::max(o.pressure_peak_Pa, jet_pressure_least) / o.fluid_density);   // m/s
  // Chordae that are torn by their tips, or cut, hurl the leaflets and as much blood with them.
  const double hurled_mass = 2 * o.fluid_density * o.tissue_volume_mm3 * 1e-9;
  const double hurled = hurled_mass > 0 ? std::sqrt(2 * o.chordae_energy_J / hurled_mass) : 0.0;
  if (!(o.peak_velocity_m_s <= jet_factor * std::hypot(jet, hurled)))
    return fmt::format("blood at {:.3g} m/s, a jet of this pressure has {:.3g} m/s, chordae can hurl the leaflets at {:.3g} m/s", o.peak_velocity_m_s, jet, hurled);
  const double jet_flow = jet * o.annulus_area_mm2;   // ml/s: m/s times mm2 is 1e-6 m3/s
  const double hold = o.pressure_peak_Pa * o.annulus_area_mm2 * 1e-6;   // N
  switch (c.behaviour) {
    case Behaviour::closes:
      // Stiffly held, a coarse valve keeps a leak so small that whether the flow ever turns (has_closed) hangs on round-off; what passes beside its own motion does not.
      if (!(std::abs(o.late_leak_ml_s) <= leak_share * jet_flow))
        return o.has_closed ? fmt::format("{:.3g} ml/s pass the closed valve", o.late_leak_ml_s) : fmt::format("the valve did not close: {:.3g} ml/s pass", o.late_leak_ml_s);
      if (const double volume = o.has_closed ? o.closing_volume_ml : o.backward_volume_ml; !(volume >= closing_volume_least && volume <= closing_volume_most))
        return fmt::format("closing volume {:.3g} ml", volume);
      if (o.has_chordae && !(o.papillary_force_N >= papillary_share_least * hold && o.papillary_force_N <= papillary_share_most * hold))
        return fmt::format("chordae carry {:.3g} N, pressure times annulus area is {:.3g} N", o.papillary_force_N, hold);
      return "";
    case Behaviour::opens: return o.backward_volume_ml < 0 ? "" : fmt::format("{:.3g} ml flowed against the pressure", o.backward_volume_ml);
    case Behaviour::prolapses:
      return o.late_leak_ml_s > prolapse_share * jet_flow ? "" : fmt::format("only {:.3g} ml/s pass a valve that nothing holds", o.late_leak_ml_s);
    case Behaviour::beats: {
      // A closed coarse valve folds a little differently every beat; only what exceeds the difference of two means of such beats is drift.
      const double chance = scatter_allowed * std::sqrt(2.0 / std::max(o.beats_averaged, 1));
      if (!(o.beat_drift_mm <= beat_drift_allowed_mm + chance * o.beat_scatter_mm))
        return fmt::format("the closed valve drifted by {:.3g} mm; it differs by {:.3g} mm from beat to beat", o.beat_drift_mm, o.beat_scatter_mm);
      if (!(std::abs(o.beat_volume_drift_ml) <= beat_volume_drift_allowed * std::max(std::abs(o.beat_volume_ml), 1.0) + chance * o.beat_volume_scatter_ml))
        return fmt::format("the volume of a beat drifted by {:.3g} of {:.3g} ml; it differs by {:.3g} ml from beat to beat", o.beat_volume_drift_ml, o.beat_volume_ml, o.beat_volume_scatter_ml);
      return "";
    }
    case Behaviour::rests: return "";
  }
  return "";
}

Judgement judge_finished(const StabilityCase& c, const CaseOutcome& o) {
  if (!o.is_finite) return {Verdict::unstable, "numbers are not finite"};
  if (!(o.simulated_s >= c.end * (1 - 1e-9))) return {Verdict::unstable, fmt::format("ended at {:.4g} of {:.4g} s", o.simulated_s, c.end)};
  if (o.self_intersections > 0) return {Verdict::unstable, fmt::format("{} pairs of leaflet triangles cross", o.self_intersections)};
  if (!(o.energy_residual <= energy_residual_allowed)) return {Verdict::unstable, fmt::format("energy residual {:.3g}, at most {:.3g} is allowed", o.energy_residual, energy_residual_allowed)};
  if (!(std::abs(o.volume_drift) <= volume_drift_allowed)) return {Verdict::unstable, fmt::format("solid volume drifts by {:.3g}, at most {:.3g} is allowed", o.volume_drift, volume_drift_allowed)};
  if (const std::string defect = physics_defect(c, o); !defect.empty()) return {Verdict::unstable, "not physical: " + defect};
  return {Verdict::stable, ""};
}

/// Everything of an outcome but its end, by name.
template <class Outcome, class Visit>
void visit_fields(Outcome& o, Visit&& visit) {
  visit("reason", o.reason);
  visit("simulated_s", o.simulated_s), visit("seconds", o.seconds), visit("steps", o.steps), visit("rollbacks", o.rollbacks);
  visit("dt_mean_s", o.dt_mean_s), visit("dt_min_s", o.dt_min_s), visit("limiter", o.limiter);
  visit("energy_residual", o.energy_residual), visit("volume_drift", o.volume_drift), visit("J_min", o.J_min);
  visit("controlled_fraction", o.controlled_fraction), visit("self_intersections", o.self_intersections), visit("is_finite", o.is_finite);
  visit("pressure_peak_Pa", o.pressure_peak_Pa), visit("annulus_area_mm2", o.annulus_area_mm2), visit("fluid_density", o.fluid_density);
  visit("has_fluid", o.has_fluid), visit("has_chordae", o.has_chordae), visit("peak_velocity_m_s", o.peak_velocity_m_s);
  visit("has_closed", o.has_closed), visit("closing_volume_ml", o.closing_volume_ml), visit("backward_volume_ml", o.backward_volume_ml);
  visit("late_leak_ml_s", o.late_leak_ml_s), visit("papillary_force_N", o.papillary_force_N), visit("chordae_energy_J", o.chordae_energy_J), visit("tissue_volume_mm3", o.tissue_volume_mm3), visit("beat_drift_mm", o.beat_drift_mm);
  visit("beat_volume_ml", o.beat_volume_ml), visit("beat_volume_drift_ml", o.beat_volume_drift_ml);
  visit("beat_scatter_mm", o.beat_scatter_mm), visit("beat_volume_scatter_ml", o.beat_volume_scatter_ml), visit("beats_averaged", o.beats_averaged);
}

}  // namespace

std::string name_of(Verdict verdict) { return verdict_names[static_cast<std::size_t>(verdict)]; }

Judgement judge(const StabilityCase& c, const CaseOutcome& o) {
  Judgement j;
  switch (o.end) {
    case CaseEnd::finished: j = judge_finished(c, o); break;
    case CaseEnd::refused: j = o.reason.empty() ? Judgement{Verdict::unstable, "refused without a reason"} : Judgement{Verdict::refused, o.reason}; break;
    case CaseEnd::stopped: j = {Verdict::unstable, o.reason}; break;
    case CaseEnd::late:
    case CaseEnd::hung: j = {Verdict::hung, o.reason}; break;
    case CaseEnd::crashed: j = {Verdict::crashed, o.reason}; break;
  }
  if (j.verdict == Verdict::stable && c.expected == Expected::refused) return {Verdict::unexpected, "ran to its end, but had to be refused"};
  if (j.verdict == Verdict::refused && c.expected == Expected::stable) return {Verdict::unexpected, "refused, but had to run: " + j.reason};
  return j;
}

Json to_json(const CaseOutcome& o) {
  Json json;
  json["end"] = end_names[static_cast<std::size_t>(o.end)];
  visit_fields(o, [&](const char* name, const auto& value) { json[name] = value; });
  return json;
}

CaseOutcome outcome_from_json(const Json& json) {
  CaseOutcome o;
  try {
    const std::string end = json.at("end").get<std::string>();
    std::size_t index = 0;
    while (index < end_names.size() && end != end_names[index]) ++index;
    if (index == end_names.size()) throw InputError("outcome of a stability case: unknown end '" + end + "'");
    o.end = static_cast<CaseEnd>(index);
    visit_fields(o, [&](const char* name, auto& value) {
      using T = std::decay_t<decltype(value)>;
      const Json& stored = json.at(name);
      if constexpr (std::is_same_v<T, double>)
        value = stored.is_null() ? std::nan("") : stored.get<double>();   // JSON has no NaN
      else
        value = stored.get<T>();
    });
  } catch (const Json::exception& error) {
    throw InputError(fmt::format("outcome of a stability case: {}", error.what()));
  }
  return o;
}

}  // namespace mv
