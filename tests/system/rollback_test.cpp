// SPDX-License-Identifier: BSD-3-Clause
// Step-halving and rollback, made to happen: by a spoiled state, and by a step that is truly unstable.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "geometry/core/errors.h"
#include "geometry/core/log.h"
#include "solver/study/case_maker.h"
#include "solver/time/simulation.h"

namespace {

namespace fs = std::filesystem;

constexpr double end = 0.02;   // s; the leaflets are in full motion

struct Rollback : testing::Test {
  fs::path directory = fs::temp_directory_path() / ("mv_rollback_" + std::to_string(::getpid()));
  std::optional<mv::Simulation> simulation;
  mv::State state;

  Rollback() {
    const mv::MadeCase made = mv::CaseMaker(directory, fs::path(MV_BIN_DIR) / "mvprep").make("coarse", "[mesh]\nspacing = \"2 mm\"\n[tube]\nspacing = \"4 mm\"\n");
    EXPECT_TRUE(made.is_made()) << made.error;
    simulation.emplace(mv::load_scene(made.directory, {"pressure.rise_time=15 ms", "time.step_max=10 ms"}));
    state = simulation->initial_state();
  }
  ~Rollback() override { fs::remove_all(directory); }

  void advance_to(double time) {
    while (state.time < time - 1e-12) simulation->step(state, end);
  }

  std::size_t moving_node() const {
    std::size_t node = 0;
    while (simulation->structure().is_fixed()[node]) ++node;
    return node;
  }
};

TEST_F(Rollback, a_spoiled_step_is_halved_the_state_restored_and_the_run_goes_on) {
  mv::Scene scene = simulation->scene();
  scene.config.set("time.step_max=50 us");
  simulation.emplace(std::move(scene));
  state = simulation->initial_state();
  advance_to(end);
  const double volume = state.volume_backward, steps = static_cast<double>(state.step);

  state = simulation->initial_state();
  advance_to(0.47 * end);
  ASSERT_EQ(state.rollbacks, 0);
  ASSERT_NE(state.step % 200, 0);   // at a multiple the spoiled state itself would be kept to fall back to
  const mv::State good = *simulation->snapshot();
  const double dt = state.dt;
  state.x[3 * moving_node()] = std::nan("");
  EXPECT_EQ(simulation->step(state, end), "retry");
  EXPECT_EQ(state.rollbacks, 1);
  EXPECT_EQ(state.rollbacks_in_a_row, 1);
  EXPECT_EQ(state.time, good.time);
  EXPECT_EQ(state.step, good.step);
  EXPECT_EQ(state.x, good.x);
  EXPECT_EQ(state.v, good.v);
  EXPECT_EQ(state.flow.velocity.c[2], good.flow.velocity.c[2]);
  EXPECT_EQ(state.flow.pressure, good.flow.pressure);
  EXPECT_EQ(state.ledger.work_pressure, good.ledger.work_pressure);
  EXPECT_LE(state.dt_cap, 0.5 * 1.1 * dt + 1e-15);   // a step may grow by a tenth
  const double cap = state.dt_cap;
  simulation->step(state, end);
  EXPECT_EQ(state.rollbacks, 1);
  EXPECT_LE(state.dt, cap * (1 + 1e-12));
  advance_to(end);
  EXPECT_EQ(state.rollbacks, 1);
  EXPECT_GT(static_cast<double>(state.step), 1.3 * steps);
  std::printf("backward volume: undisturbed %.4f ml, with one rollback %.4f ml\n", 1e6 * volume, 1e6 * state.volume_backward);
  EXPECT_NEAR(state.volume_backward, volume, 0.01 * volume);
}

TEST_F(Rollback, a_step_beyond_the_stable_one_is_halved_until_the_run_is_stable) {
  advance_to(end);
  const double volume = state.volume_backward;
  state = simulation->initial_state();
  advance_to(0.25 * end);
  // From here on, until that has failed twice, the solver takes the valve for infinitely soft and forgets how fast nodes and blood are: steps grow beyond the stable one.
  while (state.time < end - 1e-12) {
    simulation->step(state, end);
    if (state.rollbacks >= 2) continue;
    state.frequency = 0;
    state.dt = 0, state.fastest = 0, state.flow_step = 1;
  }
  std::printf("%ld rollbacks; backward volume: undisturbed %.4f ml, halved %.4f ml\n", state.rollbacks, 1e6 * volume, 1e6 * state.volume_backward);
  EXPECT_GE(state.rollbacks, 2);
  EXPECT_LE(state.rollbacks_in_a_row, 8);
  EXPECT_TRUE(std::isfinite(state.volume_backward));
  EXPECT_LT(simulation->energy_residual(state), 0.05);
  EXPECT_NEAR(state.volume_backward, volume, 0.05 * volume);
}

TEST_F(Rollback, after_eight_halvings_the_run_stops_with_the_reason) {
  advance_to(0.25 * end);
  const double dt = state.dt;
  double cap = 1e300;
  for (int attempt = 1; attempt <= 8; ++attempt) {
    state.x[3 * moving_node()] += 1.0;   // a metre: outside the box
    EXPECT_EQ(simulation->step(state, end), "retry");
    EXPECT_EQ(state.rollbacks_in_a_row, attempt);
    EXPECT_LT(state.dt_cap, 0.51 * cap);
    cap = state.dt_cap;
  }
  EXPECT_LE(cap, 1.1 * dt / 256);
  state.x[3 * moving_node()] += 1.0;
  try {
    simulation->step(state, end);
    FAIL() << "went on";
  } catch (const mv::TrustError& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find("8 smaller steps"), std::string::npos) << what;
    EXPECT_NE(what.find("left the fluid box"), std::string::npos) << what;
  }
}

TEST_F(Rollback, a_fixed_step_beyond_the_stable_one_is_reduced) {
  mv::Scene scene = simulation->scene();
  scene.config.set("time.step_fixed=10 ms");
  simulation.emplace(std::move(scene));
  state = simulation->initial_state();
  std::string limiter;
  testing::internal::CaptureStderr();
  mv::set_up_log(mv::LogLevel::quiet);
  for (int i = 0; i < 3; ++i) limiter = simulation->step(state, end);
  spdlog::default_logger()->flush();
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_NE(log.find("time.step_fixed"), std::string::npos) << log;
  EXPECT_EQ(log.find("time.step_fixed"), log.rfind("time.step_fixed")) << "said more than once";
  EXPECT_LE(state.dt, (1 + 1e-9) * 0.8 * 2.0 / state.frequency);
  EXPECT_EQ(limiter, state.stiffest_part);
}

TEST_F(Rollback, work_of_moved_tips_and_cut_chordae_is_in_the_budget) {
  mv::Scene scene = simulation->scene();
  for (const char* setting : {"pressure.peak=0 mmHg", "time.step_max=50 us", "papillary.displacement=[0 mm, 0 mm, -10 mm]", "papillary.move_start=1 ms", "papillary.move_time=2 ms", "chordae.cut=[0, 1, 2]",
                              "chordae.cut_time=5 ms"})
    scene.config.set(setting);
  simulation.emplace(std::move(scene));
  state = simulation->initial_state();
  advance_to(0.004);
  const double stored = state.chordae_energy, moved = state.ledger.work_moved;
  EXPECT_GT(moved, 1e-4);
  EXPECT_GT(moved, stored);   // the rest moves leaflets and blood
  advance_to(0.01);
  EXPECT_LT(state.ledger.work_moved, moved);   // what the cut chordae held is gone
  const double residual = simulation->energy_residual(state);
  std::printf("work of the tips %.4g J, set free by the cut %.4g J, residual %.3g\n", moved, moved - state.ledger.work_moved, residual);
  EXPECT_LT(residual, 0.05);
}

}  // namespace
