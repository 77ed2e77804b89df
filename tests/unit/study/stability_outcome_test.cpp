// SPDX-License-Identifier: BSD-3-Clause
// The table of the stability study, and its verdicts: each must be able to fail.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "geometry/core/errors.h"
#include "solver/study/stability.h"

namespace {

using mv::CaseEnd;
using mv::Verdict;

mv::StabilityCase closing_case() {
  mv::StabilityCase c;
  c.name = "closing";
  c.axis = "laws";
  c.end = 0.05;
  return c;
}

/// What a sound closure reports.
mv::CaseOutcome closed() {
  mv::CaseOutcome o;
  o.end = CaseEnd::finished;
  o.simulated_s = 0.05, o.steps = 500, o.dt_mean_s = 1e-4, o.dt_min_s = 5e-5, o.limiter = "tissue";
  o.energy_residual = 0.002, o.pressure_peak_Pa = 16000, o.annulus_area_mm2 = 900, o.has_fluid = true, o.has_chordae = true;
  o.peak_velocity_m_s = 5, o.has_closed = true, o.closing_volume_ml = 9, o.late_leak_ml_s = -10, o.papillary_force_N = 5.4;
  return o;
}

Verdict verdict_of(const mv::StabilityCase& c, const mv::CaseOutcome& o) { return mv::judge(c, o).verdict; }

TEST(StabilityTable, holds_sixty_cases_and_every_axis) {
  const auto cases = mv::stability_cases();
  EXPECT_GE(cases.size(), 60u);
  std::set<std::string> names, axes;
  long refused = 0;
  for (const auto& c : cases) {
    EXPECT_TRUE(names.insert(c.name).second) << c.name << " stands twice";
    EXPECT_EQ(c.name.find_first_of("/ ,\""), std::string::npos) << c.name;
    EXPECT_GT(c.end, 0) << c.name;
    axes.insert(c.axis);
    refused += c.expected == mv::Expected::refused;
  }
  EXPECT_EQ(axes, std::set<std::string>(mv::stability_axes().begin(), mv::stability_axes().end()));
  EXPECT_GE(static_cast<long>(cases.size()) - refused, 60);
  EXPECT_GE(refused, 10);
}

TEST(StabilityTable, every_geometry_is_a_valid_configuration) {
  for (const auto& c : mv::stability_cases()) EXPECT_NO_THROW(mv::Config::from_string(mv::geometry_toml(c), c.name)) << c.name;
}

TEST(StabilityTable, is_selected_by_name_or_axis) {
  const auto cases = mv::stability_cases();
  EXPECT_EQ(mv::select_cases(cases, "").size(), cases.size());
  for (const auto& c : mv::select_cases(cases, "friction")) EXPECT_TRUE(c.name.find("friction") != std::string::npos || c.axis == "friction");
  EXPECT_THROW(mv::select_cases(cases, "no such case"), mv::UsageError);
}

TEST(StabilityVerdict, a_sound_closure_is_stable) { EXPECT_EQ(verdict_of(closing_case(), closed()), Verdict::stable) << mv::judge(closing_case(), closed()).reason; }

TEST(StabilityVerdict, what_hardly_leaks_is_closed_though_its_flow_never_turned) {
  mv::CaseOutcome o = closed();
  o.has_closed = false, o.closing_volume_ml = 0, o.backward_volume_ml = 9, o.late_leak_ml_s = 10;
  EXPECT_EQ(verdict_of(closing_case(), o), Verdict::stable) << mv::judge(closing_case(), o).reason;
}

TEST(StabilityVerdict, whatever_is_wrong_makes_a_case_unstable_with_a_reason) {
  using Change = std::function<void(mv::CaseOutcome&)>;
  const std::vector<std::pair<const char*, Change>> changes{
      {"not finite", [](auto& o) { o.is_finite = false; }},
      {"ended early", [](auto& o) { o.simulated_s = 0.04; }},
      {"stopped", [](auto& o) { o.end = CaseEnd::stopped, o.reason = "the run cannot go on"; }},
      {"energy", [](auto& o) { o.energy_residual = 0.051; }},
      {"energy is no number", [](auto& o) { o.energy_residual = std::nan(""); }},
      {"volume", [](auto& o) { o.volume_drift = -0.041; }},
      {"crossings", [](auto& o) { o.self_intersections = 1; }},
      {"too fast", [](auto& o) { o.peak_velocity_m_s = 12; }},
      {"not closed", [](auto& o) { o.has_closed = false, o.backward_volume_ml = 9, o.late_leak_ml_s = 200; }},
      {"never moved", [](auto& o) { o.has_closed = false, o.backward_volume_ml = 0.1; }},
      {"closing volume", [](auto& o) { o.closing_volume_ml = 40; }},
      {"no closing volume", [](auto& o) { o.closing_volume_ml = std::nan(""); }},
      {"leak", [](auto& o) { o.late_leak_ml_s = 200; }},
      {"chordae carry nothing", [](auto& o) { o.papillary_force_N = 0; }},
      {"chordae carry too much", [](auto& o) { o.papillary_force_N = 50; }},
      {"refused without a reason", [](auto& o) { o.end = CaseEnd::refused; }},
  };
  for (const auto& [name, change] : changes) {
    mv::CaseOutcome o = closed();
    change(o);
    const mv::Judgement j = mv::judge(closing_case(), o);
    EXPECT_EQ(j.verdict, Verdict::unstable) << name;
    EXPECT_FALSE(j.reason.empty()) << name;
    EXPECT_TRUE(mv::is_bad(j.verdict));
  }
}

TEST(StabilityVerdict, ends_are_told_apart) {
  mv::StabilityCase c = closing_case();
  mv::CaseOutcome o = closed();
  o.reason = "why";
  o.end = CaseEnd::crashed;
  EXPECT_EQ(verdict_of(c, o), Verdict::crashed);
  o.end = CaseEnd::hung;
  EXPECT_EQ(verdict_of(c, o), Verdict::hung);
  o.end = CaseEnd::late;
  EXPECT_EQ(verdict_of(c, o), Verdict::hung);
  o.end = CaseEnd::refused;
  EXPECT_EQ(verdict_of(c, o), Verdict::unexpected);   // it had to run
  c.expected = mv::Expected::refused;
  EXPECT_EQ(verdict_of(c, o), Verdict::refused);
  o.end = CaseEnd::finished;
  EXPECT_EQ(verdict_of(c, o), Verdict::unexpected);   // it had to be refused
}

TEST(StabilityVerdict, each_behaviour_has_its_physics) {
  mv::StabilityCase c = closing_case();
  mv::CaseOutcome o = closed();
  c.behaviour = mv::Behaviour::opens;
  o.backward_volume_ml = 3;
  EXPECT_EQ(verdict_of(c, o), Verdict::unstable);
  o.backward_volume_ml = -3;
  EXPECT_EQ(verdict_of(c, o), Verdict::stable);
  c.behaviour = mv::Behaviour::prolapses;
  o.late_leak_ml_s = 5;
  EXPECT_EQ(verdict_of(c, o), Verdict::unstable);
  o.late_leak_ml_s = 2000;
  EXPECT_EQ(verdict_of(c, o), Verdict::stable);
  c.behaviour = mv::Behaviour::beats;
  o.beat_volume_ml = 8;
  EXPECT_EQ(verdict_of(c, o), Verdict::stable);
  o.beat_volume_drift_ml = 1;
  EXPECT_EQ(verdict_of(c, o), Verdict::unstable);
  o.beat_volume_drift_ml = 0;
  o.beat_drift_mm = 0.6;
  EXPECT_EQ(verdict_of(c, o), Verdict::unstable);
  // Two means of ten beats that differ by 1 mm each differ by 0.45 mm by chance; twice that is allowed on top.
  o.beats_averaged = 10;
  o.beat_scatter_mm = 1;
  o.beat_drift_mm = 1.38;
  EXPECT_EQ(verdict_of(c, o), Verdict::stable);
  o.beat_drift_mm = 1.42;
  EXPECT_EQ(verdict_of(c, o), Verdict::unstable);
}

TEST(StabilityOutcome, chordae_that_were_torn_may_hurl_the_leaflets_and_no_more) {
  mv::StabilityCase c;
  c.behaviour = mv::Behaviour::rests;
  mv::CaseOutcome o = closed();
  o.chordae_energy_J = 0.5, o.tissue_volume_mm3 = 1500;   // 17.7 m/s; the jet of 120 mmHg has 5.5 m/s
  o.peak_velocity_m_s = 36;
  EXPECT_EQ(verdict_of(c, o), Verdict::stable);
  o.peak_velocity_m_s = 38;
  EXPECT_EQ(verdict_of(c, o), Verdict::unstable);
}

TEST(StabilityOutcome, survives_its_file) {
  mv::CaseOutcome o = closed();
  o.energy_residual = std::nan("");
  const mv::CaseOutcome back = mv::outcome_from_json(mv::Json::parse(mv::to_json(o).dump()));
  EXPECT_EQ(back.end, o.end);
  EXPECT_TRUE(std::isnan(back.energy_residual));
  EXPECT_EQ(back.papillary_force_N, o.papillary_force_N);
  EXPECT_EQ(back.limiter, o.limiter);
  EXPECT_THROW(mv::outcome_from_json(mv::Json::parse("{\"end\": \"fine\"}")), mv::InputError);
  EXPECT_THROW(mv::outcome_from_json(mv::Json::parse("{}")), mv::InputError);
}

}  // namespace
