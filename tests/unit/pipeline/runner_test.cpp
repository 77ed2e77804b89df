// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/runner.h"

#include <gtest/gtest.h>

#include "geometry/core/errors.h"
#include "pipeline/exit_status.h"
#include "unit/core/sample_case.h"

using mv_test::TemporaryDirectory;

TEST(ExitStatus, every_kind_of_failure_has_its_code) {
  EXPECT_EQ(mv::exit_status([] {}), 0);
  EXPECT_EQ(mv::exit_status([] { throw mv::UsageError("x"); }), 2);
  EXPECT_EQ(mv::exit_status([] { throw mv::ConfigError("x"); }), 3);
  EXPECT_EQ(mv::exit_status([] { throw mv::InputError("x"); }), 4);
  EXPECT_EQ(mv::exit_status([] { throw mv::GateError("x"); }), 5);
  EXPECT_EQ(mv::exit_status([] { throw mv::TrustError("x"); }), 6);
  EXPECT_EQ(mv::exit_status([] { throw mv::IoError("x"); }), 7);
  EXPECT_EQ(mv::exit_status([] { throw std::logic_error("x"); }), 70);
  EXPECT_EQ(mv::exit_status([] { throw std::bad_alloc(); }), 7);
  EXPECT_EQ(mv::exit_status([] { throw 3; }), 70);
}

TEST(Runner, a_stage_without_what_it_needs_says_which_stage_to_run) {
  const TemporaryDirectory dir;
  try {
    mv::run_one_stage("chordae", mv::Config(), dir.path(), [](const mv::StageReport&) {});
    FAIL();
  } catch (const mv::IoError& e) {
    EXPECT_NE(std::string(e.what()).find("mid_surface.vtp is missing; run stage source first"), std::string::npos) << e.what();
  }
}

TEST(Runner, an_unknown_first_stage_is_a_usage_error) {
  const TemporaryDirectory dir;
  EXPECT_THROW(mv::run_all_stages(mv::Config(), dir.path(), {}, "meshes", [](const mv::StageReport&) {}), mv::UsageError);
  EXPECT_TRUE(std::filesystem::is_empty(dir.path()));
}
