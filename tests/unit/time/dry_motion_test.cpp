// SPDX-License-Identifier: BSD-3-Clause
// Scenes without blood: what stands for the blood that is left out.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "solver/study/sheet.h"
#include "solver/time/simulation.h"

namespace mv {
namespace {

constexpr double peak_pressure = 120 * 133.322387415;

/// A sheet that nothing holds, pushed by the pressure on its ventricular face.
Scene free_sheet(const std::vector<std::string>& settings) {
  std::vector<std::string> all{"fluid.enabled=false", "pressure.peak=120 mmHg", "pressure.rise_time=0.01 ms", "leaflet.anterior.neo_mu=300 kPa"};
  all.insert(all.end(), settings.begin(), settings.end());
  SheetShape shape;
  shape.solid_mm = 2;
  Scene scene = sheet_scene(shape, all);
  std::fill(scene.mesh.on_annulus.begin(), scene.mesh.on_annulus.end(), 0);
  return scene;
}

double mean_velocity(const State& state) {
  double sum = 0;
  for (std::size_t n = 0; n < state.v.size() / 3; ++n) sum += state.v[3 * n + 2];
  return 3 * sum / static_cast<double>(state.v.size());
}

struct Pushed {
  double speed = 0, early_speed = 0, residual = 0, mass_factor = 1, rate = 0;
};

Pushed push(const std::vector<std::string>& settings, double seconds) {
  Simulation simulation(free_sheet(settings));
  State state = simulation.initial_state();
  Pushed p;
  while (state.time < 0.5e-3) simulation.step(state, 0.5e-3);
  p.early_speed = mean_velocity(state);
  while (state.time < seconds) simulation.step(state, seconds);
  p.speed = mean_velocity(state);
  p.residual = simulation.energy_residual(state);
  p.mass_factor = simulation.structure().mass_factor();
  p.rate = simulation.structure().damping_rate();
  return p;
}

TEST(DryMotion, free_leaflet_moves_at_the_closing_speed_whatever_its_mass) {
  std::printf("%-34s %10s %10s %10s %12s %10s\n", "", "m/s", "expected", "mass x", "damping 1/s", "residual");
  for (const char* density : {"106 kg/m3", "1060 kg/m3", "10600 kg/m3"})
    for (double speed : {2.0, 0.5}) {
      const Pushed p = push({std::string("leaflet.density=") + density, "structure.closing_speed=" + std::to_string(speed) + " m/s"}, 0.004);
      const double expected = speed * (1 - std::exp(-0.004 * p.rate));
      std::printf("%-34s %10.4f %10.4f %10.3f %12.1f %10.1e\n", density, p.speed, expected, p.mass_factor, p.rate, p.residual);
      EXPECT_NEAR(p.speed, expected, 0.01 * speed);
      EXPECT_LT(p.residual, 0.01);
      EXPECT_GE(p.mass_factor, 1);
    }
}

TEST(DryMotion, mass_grows_until_the_settling_time_and_no_further) {
  // Rate p / (rho t v) of a leaflet of 1 mm and 1060 kg/m3 at 2 m/s.
  const double rate = peak_pressure / (1060 * 1e-3 * 2.0);
  const Pushed scaled = push({"structure.settling_time=0.5 ms"}, 0.001), own = push({"structure.settling_time=0 ms"}, 0.001);
  std::printf("rate of the leaflet's own mass %.1f 1/s (expected %.1f); with a settling time of 0.5 ms %.1f 1/s, mass x %.3f; speed at 0.5 ms %.3f and %.3f m/s\n", own.rate, rate, scaled.rate,
              scaled.mass_factor, own.early_speed, scaled.early_speed);
  EXPECT_EQ(own.mass_factor, 1);
  EXPECT_NEAR(own.rate, rate, 1e-9 * rate);
  EXPECT_NEAR(scaled.rate, 1 / 0.5e-3, 1e-6 / 0.5e-3);
  EXPECT_NEAR(scaled.mass_factor * scaled.rate, rate, 1e-9 * rate);
  // After one settling time 1 - 1/e of the speed is reached.
  EXPECT_NEAR(scaled.early_speed, 2 * (1 - std::exp(-1.0)), 0.03 * 2);
}

TEST(DryMotion, without_pressure_motion_still_comes_to_rest) {
  Scene scene = free_sheet({"pressure.peak=0 mmHg"});
  Simulation simulation(std::move(scene));
  State state = simulation.initial_state();
  for (std::size_t n = 0; n < state.v.size() / 3; ++n) state.v[3 * n + 2] = 1;
  while (state.time < 0.01) simulation.step(state, 0.01);
  std::printf("1 m/s after 10 ms: %.4f m/s (exp(-3) = %.4f)\n", mean_velocity(state), std::exp(-3.0));
  EXPECT_NEAR(mean_velocity(state), std::exp(-3.0), 0.01);
}

}  // namespace
}  // namespace mv
