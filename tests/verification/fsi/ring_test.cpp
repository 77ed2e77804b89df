// SPDX-License-Identifier: BSD-3-Clause
// A massless circular membrane under tension holds pressure in a closed box, at rest: force per angle kappa X_theta,theta.
// Exact: p_in - p_out = kappa, the mean over the box zero, no flow. What the kernel leaves: a pressure jump smeared over its width, a
// spurious flow, and area lost to it with time.
// Printed values: Gruninger & Griffith, composite B-spline test suite (pressurised rubber band), 128^2 cells: p_in 0.8019, p_out -0.1960.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdio>

#include "verification/fsi/channel.h"

namespace mv::test {
namespace {

constexpr double radius = 0.25, kappa = 1, density = 1, viscosity = 0.1;
constexpr double centre_x = 0.503, centre_z = 0.498;  // no symmetry with the grid
constexpr double printed_in = 0.8019, printed_out = -0.1960;
constexpr double exact_out = -kappa * M_PI * radius * radius, exact_in = exact_out + kappa;

struct RingResult {
  double p_in = 0, p_out = 0;  // means over the cells three spacings and more away from the membrane
  double pressure_error = 0;   // L1 norm over the box against the exact jump
  double spurious = 0;         // m/s, largest velocity at the end
  double area_loss = 0;        // share of the area, per second over the second half of the run
  double seconds = 0;
};

class Ring {
 public:
  Ring(int cells, Kernel kernel)
      : grid_(slab_grid({0, 1}, {0, 1}, 1.0 / cells, 1)),
        fluid_(grid_, sides(), make_tube_wall(grid_, {}), density, viscosity),
        coupling_(Transfer(grid_, fluid_.wall(), kernel), density),
        state_(fluid_.make_state()),
        force_(grid_) {
    const int count = static_cast<int>(std::ceil(2 * M_PI * radius / (0.5 * grid_.h)));
    for (int q = 0; q < count; ++q) {
      const double angle = 2 * M_PI * q / count;
      x_.insert(x_.end(), {centre_x + radius * std::cos(angle), 0.25 * grid_.h, centre_z + radius * std::sin(angle)});
    }
    v_.assign(x_.size(), 0.0);
    membrane_.assign(x_.size(), 0.0);
    is_fixed_.assign(x_.size() / 3, 0);
  }

  void advance(double dt) {
    const std::size_t count = is_fixed_.size();
    const double factor = kappa * grid_.h * static_cast<double>(count) / (2 * M_PI);  // depth over the angle between two points
    for (std::size_t q = 0; q < count; ++q)
      for (std::size_t a : {0u, 2u})
        membrane_[3 * q + a] = factor * (x_[3 * ((q + 1) % count) + a] - 2 * x_[3 * q + a] + x_[3 * ((q + count - 1) % count) + a]);
    const CoupledNodes nodes{x_, v_, is_fixed_};
    coupling_.bind(nodes);
    force_.set_zero();
    coupling_.hand_over(membrane_, force_);
    fold_periodic_y(grid_, force_, false);
    fluid_.advance(state_, force_, dt, {});
    coupling_.move(nodes, state_.velocity, dt);
  }

  double area() const {
    double sum = 0;
    const std::size_t count = is_fixed_.size();
    for (std::size_t q = 0; q < count; ++q) {
      const double* a = x_.data() + 3 * q;
      const double* b = x_.data() + 3 * ((q + 1) % count);
      sum += 0.5 * (a[0] * b[2] - b[0] * a[2]);
    }
    return sum;
  }

  void measure_pressure(RingResult& result) const {
    double in = 0, out = 0;
    int count_in = 0, count_out = 0;
    for (int k = 0; k < grid_.n[2]; ++k)
      for (int i = 0; i < grid_.n[0]; ++i) {
        const double r = std::hypot((i + 0.5) * grid_.h - centre_x, (k + 0.5) * grid_.h - centre_z);
        const double p = state_.pressure[static_cast<std::size_t>(grid_.index(i, 0, k))];
        result.pressure_error += std::abs(p - (r < radius ? exact_in : exact_out)) * grid_.h * grid_.h;
        if (r < radius - 3 * grid_.h) in += p, ++count_in;
        if (r > radius + 3 * grid_.h) out += p, ++count_out;
      }
    result.p_in = in / count_in;
    result.p_out = out / count_out;
  }

  double peak_velocity() const { return fluid_.peak_velocity(state_); }
  double h() const { return grid_.h; }

 private:
  static FluidBoundary sides() {
    FluidBoundary boundary;
    for (std::size_t axis : {0u, 2u}) boundary.side[axis] = {BoundaryKind::wall, BoundaryKind::wall};
    boundary.side[1] = {BoundaryKind::periodic, BoundaryKind::periodic};
    return boundary;
  }

  FluidGrid grid_;
  NavierStokes fluid_;
  Coupling coupling_;
  FlowState state_;
  FaceField force_;
  std::vector<double> x_, v_, membrane_;
  std::vector<char> is_fixed_;
};

RingResult run_ring(int cells, Kernel kernel, double end) {
  const OneThread one_thread;
  Ring ring(cells, kernel);
  const int steps = static_cast<int>(std::ceil(end / (0.08 * ring.h() * ring.h() * density / viscosity)));
  const double dt = end / steps;
  const auto start = std::chrono::steady_clock::now();
  RingResult result;
  double area_half = 0;
  for (int step = 0; step < steps; ++step) {
    if (step == steps / 2) area_half = ring.area();
    ring.advance(dt);
  }
  result.area_loss = (1 - ring.area() / area_half) / (dt * (steps - steps / 2));
  result.spurious = ring.peak_velocity();
  ring.measure_pressure(result);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

const char* name_of(Kernel kernel) { return kernel == Kernel::ib4 ? "ib4" : kernel == Kernel::ib3 ? "ib3" : "cbs32"; }

void print(Kernel kernel, int cells, const RingResult& r) {
  std::printf("%-5s %3d^2: p_in %.5f (exact %.5f, printed %.4f)  p_out %.5f (exact %.5f, printed %.4f)\n", name_of(kernel), cells, r.p_in, exact_in, printed_in,
              r.p_out, exact_out, printed_out);
  std::printf("             L1 error of p %.2e  spurious velocity %.2e m/s  area lost %+.2e /s  (%.0f s)\n", r.pressure_error, r.spurious,
              r.area_loss, r.seconds);
  std::fflush(stdout);
}

double order(double coarse, double fine) { return std::log2(std::abs(coarse / fine)); }

/// Against the exact values; the printed ones differ from them by 0.2 %.
void expect_pressures(const RingResult& r) {
  EXPECT_NEAR(r.p_in, exact_in, 0.003);
  EXPECT_NEAR(r.p_out, exact_out, 0.003);
  EXPECT_NEAR(r.p_in, printed_in, 0.005);
  EXPECT_NEAR(r.p_out, printed_out, 0.005);
}

void refine(Kernel kernel, std::initializer_list<int> sizes, double end) {
  std::vector<RingResult> results;
  for (const int cells : sizes) {
    results.push_back(run_ring(cells, kernel, end));
    print(kernel, cells, results.back());
    if (cells == 128) expect_pressures(results.back());
    if (results.size() < 2) continue;
    const RingResult &a = results[results.size() - 2], &b = results.back();
    std::printf("      order of the pressure's L1 error %.2f, of the spurious velocity %.2f, of the area lost %.2f\n",
                order(a.pressure_error, b.pressure_error), order(a.spurious, b.spurious), order(a.area_loss, b.area_loss));
    // A jump smeared over a kernel's width leaves first order, and so do the spurious flow and what it carries off.
    EXPECT_GT(order(a.pressure_error, b.pressure_error), 0.9);
    EXPECT_GT(order(a.spurious, b.spurious), 0.6);
    EXPECT_LT(b.area_loss, a.area_loss);
  }
  EXPECT_LT(results.back().spurious, 1e-3 * std::sqrt(kappa / density));
  EXPECT_LT(std::abs(results.back().area_loss), 1e-4);
}

class PressurisedRing : public ::testing::TestWithParam<Kernel> {};

TEST_P(PressurisedRing, holds_its_pressure_and_its_area) { refine(GetParam(), {32, 64, 128}, 0.05); }

TEST_P(PressurisedRing, DISABLED_refinement) { refine(GetParam(), {32, 64, 128, 256}, 0.2); }

TEST_P(PressurisedRing, DISABLED_area_over_time) {
  for (const double end : {1.0, 2.0, 4.0}) print(GetParam(), 64, run_ring(64, GetParam(), end));
}

INSTANTIATE_TEST_SUITE_P(kernels, PressurisedRing, ::testing::Values(Kernel::ib4, Kernel::ib3, Kernel::cbs32),
                         [](const auto& parameter) { return std::string(name_of(parameter.param)); });

}  // namespace
}  // namespace mv::test
