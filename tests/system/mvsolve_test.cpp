// SPDX-License-Identifier: BSD-3-Clause
// The whole chain on a coarse valve, as a user runs it: exit codes, interrupt and resume, what a scene leaves out.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "geometry/core/case_files.h"

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

struct Outcome {
  int code = -1;
  std::string out, err;
};

fs::path scratch() {
  static const fs::path directory = [] {
    const fs::path d = fs::temp_directory_path() / ("mv_system_mvsolve_" + std::to_string(::getpid()));
    fs::remove_all(d);
    fs::create_directories(d);
    return d;
  }();
  return directory;
}

pid_t start(const std::string& program, const std::vector<std::string>& arguments, rlim_t file_limit) {
  const pid_t child = fork();
  if (child != 0) return child;
  dup2(open((scratch() / "stdout").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666), STDOUT_FILENO);
  dup2(open((scratch() / "stderr").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666), STDERR_FILENO);
  if (file_limit != RLIM_INFINITY) {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit bound{file_limit, file_limit};
    setrlimit(RLIMIT_FSIZE, &bound);
  }
  const std::string path = std::string(MV_BIN_DIR) + "/" + program;
  std::vector<char*> argv{const_cast<char*>(path.c_str())};
  for (const auto& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  execv(path.c_str(), argv.data());
  _exit(127);
}

Outcome finish(pid_t child) {
  int status = 0;
  waitpid(child, &status, 0);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, mv::read_file(scratch() / "stdout"), mv::read_file(scratch() / "stderr")};
}

Outcome run(const std::string& program, const std::vector<std::string>& arguments, rlim_t file_limit = RLIM_INFINITY) {
  return finish(start(program, arguments, file_limit));
}

/// A coarse valve, prepared once.
const fs::path& coarse_case() {
  static const fs::path directory = [] {
    const fs::path config = scratch() / "coarse.toml";
    std::ofstream(config) << "[mesh]\nspacing = \"2 mm\"\n[tube]\nspacing = \"4 mm\"\n[time]\nend = \"4 ms\"\n"
                             "[output]\nseries_every = \"0.5 ms\"\nframes_every = \"2 ms\"\nfluid_every = \"2 ms\"\ncheckpoint_every = \"1 ms\"\n";
    const fs::path d = scratch() / "case";
    const Outcome o = run("mvprep", {"run", "-c", config.string(), "-o", d.string()});
    EXPECT_EQ(o.code, 0) << o.err;
    return d;
  }();
  return directory;
}

Json summary(const fs::path& results) { return Json::parse(mv::read_file(results / "summary.json")); }

TEST(Mvsolve, writes_all_results_of_the_contract) {
  const fs::path results = scratch() / "all";
  const Outcome o = run("mvsolve", {"run", coarse_case().string(), "-o", results.string()});
  ASSERT_EQ(o.code, 0) << o.err;
  for (const char* file : {"series.csv", "chordae.csv", "leaflets.pvd", "fluid.pvd", "contact_map.vtp", "summary.json", "report.html", "run.json",
                           "frames/leaflets_0000.vtu", "frames/leaflets_0002.vtu", "frames/fluid_0000.vti", "checkpoint/state.bin", "case/case.toml"})
    EXPECT_TRUE(fs::exists(results / file)) << file;
  const Json s = summary(results);
  for (const char* key : {"/fluid/cells", "/fluid/spacing_mm", "/solid/tets", "/solid/J_min", "/solid/distortion_controlled_fraction", "/run/steps", "/run/wall_s",
                          "/run/threads", "/run/simulated_s", "/run/dt_mean_s", "/flow/closing_volume_ml", "/flow/leak_volume_ml", "/flow/leak_rate_ml_s",
                          "/flow/peak_velocity_m_s", "/seal/sealed", "/seal/threshold_mm", "/seal/smallest_sealing_threshold_mm", "/seal/hole_area_mm2", "/seal/holes",
                          "/contact/belt_continuous", "/contact/belt_width_mm_mean", "/contact/area_mm2", "/contact/force_N", "/contact/penetration_max_mm",
                          "/contact/self_intersections", "/bulging/volume_ml", "/bulging/area_ratio", "/orifice/area_cm2", "/chordae/force_primary_N",
                          "/chordae/force_secondary_N", "/papillary/force_N", "/energy/residual_relative", "/mass/solid_volume_drift"})
    EXPECT_TRUE(s.contains(Json::json_pointer(key))) << key;
  EXPECT_NEAR(s["run"]["simulated_s"].get<double>(), 4e-3, 1e-9);
  EXPECT_FALSE(s["seal"]["sealed"].get<bool>());
  EXPECT_LT(s["mass"]["divergence_relative"].get<double>(), 1e-10);
}

TEST(Mvsolve, resume_after_an_interrupt_equals_the_uninterrupted_run_to_the_last_digit) {
  // Long and hard enough that leaflets touch: contact, friction and the film's drainage are part of what is resumed.
  const std::vector<std::string> settings{"--set", "time.end=60 ms", "--set", "pressure.rise_time=30 ms"};
  auto arguments = [&](const fs::path& results, bool resume) {
    std::vector<std::string> a{"run", coarse_case().string(), "-o", results.string(), "--threads", "2"};
    a.insert(a.end(), settings.begin(), settings.end());
    if (resume) a.push_back("--resume");
    return a;
  };
  const fs::path whole = scratch() / "whole", parts = scratch() / "parts";
  const Outcome uninterrupted = run("mvsolve", arguments(whole, false));
  ASSERT_TRUE(uninterrupted.code == 0 || uninterrupted.code == 6) << uninterrupted.err;  // so coarse a valve may leave crossing faces
  const pid_t child = start("mvsolve", arguments(parts, false), RLIM_INFINITY);
  // Interrupt in contact.
  for (int wait = 0; wait < 20000 && !fs::exists(parts / "frames" / "leaflets_0022.vtu"); ++wait) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  kill(child, SIGINT);
  const Outcome interrupted = finish(child);
  ASSERT_EQ(interrupted.code, 130) << interrupted.err;
  EXPECT_NE(interrupted.err.find("--resume"), std::string::npos);
  EXPECT_FALSE(fs::exists(parts / "summary.json"));
  const Outcome resumed = run("mvsolve", arguments(parts, true));
  ASSERT_EQ(resumed.code, uninterrupted.code) << resumed.err;
  for (const char* file : {"series.csv", "chordae.csv", "contact_map.vtp", "frames/leaflets_0030.vtu", "frames/fluid_0030.vti", "leaflets.pvd"})
    EXPECT_EQ(mv::read_file(whole / file), mv::read_file(parts / file)) << file;
  EXPECT_EQ(summary(whole)["flow"], summary(parts)["flow"]);
  EXPECT_GT(summary(whole)["contact"]["force_penalty_N"].get<double>(), 0.0);
  // Other settings cannot be resumed.
  auto other = arguments(parts, true);
  other.insert(other.end(), {"--set", "contact.friction=0"});
  EXPECT_EQ(run("mvsolve", other).code, 4);
}

TEST(Mvsolve, a_finished_run_goes_on_to_a_later_end_and_refuses_an_earlier_one) {
  const fs::path longer = scratch() / "longer", extended = scratch() / "extended";
  auto arguments = [&](const fs::path& results, const std::string& end) {
    return std::vector<std::string>{"run", coarse_case().string(), "-o", results.string(), "--set", "time.end=" + end};
  };
  ASSERT_EQ(run("mvsolve", arguments(longer, "6 ms")).code, 0);
  ASSERT_EQ(run("mvsolve", arguments(extended, "4 ms")).code, 0);
  auto resumed = arguments(extended, "2 ms");
  resumed.push_back("--resume");
  const Outcome earlier = run("mvsolve", resumed);
  EXPECT_EQ(earlier.code, 4);
  EXPECT_NE(earlier.err.find("time.end"), std::string::npos);
  EXPECT_TRUE(fs::exists(extended / "summary.json"));
  resumed = arguments(extended, "6 ms");
  resumed.push_back("--resume");
  ASSERT_EQ(run("mvsolve", resumed).code, 0);
  EXPECT_EQ(mv::read_file(longer / "series.csv"), mv::read_file(extended / "series.csv"));
}

TEST(Mvsolve, results_do_not_depend_on_the_thread_count) {
  for (const char* threads : {"1", "2"}) {
    const Outcome o = run("mvsolve", {"run", coarse_case().string(), "-o", (scratch() / ("t" + std::string(threads))).string(), "--threads", threads, "--set", "time.end=50 ms",
                                      "--set", "pressure.rise_time=30 ms"});
    ASSERT_TRUE(o.code == 0 || o.code == 6) << o.err;
  }
  EXPECT_EQ(mv::read_file(scratch() / "t1" / "series.csv"), mv::read_file(scratch() / "t2" / "series.csv"));
}

TEST(Mvsolve, what_a_scene_leaves_out_costs_nothing) {
  const fs::path results = scratch() / "dry";
  ASSERT_EQ(run("mvsolve", {"run", coarse_case().string(), "-o", results.string(), "--set", "fluid.enabled=false", "--set", "contact.enabled=false", "--set",
                            "chordae.model=none", "--set", "fibers.model=none"})
                .code,
            0);
  const Json s = summary(results);
  EXPECT_FALSE(s.contains("fluid"));
  EXPECT_FALSE(s.contains("flow"));
  EXPECT_FALSE(s.contains("chordae"));
  for (const char* part : {"fluid", "coupling", "contact", "chordae"}) EXPECT_EQ(s["run"]["share"][part].get<double>(), 0.0) << part;
  EXPECT_FALSE(fs::exists(results / "chordae.csv"));
  EXPECT_FALSE(fs::exists(results / "frames" / "fluid_0000.vti"));
  EXPECT_FALSE(fs::exists(results / "contact_map.vtp"));
}

TEST(Mvsolve, quadratic_tetrahedra_run_with_every_law) {
  coarse_case();  // writes coarse.toml
  const fs::path directory = scratch() / "quadratic";
  ASSERT_EQ(run("mvprep", {"run", "-c", (scratch() / "coarse.toml").string(), "-o", directory.string(), "--set", "mesh.order=2"}).code, 0);
  for (const char* law : {"m1", "ogden", "hgo"}) {
    const fs::path results = scratch() / ("quadratic_" + std::string(law));
    const Outcome o = run("mvsolve", {"run", directory.string(), "-o", results.string(), "--set", "time.end=3 ms", "--set", "pressure.rise_time=10 ms", "--set",
                                      "leaflet.anterior.law=" + std::string(law), "--set", "leaflet.posterior.law=" + std::string(law)});
    EXPECT_EQ(o.code, 0) << o.err;
    EXPECT_GT(summary(results)["flow"]["backward_volume_ml"].get<double>(), 0.0);
    EXPECT_LT(summary(results)["energy"]["residual_relative"].get<double>(), 0.02);
  }
}

TEST(Mvsolve, every_failure_has_its_exit_code_and_names_its_cause) {
  const std::string good = coarse_case().string();
  EXPECT_EQ(run("mvsolve", {}).code, 2);
  EXPECT_EQ(run("mvsolve", {"run"}).code, 2);
  EXPECT_EQ(run("mvsolve", {"run", good, "-o", (scratch() / "x").string(), "--threads", "0"}).code, 2);
  EXPECT_EQ(run("mvsolve", {"--help"}).code, 0);
  Outcome o = run("mvsolve", {"run", good, "-o", (scratch() / "x").string(), "--set", "fluid.viscosty=1 Pa s"});
  EXPECT_EQ(o.code, 3);
  EXPECT_NE(o.err.find("fluid.viscosity"), std::string::npos);
  EXPECT_EQ(run("mvsolve", {"run", "/nonexistent", "-o", (scratch() / "x").string()}).code, 7);
  EXPECT_EQ(run("mvsolve", {"report", "/nonexistent"}).code, 7);
  EXPECT_EQ(run("mvsolve", {"run", good, "-o", (scratch() / "nothing").string(), "--resume"}).code, 7);

  const fs::path damaged = scratch() / "damaged";
  fs::copy(coarse_case(), damaged, fs::copy_options::recursive);
  std::string bytes = mv::read_file(damaged / "leaflets.vtu");
  bytes[bytes.size() / 2] ^= 1;
  std::ofstream(damaged / "leaflets.vtu", std::ios::binary) << bytes;
  o = run("mvsolve", {"run", damaged.string(), "-o", (scratch() / "x").string()});
  EXPECT_EQ(o.code, 4);
  EXPECT_NE(o.err.find("leaflets.vtu"), std::string::npos);
  fs::remove(damaged / "leaflets.vtu");
  EXPECT_EQ(run("mvsolve", {"run", damaged.string(), "-o", (scratch() / "x").string()}).code, 7);

  // Cut off between two lines, case.toml is valid TOML still, and would be read as defaults.
  const std::string toml = mv::read_file(coarse_case() / "case.toml");
  for (const std::string& part : {std::string(), toml.substr(0, toml.find("[leaflet]"))}) {
    std::ofstream(damaged / "case.toml", std::ios::binary) << part;
    o = run("mvsolve", {"run", damaged.string(), "-o", (scratch() / "x").string()});
    EXPECT_EQ(o.code, 3);
    EXPECT_NE(o.err.find("case.toml: incomplete"), std::string::npos) << o.err;
  }
  fs::remove_all(damaged);
  fs::copy(coarse_case(), damaged, fs::copy_options::recursive);
  std::ofstream(damaged / "manifest.json", std::ios::binary) << "{";
  o = run("mvsolve", {"run", damaged.string(), "-o", (scratch() / "early").string()});
  EXPECT_EQ(o.code, 4);
  EXPECT_NE(o.err.find("manifest.json"), std::string::npos) << o.err;
  EXPECT_FALSE(fs::exists(scratch() / "early" / "series.csv"));   // known before the run
}

TEST(Mvsolve, a_full_disk_ends_with_code_7_and_leaves_nothing_half_written) {
  const fs::path results = scratch() / "full";
  const Outcome o = run("mvsolve", {"run", coarse_case().string(), "-o", results.string()}, 20000);
  EXPECT_EQ(o.code, 7) << o.err;
  EXPECT_FALSE(fs::exists(results / "summary.json"));
  for (const auto& entry : fs::recursive_directory_iterator(results)) EXPECT_EQ(entry.path().string().find(".tmp"), std::string::npos) << entry.path();
}

TEST(Mvsolve, a_run_that_cannot_go_on_ends_with_code_6_a_reason_and_a_readable_last_frame) {
  const fs::path results = scratch() / "diverged";
  const Outcome o = run("mvsolve", {"run", coarse_case().string(), "-o", results.string(), "--set", "pressure.peak=500 mmHg", "--set", "pressure.rise_time=0.01 ms", "--set",
                                    "leaflet.distortion_factor=0", "--set", "leaflet.anterior.m1_a=0 Pa", "--set", "leaflet.anterior.m1_c=100 Pa", "--set", "coupling.relaxation=false", "--set", "time.end=30 ms"});
  EXPECT_EQ(o.code, 6) << o.err;
  const Json s = summary(results);
  EXPECT_FALSE(s["trust"]["passed"].get<bool>());
  EXPECT_FALSE(s["trust"]["failed"].empty());
  EXPECT_TRUE(fs::exists(results / "report.html"));
}

}  // namespace
