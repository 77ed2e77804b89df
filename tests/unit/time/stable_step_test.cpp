// SPDX-License-Identifier: BSD-3-Clause
// The estimate of the stiffest mode against a power iteration that had all the time it wants.
#include "solver/time/stable_step.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "solver/study/sheet.h"
#include "solver/time/simulation.h"

namespace mv {
namespace {

double norm_of(const std::vector<double>& v) { return std::sqrt(std::inner_product(v.begin(), v.end(), v.begin(), 0.0)); }

/// rad/s, by 3000 products.
double frequency_by_force(Structure& structure, const std::vector<double>& x) {
  std::vector<double> mode(x.size()), stiff(x.size());
  for (std::size_t a = 0; a < mode.size(); ++a) mode[a] = structure.is_fixed()[a / 3] ? 0.0 : std::cos(3.7 * static_cast<double>(a * a % 1009));
  std::array<double, 3> shares{};
  structure.begin_products(x);
  double growth = 0;
  for (int n = 0; n < 3000; ++n) {
    const double norm = norm_of(mode);
    for (double& v : mode) v /= norm;
    structure.stiffness_times(mode, stiff, shares);
    for (std::size_t a = 0; a < mode.size(); ++a) mode[a] = structure.is_fixed()[a / 3] ? 0.0 : stiff[a] / structure.masses()[a / 3];
    growth = norm_of(mode);
  }
  return std::sqrt(growth);
}

Scene soft_sheet() {
  SheetShape shape;
  shape.solid_mm = 2;
  return sheet_scene(shape, {"fluid.enabled=false", "leaflet.anterior.neo_mu=30 kPa", "leaflet.bulk=2 MPa", "structure.settling_time=0 ms"});
}

TEST(StableStep, finds_the_stiffest_mode_from_nothing_and_follows_it_when_it_moves_elsewhere) {
  Simulation simulation(soft_sheet());
  State state = simulation.initial_state();
  Structure& structure = simulation.structure();
  StableStep estimate(nullptr);
  estimate.update(state, structure, nullptr, nullptr, 3);
  const double at_rest = frequency_by_force(structure, state.x);
  std::printf("at rest: %.5g of %.5g rad/s\n", state.frequency, at_rest);
  EXPECT_NEAR(state.frequency, at_rest, 0.03 * at_rest);
  EXPECT_LE(state.frequency, 1.0001 * at_rest);   // a Rayleigh quotient never exceeds it
  EXPECT_EQ(state.stiffest_part, "tissue");

  // One corner of the sheet is squeezed: the stiffest mode is there now, and the last one does not know it.
  for (std::size_t i = 0; i < state.x.size() / 3; ++i) {
    const double depth = std::max(0.0, state.x[3 * i] - 6e-3) * std::max(0.0, state.x[3 * i + 1] - 5e-3);
    if (!structure.is_fixed()[i]) state.x[3 * i] -= 60.0 * depth;
  }
  estimate.update(state, structure, nullptr, nullptr, 3);
  const double squeezed = frequency_by_force(structure, state.x);
  std::printf("squeezed: %.5g of %.5g rad/s\n", state.frequency, squeezed);
  EXPECT_GT(squeezed, 1.04 * at_rest);
  EXPECT_NEAR(state.frequency, squeezed, 0.05 * squeezed);
}

TEST(StableStep, nothing_is_estimated_when_nothing_can_move) {
  Scene scene = soft_sheet();
  std::fill(scene.mesh.on_annulus.begin(), scene.mesh.on_annulus.end(), 1);
  Simulation simulation(std::move(scene));
  State state = simulation.initial_state();
  StableStep estimate(nullptr);
  estimate.update(state, simulation.structure(), nullptr, nullptr, 3);
  EXPECT_FALSE(state.frequency > 0);
}

}  // namespace
}  // namespace mv
