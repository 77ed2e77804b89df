// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/prediction.h"

#include <gtest/gtest.h>

namespace {
const mv::CaseSize calibration{40000, 76000, 1, 100000, 0.5};
}

TEST(Prediction, meets_the_measured_run_it_is_calibrated_on) {
  const auto p = mv::predict_run(mv::Config(), calibration);
  EXPECT_NEAR(p.seconds_per_step, 9e-3, 0.1e-3);
  EXPECT_NEAR(p.step_s, 1e-5, 1e-12);
  EXPECT_EQ(p.steps, 25000);
  EXPECT_NEAR(p.run_s, 225, 3);
}

TEST(Prediction, grows_with_the_case_and_leaves_out_what_the_scene_leaves_out) {
  mv::CaseSize dry = calibration;
  dry.fluid_cells = 0;
  EXPECT_LT(mv::predict_run(mv::Config(), dry).seconds_per_step, mv::predict_run(mv::Config(), calibration).seconds_per_step);
  EXPECT_LT(mv::predict_run(mv::Config(), dry).memory_mb, mv::predict_run(mv::Config(), calibration).memory_mb);
  mv::CaseSize quadratic = calibration;
  quadratic.order = 2;
  EXPECT_GT(mv::predict_run(mv::Config(), quadratic).run_s, 2 * mv::predict_run(mv::Config(), calibration).run_s);
}

TEST(Prediction, names_what_sets_the_step) {
  mv::Config config;
  config.set("chordae.stiffness=80 MPa");
  EXPECT_NEAR(mv::predict_run(config, calibration).step_s, 5e-6, 1e-12);
  EXPECT_EQ(mv::predict_run(config, calibration).limiter, "chordae stiffness");
  config.set("time.step_max=2 us");
  EXPECT_EQ(mv::predict_run(config, calibration).limiter, "time.step_max");
  config.set("time.step_fixed=4 us");
  EXPECT_NEAR(mv::predict_run(config, calibration).step_s, 4e-6, 1e-12);
  EXPECT_EQ(mv::predict_run(config, calibration).limiter, "time.step_fixed");
}
