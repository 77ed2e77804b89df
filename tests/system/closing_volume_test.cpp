// SPDX-License-Identifier: BSD-3-Clause
// Blood that stretched chordae stir before the valve closes is no closure.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "solver/study/case_maker.h"
#include "solver/time/simulation.h"

namespace fs = std::filesystem;

TEST(ClosingVolume, what_is_stirred_before_the_valve_closes_does_not_count) {
  const fs::path directory = fs::temp_directory_path() / ("mv_stirred_" + std::to_string(::getpid()));
  const mv::MadeCase made = mv::CaseMaker(directory, fs::path(MV_BIN_DIR) / "mvprep").make("coarse", "[mesh]\nspacing = \"2 mm\"\n[tube]\nspacing = \"4 mm\"\n");
  ASSERT_TRUE(made.is_made()) << made.error;
  mv::Scene scene = mv::load_scene(made.directory, {"pressure.rise_time=300 ms"});
  for (mv::ChordaSegment& s : scene.chordae.segments) s.rest_length *= 0.97;  // they open the valve: blood flows forward
  mv::Simulation simulation(std::move(scene));
  mv::State state = simulation.initial_state();
  for (const double passed_ml : {0.001, 1.0}) {  // backward before the flow turns
    state = simulation.initial_state();
    while (state.time < 0.001) simulation.step(state, 0.001);
    ASSERT_LT(state.flow_rate, 0);
    state.closure_began = true;
    state.volume_at_closure_start = state.volume_backward - 1e-6 * passed_ml;
    state.flow_rate = 1e-9;
    simulation.step(state, 0.002);
    EXPECT_EQ(state.closing_time >= 0, passed_ml > 0.5) << passed_ml;
    EXPECT_EQ(state.closure_began, passed_ml > 0.5) << "the next backward flow begins the closure";
  }
  fs::remove_all(directory);
}
