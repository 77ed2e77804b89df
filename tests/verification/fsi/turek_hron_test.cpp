// SPDX-License-Identifier: BSD-3-Clause
// FSI1 (steady) and FSI3 (oscillating) of Turek & Hron 2006; setting and differences of model in turek_hron.h.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "verification/fsi/turek_hron.h"

namespace mv::test {
namespace {

TEST(TurekHron, probe) {
  const OneThread one_thread;
  TurekHronSpec spec;
  const char* e;
  if ((e = std::getenv("N"))) spec.cells = std::atoi(e);
  if ((e = std::getenv("DT"))) spec.dt = std::atof(e);
  if ((e = std::getenv("MU"))) spec.shear_modulus = std::atof(e);
  if ((e = std::getenv("U"))) spec.mean_velocity = std::atof(e);
  if (std::getenv("GIVEN")) spec.modulus = PlateModulus::given;
  if (std::getenv("RELAX")) spec.relaxation = Relaxation::all_forces;
  const double end = std::atof(std::getenv("T"));
  const double every = std::getenv("EVERY") ? std::atof(std::getenv("EVERY")) : 0.25;
  TurekHron run(spec);
  const auto start = std::chrono::steady_clock::now();
  for (double t = 0; t < end - 1e-9;) {
    const TurekHronSample s = run.advance(every);
    t = s.time;
    std::printf("%.4f ux %.5f mm uy %.5f mm drag %.4f lift %.4f  J %.4f %.4f (%.0f s)\n", s.time, 1e3 * s.ux, 1e3 * s.uy, s.drag, s.lift, run.flow().statistics().J_min,
                run.flow().statistics().J_max, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    std::fflush(stdout);
    if (!(std::abs(s.ux) < 1)) break;
  }
}

}  // namespace
}  // namespace mv::test
