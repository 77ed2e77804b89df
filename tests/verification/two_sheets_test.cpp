// SPDX-License-Identifier: BSD-3-Clause
// Two sheets pressed together by p = 16 kPa, dry and in blood (two_sheets_model.h). Reference: the contact carries p.
//   ctest -L verification -V                                                                           the short cases
//   build/tests/verification_two_sheets --gtest_also_run_disabled_tests --gtest_filter='*table*'        three spacings, kernels
//   (seven minutes)
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "verification/two_sheets_model.h"

namespace mv::test {
namespace {

constexpr double blood_step_per_h = 0.02;  // s/m: 20 us at h = 1 mm
constexpr double dry_step_per_h = 0.01,
                 dry_step = 1e-5;               // s/m and s: the tissue's own critical step; elements are at most 1 mm / 2 thick
constexpr double end = 30e-3, dry_end = 40e-3;  // s, six times the ramp and more

void print(const char* name, const TwoSheetsSpec& s, const BeltMeans& b) {
  std::printf(
      "%-34s h %.1f mm: penalty/p %.4f (%.3f .. %.3f) reference 1 difference %+.4f; gap/h %.4f; p_mid/p %.4f; p_c,grid/p %+.4f; "
      "sum/p %.4f (%.3f .. %.3f)\n",
      name, 1e3 * s.h, b.penalty / s.pressure, b.penalty_min / s.pressure, b.penalty_max / s.pressure, b.penalty / s.pressure - 1,
      b.gap / s.h, b.film / s.pressure, b.contact_on_grid / s.pressure, b.sum() / s.pressure, b.sum_min / s.pressure,
      b.sum_max / s.pressure);
  std::fflush(stdout);
}

BeltMeans dry(const TwoSheetsSpec& s) {
  const BeltMeans b = press_dry(s, std::min(dry_step, dry_step_per_h * s.h), dry_end);
  print("dry", s, b);
  return b;
}
BeltMeans in_blood(const char* name, const TwoSheetsSpec& s, double step_factor = 1) {
  const BeltMeans b = press_in_blood(s, step_factor * blood_step_per_h * s.h, end);
  print(name, s, b);
  return b;
}
TwoSheetsSpec with(Relaxation relaxation, TwoSheetsSpec s = {}) {
  s.relaxation = relaxation;
  return s;
}
TwoSheetsSpec interpolated(TwoSheetsSpec s = {}) {
  s.is_drained = false;
  return with(Relaxation::none, s);
}

class TwoSheetsTest : public ::testing::Test {
  OneThread one_thread_;
};

TEST_F(TwoSheetsTest, dry_contact_carries_the_pressure) {
  const TwoSheetsSpec s;
  const BeltMeans b = dry(s);
  EXPECT_NEAR(b.penalty, s.pressure, 0.02 * s.pressure);
  EXPECT_LT(b.gap, 0.2 * s.h);
}

// What the drainage is for: with interpolation alone the faces stay where they were and the film carries all.
TEST_F(TwoSheetsTest, interpolation_leaves_the_pressure_to_the_film) {
  const TwoSheetsSpec s = interpolated();
  const BeltMeans b = in_blood("interpolation", s);
  EXPECT_EQ(b.penalty, 0.0);
  EXPECT_GT(b.gap, 0.95 * s.h);
  EXPECT_NEAR(b.sum(), s.pressure, 0.02 * s.pressure);
}

TEST_F(TwoSheetsTest, drained_film_leaves_the_pressure_to_the_contact) {
  const TwoSheetsSpec s = with(Relaxation::none);
  const BeltMeans b = in_blood("drained", s);
  EXPECT_NEAR(b.penalty, s.pressure, 0.05 * s.pressure);
  EXPECT_LT(b.gap, 0.2 * s.h);
  // Without relaxation the tissue is distorted below the kernel's width, and its stresses show halfway: 5.5 % measured.
  EXPECT_NEAR(b.sum(), s.pressure, 0.08 * s.pressure);
}

// As Simulation::advance does it. Wanted: contact carries the pressure within 5 %, faces closer than 0.2 h.
TEST_F(TwoSheetsTest, drained_and_relaxed_sheets_report_the_applied_pressure_node_by_node) {
  const TwoSheetsSpec s = with(Relaxation::all_forces);
  const BeltMeans b = in_blood("drained, relaxed", s);
  EXPECT_NEAR(b.penalty, s.pressure, 0.02 * s.pressure);
  EXPECT_GT(b.penalty_min, 0.95 * s.pressure);
  EXPECT_LT(b.penalty_max, 1.05 * s.pressure);
  EXPECT_LT(b.gap, 0.2 * s.h);
  EXPECT_NEAR(b.sum(), s.pressure, 0.05 * s.pressure);
}

TEST_F(TwoSheetsTest, equilibrium_does_not_depend_on_step_or_drainage_time) {
  TwoSheetsSpec s = with(Relaxation::all_forces);
  const BeltMeans half = in_blood("drained, relaxed, half step", s, 0.5);
  EXPECT_NEAR(half.penalty, s.pressure, 0.02 * s.pressure);
  s.drainage_time = 2.5e-3;
  const BeltMeans fast = in_blood("drained twice as fast, relaxed", s);
  EXPECT_NEAR(fast.penalty, s.pressure, 0.02 * s.pressure);
}

TEST_F(TwoSheetsTest, DISABLED_table) {
  for (const double h : {2e-3, 1e-3, 0.5e-3}) {
    TwoSheetsSpec s;
    s.h = h;
    dry(s);
    in_blood("interpolation", interpolated(s));
    in_blood("drained", with(Relaxation::none, s));
    for (const double step_factor : {1.0, 0.5}) {
      in_blood(step_factor < 1 ? "drained, relaxed, half step" : "drained, relaxed", with(Relaxation::all_forces, s),
               step_factor);
    }
  }
}

// Narrower kernels move less blood with a node: half the step.
TEST_F(TwoSheetsTest, DISABLED_table_of_kernels) {
  for (const Kernel kernel : {Kernel::ib3, Kernel::cbs32}) {
    TwoSheetsSpec s = with(Relaxation::all_forces);
    s.kernel = kernel;
    in_blood(kernel == Kernel::ib3 ? "ib3: drained, relaxed" : "cbs32: drained, relaxed", s, 0.5);
  }
}

}  // namespace
}  // namespace mv::test
