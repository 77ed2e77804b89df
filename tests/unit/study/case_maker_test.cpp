// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "geometry/core/errors.h"
#include "solver/study/case_maker.h"
#include "solver/time/scene.h"

namespace {

namespace fs = std::filesystem;

struct Scratch {
  // A space and a quote: nothing of the path may be read by a shell.
  fs::path directory = fs::temp_directory_path() / ("mv it's a study " + std::to_string(::getpid()));
  Scratch() { fs::create_directories(directory); }
  ~Scratch() { fs::remove_all(directory); }
};

const fs::path mvprep = fs::path(MV_BIN_DIR) / "mvprep";
const std::string coarse = "[mesh]\nspacing = \"2 mm\"\n[tube]\nspacing = \"4 mm\"\n";

TEST(CaseMaker, makes_a_case_that_can_be_loaded_and_reuses_it) {
  const Scratch scratch;
  mv::CaseMaker maker(scratch.directory, mvprep);
  const mv::MadeCase made = maker.make("coarse", coarse);
  ASSERT_TRUE(made.is_made()) << made.error;
  EXPECT_GT(mv::load_scene(made.directory).mesh.points.size(), 100u);
  const auto written = fs::last_write_time(made.directory / "leaflets.vtu");
  EXPECT_TRUE(mv::CaseMaker(scratch.directory, mvprep).make("coarse", coarse).is_made());
  EXPECT_EQ(fs::last_write_time(made.directory / "leaflets.vtu"), written);
}

TEST(CaseMaker, hands_on_why_mvprep_refused) {
  const Scratch scratch;
  mv::CaseMaker maker(scratch.directory, mvprep);
  const mv::MadeCase unknown_key = maker.make("unknown", "[mesh]\nspacin = \"2 mm\"\n");
  EXPECT_EQ(unknown_key.exit_code, 3);
  EXPECT_NE(unknown_key.error.find("mesh.spacing"), std::string::npos) << unknown_key.error;
  const mv::MadeCase gate = maker.make("gate", "[mesh]\nspacing = \"2 mm\"\n[tube]\nspacing = \"1 mm\"\n");
  EXPECT_EQ(gate.exit_code, 5);
  EXPECT_NE(gate.error.find("spacing"), std::string::npos) << gate.error;
}

TEST(CaseMaker, says_that_mvprep_is_missing) {
  const Scratch scratch;
  EXPECT_THROW(mv::CaseMaker(scratch.directory, scratch.directory / "mvprep").make("x", coarse), mv::IoError);
  EXPECT_THROW(mv::CaseMaker(scratch.directory, mvprep).make("../x", coarse), mv::UsageError);
  const std::string path = std::getenv("PATH");
  setenv("PATH", "", 1);
  // The test program has no mvprep beside it.
  EXPECT_THROW(mv::find_mvprep(), mv::IoError);
  setenv("PATH", path.c_str(), 1);
}

}  // namespace
