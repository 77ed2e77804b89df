// SPDX-License-Identifier: BSD-3-Clause
// A valve that is blown open stays inside the tube, and what stops it is in the energy budget.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "solver/coupling/wall_limit.h"
#include "solver/study/case_maker.h"
#include "solver/time/simulation.h"

namespace {

namespace fs = std::filesystem;

TEST(TubeWall, leaflets_blown_open_stop_at_it) {
  const fs::path directory = fs::temp_directory_path() / ("mv_tube_wall_" + std::to_string(::getpid()));
  const mv::MadeCase made = mv::CaseMaker(directory, fs::path(MV_BIN_DIR) / "mvprep").make("coarse", "[mesh]\nspacing = \"2 mm\"\n[tube]\nspacing = \"4 mm\"\n");
  ASSERT_TRUE(made.is_made()) << made.error;
  constexpr double end = 0.06;
  mv::Simulation simulation(mv::load_scene(made.directory, {"pressure.peak=-60 mmHg", "pressure.rise_time=5 ms", "time.step_max=200 us", "time.end=1 s"}));
  fs::remove_all(directory);
  std::vector<Eigen::Vector2d> section;
  for (const auto& p : simulation.scene().tube.cross_section) section.push_back(1e-3 * p);
  const auto leaflets = static_cast<std::size_t>(simulation.structure().leaflet_nodes());
  mv::WallLimit wall(section, std::span<const double>(simulation.structure().rest_positions().data(), 3 * leaflets), std::span<const char>(simulation.structure().is_fixed().data(), leaflets));
  mv::State state = simulation.initial_state();
  double deepest = 0;
  while (state.time < end - 1e-12) {
    simulation.step(state, end);
    std::vector<double> x(state.x.begin(), state.x.begin() + static_cast<std::ptrdiff_t>(3 * leaflets));
    wall.apply(x);
    for (const auto& shift : wall.shifts()) deepest = std::max(deepest, shift.norm());
  }
  std::printf("deepest in the wall %.3g mm, energy residual %.2g\n", 1e3 * deepest, simulation.energy_residual(state));
  EXPECT_LT(deepest, 1e-6);   // m
  EXPECT_LT(simulation.energy_residual(state), 0.05);
}

}  // namespace
