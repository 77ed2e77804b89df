// SPDX-License-Identifier: BSD-3-Clause
// The generic valve on a grid of 2 mm with solid points 1 mm apart: from the configuration to the numbers, in half a minute. Bounds are the physics'
// (papers/s1: 10.8 ml regurgitated at closing, chordae 6.3 N), not this version's digits; a grid this coarse may leave crossing faces, which
// the program then reports with code 6.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "geometry/core/case_files.h"

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

struct Scratch {
  fs::path directory = fs::temp_directory_path() / ("mv_regression_" + std::to_string(::getpid()));
  Scratch() { fs::create_directories(directory); }
  ~Scratch() { fs::remove_all(directory); }
};

int run(const std::string& command) {
  const int status = std::system((std::string(MV_BIN_DIR) + "/" + command + " >/dev/null 2>&1").c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

Json close_valve(const fs::path& directory, const std::string& config, const std::string& end) {
  const std::string source = std::string(MV_SOURCE_DIR) + "/configs/" + config;
  EXPECT_EQ(run("mvprep run -c " + source + " -o " + (directory / "case").string() + " --set mesh.spacing='1 mm' --set tube.spacing='2 mm'"), 0);
  const int code = run("mvsolve run " + (directory / "case").string() + " -o " + (directory / "results").string() + " --set time.end='" + end + "'");
  EXPECT_TRUE(code == 0 || code == 6) << code;
  return Json::parse(mv::read_file(directory / "results" / "summary.json"));
}

TEST(CoarseClosure, the_demos_valve_closes_seals_and_keeps_its_budgets) {
  const Scratch scratch;
  const Json s = close_valve(scratch.directory, "demo.toml", "0.15 s");
  EXPECT_EQ(s["run"]["end"], "finished");
  EXPECT_TRUE(s["seal"]["sealed"].get<bool>());
  EXPECT_LT(s["seal"]["smallest_sealing_threshold_mm"].get<double>(), 1.5);
  EXPECT_TRUE(s["contact"]["belt_continuous"].get<bool>());
  EXPECT_GT(s["flow"]["closing_volume_ml"].get<double>(), 5.0);
  EXPECT_LT(s["flow"]["closing_volume_ml"].get<double>(), 15.0);
  EXPECT_LT(std::abs(s["flow"]["leak_rate_ml_s"].get<double>()), 3.0);
  EXPECT_GT(s["papillary"]["force_total_N"].get<double>(), 3.0);
  EXPECT_LT(s["papillary"]["force_total_N"].get<double>(), 12.0);
  EXPECT_LT(s["energy"]["residual_relative"].get<double>(), 0.02);
  EXPECT_LT(s["mass"]["solid_volume_drift"].get<double>(), 0.01);
  EXPECT_LT(s["mass"]["divergence_relative"].get<double>(), 1e-10);
}

TEST(CoarseClosure, without_chordae_the_valve_opens_through_and_is_not_called_sealed) {
  const Scratch scratch;
  const Json s = close_valve(scratch.directory, "no_chordae.toml", "0.08 s");
  EXPECT_FALSE(s["seal"]["sealed"].get<bool>());
  EXPECT_GT(s["seal"]["hole_area_mm2"].get<double>(), 30.0 * s["orifice"]["open_area_cm2"].get<double>());  // a third of the orifice
}

}  // namespace
