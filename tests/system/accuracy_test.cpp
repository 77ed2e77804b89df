// SPDX-License-Identifier: BSD-3-Clause
// mvsolve accuracy and bench from end to end on grids that are far too coarse, for some milliseconds: what they write, and that a second call reuses the runs.
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
  fs::path directory = fs::temp_directory_path() / ("mv_accuracy_" + std::to_string(::getpid()));
  Scratch() { fs::create_directories(directory); }
  ~Scratch() { fs::remove_all(directory); }
};

int run(const std::string& command, const fs::path& log) {
  const int status = std::system((std::string(MV_BIN_DIR) + "/" + command + " >" + log.string() + " 2>&1").c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(AccuracyCommand, two_coarse_levels_give_tables_page_and_settings_and_are_reused) {
  const Scratch scratch;
  const fs::path out = scratch.directory / "study", log = scratch.directory / "log";
  const std::string command = "mvsolve accuracy -o " + out.string() + " --spacings 4,3 --end 0.02 --window 0.005 --no-variations --small --no-scene-parts --budget 300";
  ASSERT_EQ(run(command, log), 0) << mv::read_file(log);
  const std::string csv = mv::read_file(out / "accuracy.csv"), page = mv::read_file(out / "accuracy.html");
  for (const char* study : {"closure,f4-s2,", "closure,f3-s1.5,", "tube_start,cells-6,", "sheet,f3-s1.5,"}) EXPECT_NE(csv.find(study), std::string::npos) << study;
  EXPECT_NE(page.find("<svg"), std::string::npos);
  EXPECT_EQ(page.find("<script"), std::string::npos);
  EXPECT_TRUE(fs::exists(out / "recommended.toml"));
  EXPECT_TRUE(fs::exists(out / "recommended_table.cpp"));
  const Json json = Json::parse(mv::read_file(out / "accuracy.json"));
  ASSERT_EQ(json["studies"][0]["runs"].size(), 2u);
  // The flow has begun after 20 ms: the finer run's peak velocity is the reference.
  EXPECT_GT(json["studies"][0]["runs"][1]["values"]["peak_velocity"].get<double>(), 0.05);
  EXPECT_LT(json["studies"][0]["runs"][1]["values"]["peak_velocity"].get<double>(), 2.0);
  const Json summary = Json::parse(mv::read_file(out / "runs" / "f3-s1.5" / "summary.json"));
  EXPECT_TRUE(summary["tissue"]["fibre_stress_belly_kPa"].is_number());
  EXPECT_EQ(summary["tissue"]["fibre_stress_trigones_kPa"].size(), 2u);

  const auto written = fs::last_write_time(out / "runs" / "f3-s1.5" / "study.json");
  ASSERT_EQ(run(command + " --no-known-answers", log), 0);
  EXPECT_EQ(fs::last_write_time(out / "runs" / "f3-s1.5" / "study.json"), written);
  // Another end is another run; without budget it is left out and said so.
  ASSERT_EQ(run("mvsolve accuracy -o " + out.string() + " --spacings 4,3 --end 0.01 --window 0.005 --no-variations --no-known-answers --no-scene-parts --budget 0.001", log), 0)
      << mv::read_file(log);
  EXPECT_NE(mv::read_file(out / "accuracy.html").find("left out: it needs about"), std::string::npos);

  // The case of the study is far too coarse for what the built-in table promises.
  EXPECT_EQ(run("mvsolve run " + (out / "cases" / "f4-s2").string() + " -o " + (scratch.directory / "r").string() + " --accuracy 2%", log), 3);
  EXPECT_EQ(run("mvsolve run " + (out / "cases" / "f4-s2").string() + " -o " + (scratch.directory / "r").string() + " --accuracy 2", log), 2);
  EXPECT_FALSE(fs::exists(scratch.directory / "r"));
}

TEST(BenchCommand, prints_parts_and_the_difference_between_thread_counts) {
  const Scratch scratch;
  const fs::path out = scratch.directory / "bench", log = scratch.directory / "log";
  ASSERT_EQ(setenv("OMP_WAIT_POLICY", "passive", 1), 0);
  ASSERT_EQ(run("mvsolve bench -o " + out.string() + " --spacings 4 --threads 2 --steps 20 --repeats 1 --at 0.002 --no-scene-parts", log), 0) << mv::read_file(log);
  const Json json = Json::parse(mv::read_file(out / "bench.json"));
  ASSERT_EQ(json["rows"].size(), 2u);
  EXPECT_GT(json["rows"][0]["part_s"]["fluid"].get<double>(), 0);
  EXPECT_GT(json["rows"][0]["bandwidth_share"]["fluid"].get<double>(), 0);
  EXPECT_EQ(json["rows"][1]["threads"], 2);
  EXPECT_EQ(json["rows"][1]["difference_between_thread_counts"]["x_m"].get<double>(), 0);
  EXPECT_NE(mv::read_file(log).find("triad GB/s"), std::string::npos);
  EXPECT_EQ(run("mvsolve bench -o " + out.string() + " --case " + (out / "cases" / "f4-s2").string() + " --threads 1 --steps 10 --repeats 1 --at 0.001 --no-scene-parts", log), 0)
      << mv::read_file(log);
  EXPECT_EQ(Json::parse(mv::read_file(out / "bench.json"))["rows"][0]["scene"], "f4-s2");
}

}  // namespace
