// SPDX-License-Identifier: BSD-3-Clause
// A pressure-loaded elastic band closes a channel between two rigid blocks; what passes it is leak.
// Reference: IBAMR, tests/IBFE/explicit_ex8_2d (input, output), kernel IB_4; centimetres, grams, seconds.
// ../shared/reference/benchmarks.toml [leak_band] holds its numbers at step 100. From the input file, not in the table: the
// blocks fill x < 0.5 and x > 1.5 below z = 0.5, the band's ends are tethered, the sides x = 0 and x = 2 are open above the
// blocks, the pressure acts on 0.5 < x < 1.5 of the bottom, Q_in is taken there, the swept area is that under the upper face of
// the band, values are those of the last half step, the bulk modulus is 2 BETA_S = 1e3 in size (nothing depends on it).
//
// Differences: the solver has one condition for a side, so the sides are open along their whole height and the bottom has its
// pressure below the blocks, too, which hold the blood there; the band is a slab of linear tetrahedra spaced h/2 instead of
// quadratic elements four cells long and bunched at the ends. Here nodes move with the velocity at the end of a step, there with
// that of the half step. Q grows with t^2: to set the swept area of a step (velocity at its end) against the mean inflow of the
// step would show -dt / t = -1 % of leak that is none. Rates at the half step are therefore means of two steps, and the integral
// counts both flows at the ends of steps.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdio>

#include "verification/slab_flow.h"

namespace mv::test {
namespace {

// Reference (cm, s).
constexpr double inflow_rate = 0.00451633, swept_rate = 0.0044575;  // cm2/s
constexpr double leak_fraction = 0.0130, leak_fraction_integral = 0.0188;
constexpr double J_low = 0.999965, J_high = 1.00002;

constexpr double cm = 1e-2, cm2 = 1e-4;  // m, m2
constexpr double reference_h = 0.015625 * cm, reference_dt = 1.5625e-4;
constexpr int reference_steps = 100;

struct LeakResult {
  double inflow = 0, swept = 0;                    // m2/s, half a step before the end
  double inflow_integral = 0, swept_integral = 0;  // m2, the same
  double J_min = 1, J_max = 1;                     // over all steps
  double seconds = 0;
  double leak() const { return (inflow - swept) / inflow; }
  double leak_integral() const { return (inflow_integral - swept_integral) / inflow_integral; }
};

/// Inflow through 0.5 < x < 1.5 of the bottom per depth, m2/s.
double inflow_of(const SlabFlow& slab) {
  const FluidGrid& grid = slab.fluid().grid();
  double sum = 0;
  for (int j = 0; j < grid.n[1]; ++j)
    for (int i = 0; i < grid.n[0]; ++i) {
      const double x = grid.h * (i + 0.5);
      if (x > 0.5 * cm && x < 1.5 * cm) sum += slab.flow().velocity.c[2][static_cast<std::size_t>(grid.index(i, j, 0))];
    }
  return sum * grid.h / grid.n[1];
}

/// Area under the band's upper face (m2), trapezoids.
double swept_of(const SlabFlow& slab, const Plate& band) {
  double area = 0;
  for (int i = 0; i < band.nx; ++i) {
    const double* a = slab.x().data() + 3 * band.node(i, 0, band.nz);
    const double* b = slab.x().data() + 3 * band.node(i + 1, 0, band.nz);
    area += 0.5 * (b[0] - a[0]) * ((a[2] - 0.5 * cm) + (b[2] - 0.5 * cm));
  }
  return area;
}

/// `refinement`: spacings and step are those of the reference divided by it.
LeakResult run_band(Kernel kernel, Relaxation relaxation, int reference_step_count = reference_steps, double refinement = 1, int cells_deep = 3) {
  const double h = reference_h / refinement, dt = reference_dt / refinement;
  const int steps = static_cast<int>(std::lround(reference_step_count * refinement));
  SlabSetup setup;
  setup.grid = slab_grid({0, 2.0 * cm}, {0, 1.5 * cm}, h, cells_deep);
  setup.boundary.side[0] = {BoundaryKind::open, BoundaryKind::open};
  setup.density = 1000;
  setup.viscosity = 0.004;
  setup.kernel = kernel;
  setup.material.law = Law::neo_hookean;
  setup.material.neo_mu = 100;
  setup.material.bulk = 100;
  setup.material.density = 1000;
  setup.relaxation = relaxation;
  SlabTissue tissue;
  tissue.depth = cells_deep * h;
  tissue.columns = 2 * cells_deep;
  const Plate band = tissue.add_plate({0.5 * cm, 1.5 * cm}, static_cast<int>(std::lround(128 * refinement)), {0.484 * cm, 0.5 * cm},
                                      std::max(1, static_cast<int>(std::lround(2 * refinement))));
  for (int k = 0; k <= band.nz; ++k)
    for (int j = 0; j <= band.columns; ++j)
      for (int i : {0, band.nx}) tissue.is_held[static_cast<std::size_t>(band.node(i, j, k))] = 1;
  const double inset = 0.125 * h;
  std::vector<double> blocks = block_points({inset, 0.5 * cm}, {inset, 0.5 * cm}, 0.5 * h, tissue.depth, tissue.columns);
  const std::vector<double> right =
      block_points({1.5 * cm, 2.0 * cm - inset}, {inset, 0.5 * cm}, 0.5 * h, tissue.depth, tissue.columns);
  blocks.insert(blocks.end(), right.begin(), right.end());

  SlabFlow slab(setup, tissue, blocks);
  LeakResult result;
  const auto start = std::chrono::steady_clock::now();
  double inflow = 0, swept = 0, volume = 0, area = 0;
  for (int step = 1; step <= steps; ++step) {
    slab.advance(dt, 8.0 * std::min(1.0, 0.5 * step * dt));
    const double area_before = area, volume_before = volume, inflow_before = inflow, swept_before = swept;
    area = swept_of(slab, band);
    inflow = inflow_of(slab);
    swept = (area - area_before) / dt;
    volume += dt * inflow;
    result.inflow = 0.5 * (inflow + inflow_before);
    result.swept = 0.5 * (swept + swept_before);
    result.inflow_integral = 0.5 * (volume + volume_before);
    result.swept_integral = 0.5 * (area + area_before);
    result.J_min = std::min(result.J_min, slab.statistics().J_min);
    result.J_max = std::max(result.J_max, slab.statistics().J_max);
  }
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

void print(const char* name, const LeakResult& r) {
  std::printf("%s (%.0f s)\n", name, r.seconds);
  const auto line = [](const char* what, double computed, double reference) {
    std::printf("  %-24s computed %12.6g  reference %12.6g  difference %+.3g\n", what, computed, reference, computed - reference);
  };
  line("Q_in cm2/s", r.inflow / cm2, inflow_rate);
  line("Q_disp cm2/s", r.swept / cm2, swept_rate);
  line("leak fraction", r.leak(), leak_fraction);
  line("leak fraction, integral", r.leak_integral(), leak_fraction_integral);
  line("J min", r.J_min, J_low);
  line("J max", r.J_max, J_high);
  std::fflush(stdout);
}

/// A tenth of the printed leak is wanted, so that "less than the reference" is no matter of rounding.
void expect_tight(const LeakResult& r) {
  EXPECT_NEAR(r.leak(), 0.0, 0.1 * leak_fraction);
  EXPECT_NEAR(r.leak_integral(), 0.0, 0.1 * leak_fraction_integral);
}

void expect_less_leak(Kernel kernel, double refinement) {
  const LeakResult r = run_band(kernel, Relaxation::none, reference_steps, refinement, 1);
  std::printf("%-5s thickness %.2f h: inflow %.6f cm2/s  leak %+.4f %%, integral %+.4f %% (printed %.2f, %.2f %%)  J %.5f .. %.5f (%.0f s)\n",
              kernel == Kernel::ib4 ? "ib4" : kernel == Kernel::ib3 ? "ib3" : "cbs32", 1.024 * refinement, r.inflow / cm2, 100 * r.leak(), 100 * r.leak_integral(),
              100 * leak_fraction, 100 * leak_fraction_integral, r.J_min, r.J_max, r.seconds);
  std::fflush(stdout);
  EXPECT_LT(std::abs(r.leak()), leak_fraction);
  EXPECT_LT(std::abs(r.leak_integral()), leak_fraction_integral);
}

class LeakBand : public ::testing::Test {
  OneThread one_thread_;
};

TEST_F(LeakBand, ib4_leaks_less_than_the_reference) {
  const LeakResult r = run_band(Kernel::ib4, Relaxation::none);
  print("ib4", r);
  expect_tight(r);
  EXPECT_NEAR(r.inflow / cm2, inflow_rate, 0.01 * inflow_rate);
  // The reference's range, 3.5e-5, is not reached: 3.4e-4 in the linear tetrahedra beside the held ends.
  EXPECT_GT(r.J_min, 1 - 5e-4);
  EXPECT_LT(r.J_max, 1 + 5e-4);
}

TEST_F(LeakBand, relaxation_does_not_make_it_leak) {
  const LeakResult r = run_band(Kernel::ib4, Relaxation::all_forces);
  print("ib4, relaxation", r);
  expect_tight(r);
  EXPECT_NEAR(r.inflow / cm2, inflow_rate, 0.02 * inflow_rate);
}

TEST_F(LeakBand, other_kernels_leak_less_than_the_reference) {
  for (const Kernel kernel : {Kernel::ib3, Kernel::cbs32}) {
    const LeakResult r = run_band(kernel, Relaxation::none);
    print(kernel == Kernel::ib3 ? "ib3" : "cbs32", r);
    expect_tight(r);
    EXPECT_NEAR(r.inflow / cm2, inflow_rate, 0.03 * inflow_rate);
  }
}

// The band is half a cell, a cell, and two cells thick; one cell deep instead of three, which changes nothing a kernel sees.
TEST_F(LeakBand, every_kernel_leaks_less_than_the_reference_at_every_spacing) {
  for (const Kernel kernel : {Kernel::ib4, Kernel::ib3, Kernel::cbs32})
    for (const double refinement : {0.5, 1.0}) expect_less_leak(kernel, refinement);
}

TEST_F(LeakBand, DISABLED_every_kernel_leaks_less_than_the_reference_at_half_the_spacing) {
  for (const Kernel kernel : {Kernel::ib4, Kernel::ib3, Kernel::cbs32}) expect_less_leak(kernel, 2.0);
}

// Beyond the reference: the band bulges by fourteen cells, where the numbers of step 100 do not apply. Measured: -0.10 % (-0.06 %
// integral); with relaxation -0.99 % (-0.60 %): nodes of the stretched band creep through the blood, ahead of it.
TEST_F(LeakBand, DISABLED_bulging_band_does_not_leak) {
  for (const Relaxation relaxation : {Relaxation::none, Relaxation::all_forces}) {
    const bool is_relaxed = relaxation != Relaxation::none;
    const LeakResult r = run_band(Kernel::ib4, relaxation, 2000);
    std::printf("%s, t = 0.31 s: leak fraction %+.2e, integral %+.2e, J %.3f .. %.3f (%.0f s)\n",
                is_relaxed ? "ib4, relaxation" : "ib4", r.leak(), r.leak_integral(), r.J_min, r.J_max, r.seconds);
    EXPECT_NEAR(r.leak(), 0.0, (is_relaxed ? 1.0 : 0.1) * leak_fraction);
    EXPECT_NEAR(r.leak_integral(), 0.0, (is_relaxed ? 1.0 : 0.1) * leak_fraction_integral);
  }
}

}  // namespace
}  // namespace mv::test
