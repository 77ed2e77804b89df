// SPDX-License-Identifier: BSD-3-Clause
// Two elastic leaflets in a channel with pulsatile inflow (Kamensky et al. 2015, An immersogeometric variational framework for
// fluid-structure interaction, section 4.7): displacement of the upper leaflet's tip at nine times, digitised there from the
// immersogeometric method (first) and from a boundary-fitted one (second); they differ by 1 to 6 %.
// Not in the table, from the same benchmark's public set-ups: leaflets 0.7 cm long at 1.9788 < x < 2 cm, density of the fluid, the
// inflow reached within the first 5 ms.
//
// Differences of model. The reference's leaflets are shells without thickness in the flow, St. Venant-Kirchhoff with nu 0.4. Here
// they are as thick as printed and move with an incompressible flow; the shear modulus E / (4 (1 - nu^2)) gives the printed plane-strain bending
// stiffness. With a cell a thickness the kernel's three or four cells are a tenth of the opening.
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "verification/fsi/channel.h"

namespace mv::test {
namespace {

constexpr double cm = 1e-2;
constexpr std::array<double, 9> times{0.10, 0.25, 0.50, 0.75, 1.00, 1.25, 1.50, 2.00, 2.50};                   // s
constexpr std::array<double, 9> along_first{0.480, 0.581, 0.533, 0.344, 0.476, 0.582, 0.532, 0.476, 0.531};    // cm
constexpr std::array<double, 9> across_first{0.244, 0.406, 0.313, 0.102, 0.224, 0.411, 0.310, 0.226, 0.312};   // cm
constexpr std::array<double, 9> along_second{0.479, 0.576, 0.525, 0.337, 0.473, 0.577, 0.525, 0.471, 0.525};   // cm
constexpr std::array<double, 9> across_second{0.237, 0.394, 0.300, 0.102, 0.220, 0.396, 0.299, 0.222, 0.298};  // cm

constexpr double width = 1.61 * cm, length = 8 * cm, leaflet_length = 0.7 * cm, thickness = 0.0212 * cm, trailing_face = 2.0 * cm;  // m
constexpr double density = 1000, viscosity = 0.01, young = 5.6e4, poisson_ratio = 0.4;                                           // kg/m3, Pa s, Pa
constexpr double rise = 5e-3;  // s

struct ValveSpec {
  int cells = 76;  // across the channel; 76 make a spacing of one thickness
  Kernel kernel = Kernel::ib4;
  Relaxation relaxation = Relaxation::none;
  double dt = 1.5e-5;  // s
  double spacing = 0.5;  // cells, of the leaflets' nodes along them
};

struct Tip {
  double along = 0, across = 0;  // m
};

class Valve {
 public:
  explicit Valve(const ValveSpec& spec) : spec_(spec) {
    SlabSetup setup = channel_setup(width, length, spec.cells, density, viscosity);
    const double h = setup.grid.h;
    setup.kernel = spec.kernel;
    setup.relaxation = spec.relaxation;
    setup.material.law = Law::neo_hookean;
    setup.material.neo_mu = young / (4 * (1 - poisson_ratio * poisson_ratio));
    setup.material.bulk = young / (3 * (1 - 2 * poisson_ratio));
    setup.material.density = density;
    setup.material.distortion_factor = 0;
    SlabTissue tissue;
    tissue.depth = h;
    tissue.columns = 1;
    const Range through{trailing_face - thickness, trailing_face};
    const int nx = static_cast<int>(std::ceil(leaflet_length / (2 * spec.spacing * h))), nz = std::max(1, static_cast<int>(std::lround(thickness / h)));
    const double inset = 1e-3 * h;  // the upper wall itself is outside the grid
    const Plate lower = tissue.add_plate({inset, leaflet_length}, nx, through, nz);
    const Plate upper = tissue.add_plate({width - leaflet_length, width - inset}, nx, through, nz);
    for (int k = 0; k <= nz; ++k)
      for (int j = 0; j <= tissue.columns; ++j) {
        tissue.is_held[static_cast<std::size_t>(lower.node(0, j, k))] = 1;
        tissue.is_held[static_cast<std::size_t>(upper.node(nx, j, k))] = 1;
      }
    tissue.make_quadratic();
    tip_rest_ = {trailing_face - 0.5 * thickness, width - leaflet_length};
    tip_ = static_cast<std::size_t>(tissue.nearest_node(tip_rest_.across, tip_rest_.along));
    tip_rest_.along = tissue.mesh.points[3 * tip_ + 2];
    flow_ = std::make_unique<SlabFlow>(setup, tissue, std::vector<double>{});
    profile_ = parabola(setup.grid, 5 / cm);  // 5 x (H - x) cm/s with x in cm
  }

  void advance_to(double end) {
    while (time_ < end - 0.5 * spec_.dt) {
      time_ += spec_.dt;
      inflow_ = profile_;
      for (double& u : inflow_) u *= std::min(1.0, time_ / rise) * (std::sin(2 * M_PI * time_) + 1.1);
      flow_->set_inflow(2, 0, inflow_);
      flow_->advance(spec_.dt, 0);
    }
  }

  Tip tip() const { return {flow_->x()[3 * tip_ + 2] - tip_rest_.along, flow_->x()[3 * tip_] - tip_rest_.across}; }
  const SlabFlow& flow() const { return *flow_; }

 private:
  ValveSpec spec_;
  std::unique_ptr<SlabFlow> flow_;
  std::vector<double> profile_, inflow_;
  Tip tip_rest_;
  std::size_t tip_ = 0;
  double time_ = 0;
};

/// Runs to `end` and compares at every printed time with the first code; tolerances in cm.
void compare(const ValveSpec& spec, double end, double tolerance) {
  const OneThread one_thread;
  Valve valve(spec);
  const auto start = std::chrono::steady_clock::now();
  for (std::size_t q = 0; q < times.size() && times[q] <= end; ++q) {
    valve.advance_to(times[q]);
    const Tip tip = valve.tip();
    const auto line = [](const char* what, double computed, double first, double second) {
      std::printf("  %-6s computed %.3f cm  reference %.3f / %.3f  difference %+.1f / %+.1f %%\n", what, computed, first, second, 100 * (computed / first - 1),
                  100 * (computed / second - 1));
    };
    const SolidStatistics& solid = valve.flow().statistics();
    std::printf("t %.2f s, %d cells across, J %.3f .. %.3f (%.0f s)\n", times[q], spec.cells, solid.J_min, solid.J_max,
                std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    line("along", tip.along / cm, along_first[q], along_second[q]);
    line("across", tip.across / cm, across_first[q], across_second[q]);
    std::fflush(stdout);
    EXPECT_NEAR(tip.along / cm, along_first[q], tolerance);
    EXPECT_NEAR(tip.across / cm, across_first[q], tolerance);
  }
}

// A spacing of two thicknesses, 0.042 cm; the tip is followed within a spacing.
TEST(Valve2d, coarse_tip_follows_the_printed_curves) { compare({.cells = 38, .dt = 4e-5}, 0.25, 0.042); }

// The leaflets' nodes 1 and 1.5 cells apart in place of a half: README.md says what decides between them.
TEST(Valve2d, DISABLED_node_spacing) {
  constexpr double tolerance = 0.1;  // cm, what ib4 and half a cell leave
  for (const double spacing : {0.5, 1.0, 1.5}) {
    std::printf("nodes %.1f cells apart\n", spacing);
    compare({.cells = 38, .dt = 3e-5, .spacing = spacing}, 0.75, tolerance);
    compare({.cells = 38, .kernel = Kernel::cbs32, .relaxation = Relaxation::all_forces, .dt = 3e-5, .spacing = spacing}, 0.75, tolerance);
    if (spacing > 1) compare({.cells = 76, .dt = 2e-5, .spacing = spacing}, 0.75, tolerance);
  }
}

// A spacing of one thickness, 0.0212 cm. Within one and a half of them: while the flow decelerates the leaflets stay further open than the
// reference's, which have no thickness in the flow.
TEST(Valve2d, DISABLED_tip_curve) { compare({.cells = 76, .dt = 2e-5}, 2.5, 0.032); }

// Nothing touches here, so the relaxation of what the kernel does not see should change little; kernels differ by their width.
TEST(Valve2d, DISABLED_relaxation_and_kernels) {
  for (const Kernel kernel : {Kernel::ib4, Kernel::ib3, Kernel::cbs32})
    for (const Relaxation relaxation : {Relaxation::none, Relaxation::all_forces}) {
      std::printf("%s, %s\n", kernel == Kernel::ib4 ? "ib4" : kernel == Kernel::ib3 ? "ib3" : "cbs32",
                  relaxation == Relaxation::none ? "no relaxation" : "relaxed");
      compare({.cells = 38, .kernel = kernel, .relaxation = relaxation, .dt = 3e-5}, 0.75, 0.06);
    }
}

}  // namespace
}  // namespace mv::test
