// SPDX-License-Identifier: BSD-3-Clause
// FSI1 (steady) and FSI3 (oscillating) of Turek & Hron 2006; setting and differences of model in turek_hron.h. Reference of FSI3:
// Featflow, level 4; other codes spread by the tolerances given with it (solids4foam, verification notes).
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>

#include "verification/fsi/turek_hron.h"

namespace mv::test {
namespace {

constexpr double mm = 1e-3;
// Reference: mm, N/m.
constexpr double fsi1_ux = 0.0227, fsi1_uy = 0.8209, fsi1_drag = 14.295, fsi1_lift = 0.7638;

struct Oscillation {
  double mean = 0, amplitude = 0, hz = 0;
};
// mm, N/m; the lift's and the drag's frequencies are those of uy and ux.
constexpr Oscillation fsi3_ux{-2.88, 2.72, 10.93}, fsi3_uy{1.47, 34.99, 5.46}, fsi3_drag{460.5, 27.74, 10.93}, fsi3_lift{2.50, 153.91, 5.46};

const char* name_of(PlateModulus modulus) { return modulus == PlateModulus::given ? "printed mu" : "mu of the same bending stiffness"; }

const char* name_of(Kernel kernel) { return kernel == Kernel::ib4 ? "ib4" : kernel == Kernel::ib3 ? "ib3" : "cbs32"; }

/// Runs to `end` (s), where the flow is steady, and prints. The last sample is returned.
TurekHronSample run_fsi1(const TurekHronSpec& spec, double end) {
  const OneThread one_thread;
  TurekHron run(spec);
  const auto start = std::chrono::steady_clock::now();
  TurekHronSample before, last;
  while (last.time < end - spec.dt) {
    before = last;
    last = run.advance(0.05 * end);
  }
  const SolidStatistics& solid = run.flow().statistics();
  std::printf("FSI1, %s, %d cells across, nodes %.1f by %.1f cells apart, %s, %s: uy still changes by %.2e mm/s, J %.5f .. %.5f, swelling %.2e (%.0f s)\n", name_of(spec.kernel), spec.cells,
              spec.spacing_across, spec.spacing_along, name_of(spec.modulus), spec.relaxation == Relaxation::none ? "no relaxation" : "relaxed", (last.uy - before.uy) / (mm * (last.time - before.time)),
              solid.J_min, solid.J_max, run.swelling(),
              std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  print_comparison("ux mm", last.ux / mm, fsi1_ux);
  print_comparison("uy mm", last.uy / mm, fsi1_uy);
  print_comparison("drag N/m", last.drag, fsi1_drag);
  print_comparison("lift N/m", last.lift, fsi1_lift);
  return last;
}

/// Mean and amplitude as half sum and half difference of the extremes, frequency from upward crossings of the mean.
Oscillation analyse(const std::vector<TurekHronSample>& samples, const std::function<double(const TurekHronSample&)>& value) {
  double low = 1e300, high = -1e300;
  for (const TurekHronSample& s : samples) {
    low = std::min(low, value(s));
    high = std::max(high, value(s));
  }
  Oscillation result{0.5 * (low + high), 0.5 * (high - low), 0};
  double first = 0, last = 0;
  int crossings = 0;
  for (std::size_t q = 1; q < samples.size(); ++q) {
    const double a = value(samples[q - 1]) - result.mean, b = value(samples[q]) - result.mean;
    if (a >= 0 || b < 0) continue;
    last = samples[q - 1].time + (samples[q].time - samples[q - 1].time) * a / (a - b);
    if (crossings++ == 0) first = last;
  }
  if (crossings > 1) result.hz = (crossings - 1) / (last - first);
  return result;
}

/// Mean in time and amplitude of the part that swings with `hz`, over the last whole periods: what extremes of a noisy signal do not show.
Oscillation component(const std::vector<TurekHronSample>& samples, const std::function<double(const TurekHronSample&)>& value, double hz) {
  const double end = samples.back().time, start = end - std::floor((end - samples.front().time) * hz) / hz;
  double sum = 0, cosine = 0, sine = 0;
  int count = 0;
  for (const TurekHronSample& s : samples) {
    if (s.time <= start) continue;
    sum += value(s);
    cosine += value(s) * std::cos(2 * M_PI * hz * s.time);
    sine += value(s) * std::sin(2 * M_PI * hz * s.time);
    ++count;
  }
  return {sum / count, 2 * std::hypot(cosine, sine) / count, hz};
}

void print_oscillation(const char* what, const Oscillation& computed, const Oscillation& reference) {
  std::printf("%s\n", what);
  print_comparison("mean", computed.mean, reference.mean);
  print_comparison("amplitude", computed.amplitude, reference.amplitude);
  if (computed.hz > 0) print_comparison("frequency Hz", computed.hz, reference.hz);
}

struct Fsi3Result {
  Oscillation ux, uy, drag, lift;
};

Fsi3Result run_fsi3(const TurekHronSpec& spec, double end) {
  const OneThread one_thread;
  TurekHron run(spec);
  constexpr double interval = 1.5e-3, last_part = 1.0;  // s
  const auto start = std::chrono::steady_clock::now();
  std::vector<TurekHronSample> samples;
  constexpr double report_every = 0.5;  // s
  double low = 1e300, high = -1e300, next_report = report_every;
  for (double time = 0; time < end;) {
    const TurekHronSample sample = run.advance(interval);
    time = sample.time;
    if (time > end - last_part) samples.push_back(sample);
    low = std::min(low, sample.uy);
    high = std::max(high, sample.uy);
    if (time < next_report) continue;
    std::printf("  %.1f s: uy %.2f .. %.2f mm, drag %.1f N/m\n", time, low / mm, high / mm, sample.drag);
    std::fflush(stdout);
    next_report += report_every;
    low = 1e300;
    high = -1e300;
  }
  std::printf("FSI3, %s, %d cells across, nodes %.1f by %.1f cells apart, %s, %s, last %.1f s of %.1f s (%.0f s)\n", name_of(spec.kernel), spec.cells, spec.spacing_across,
              spec.spacing_along, name_of(spec.modulus), spec.relaxation == Relaxation::none ? "no relaxation" : "relaxed", last_part, end,
              std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  Fsi3Result result;
  result.ux = analyse(samples, [](const TurekHronSample& s) { return s.ux / mm; });
  result.uy = analyse(samples, [](const TurekHronSample& s) { return s.uy / mm; });
  result.drag = analyse(samples, [](const TurekHronSample& s) { return s.drag; });
  result.lift = analyse(samples, [](const TurekHronSample& s) { return s.lift; });
  print_oscillation("ux mm", result.ux, fsi3_ux);
  print_oscillation("uy mm", result.uy, fsi3_uy);
  print_oscillation("drag N/m", {result.drag.mean, result.drag.amplitude, 0}, fsi3_drag);
  print_oscillation("drag N/m, mean in time and part at the frequency of ux", component(samples, [](const TurekHronSample& s) { return s.drag; }, result.ux.hz), fsi3_drag);
  print_oscillation("lift N/m", {result.lift.mean, result.lift.amplitude, 0}, fsi3_lift);
  std::fflush(stdout);
  return result;
}

// The plate's surface is as wide as the kernel: drag is first order, and 7 % too large with the plate two cells thick (the cylinder alone is 0.9 % too large at ten cells,
// cylinder_test.cpp). The plate still swings at 2.7 s.
TEST(TurekHron, coarse_fsi1_drag_is_within_what_first_order_leaves) {
  const TurekHronSample s = run_fsi1({.cells = 41, .dt = 3e-4}, 2.7);
  EXPECT_NEAR(s.drag, fsi1_drag, 0.09 * fsi1_drag);
  EXPECT_LT(std::abs(s.uy), 1.5 * fsi1_uy * mm);
}

TEST(TurekHron, DISABLED_fsi1_coarse_variants) {
  constexpr PlateModulus matched = PlateModulus::matched;
  run_fsi1({.cells = 41, .modulus = matched, .kernel = Kernel::ib4, .dt = 2.5e-4}, 5.0);
  run_fsi1({.cells = 41, .kernel = Kernel::ib4, .dt = 2.5e-4}, 5.0);
  run_fsi1({.cells = 41, .modulus = matched, .dt = 2.5e-4}, 5.0);
  run_fsi1({.cells = 41, .modulus = matched, .kernel = Kernel::ib4, .relaxation = Relaxation::none, .dt = 2.5e-4}, 5.0);
}

// Tolerances: what first order leaves at the finer grid is 2 % of drag and 4 % of uy; ux and the lift are 23 and 22 % off there.
TEST(TurekHron, DISABLED_fsi1) {
  const TurekHronSample coarse = run_fsi1({.cells = 41, .dt = 2.5e-4}, 12.0);
  const TurekHronSample fine = run_fsi1({.cells = 82, .dt = 1.2e-4}, 12.0);
  EXPECT_NEAR(fine.uy, fsi1_uy * mm, 0.05 * fsi1_uy * mm);
  EXPECT_NEAR(fine.drag, fsi1_drag, 0.03 * fsi1_drag);
  EXPECT_NEAR(fine.ux, fsi1_ux * mm, 0.3 * fsi1_ux * mm);
  EXPECT_NEAR(fine.lift, fsi1_lift, 0.25 * fsi1_lift);
  EXPECT_LT(std::abs(fine.drag - fsi1_drag), 0.6 * std::abs(coarse.drag - fsi1_drag));
  EXPECT_LT(std::abs(fine.ux - fsi1_ux * mm), 0.8 * std::abs(coarse.ux - fsi1_ux * mm));
}

// The plate's nodes 1 by 1.5 cells apart in place of a half: README.md says what decides between them.
TEST(TurekHron, DISABLED_fsi1_node_spacing) {
  run_fsi1({.cells = 41, .dt = 2.5e-4, .spacing_across = 1.0, .spacing_along = 1.5}, 12.0);
  run_fsi1({.cells = 82, .dt = 1.2e-4, .spacing_across = 1.0, .spacing_along = 1.5}, 12.0);
}

TEST(TurekHron, DISABLED_fsi3_node_spacing) {
  run_fsi3({.cells = 82, .shear_modulus = 2e6, .mean_velocity = 2.0, .dt = 6e-5, .spacing_across = 1.0, .spacing_along = 1.5}, 6.0);  // swings half a second later
}

TEST(TurekHron, DISABLED_fsi3) {
  const Fsi3Result r = run_fsi3({.cells = 82, .shear_modulus = 2e6, .mean_velocity = 2.0, .dt = 6e-5}, 5.0);
  EXPECT_NEAR(r.uy.hz, fsi3_uy.hz, 0.02 * fsi3_uy.hz);
  EXPECT_NEAR(r.ux.hz, fsi3_ux.hz, 0.02 * fsi3_ux.hz);
  EXPECT_NEAR(r.uy.amplitude, fsi3_uy.amplitude, 0.03 * fsi3_uy.amplitude);
  EXPECT_NEAR(r.ux.amplitude, fsi3_ux.amplitude, 0.05 * fsi3_ux.amplitude);
  EXPECT_NEAR(r.ux.mean, fsi3_ux.mean, 0.05 * std::abs(fsi3_ux.mean));
  EXPECT_NEAR(r.drag.mean, fsi3_drag.mean, 0.13 * fsi3_drag.mean);
  EXPECT_NEAR(r.lift.amplitude, fsi3_lift.amplitude, 0.05 * fsi3_lift.amplitude);
}

}  // namespace
}  // namespace mv::test
