// SPDX-License-Identifier: GPL-3.0-or-later
// The program itself, as a user meets it: commands, every exit code, skipping, the same bytes.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "geometry/core/case_files.h"
#include "geometry/core/config.h"
#include "geometry/core/errors.h"
#include "unit/core/sample_case.h"

using mv_test::TemporaryDirectory;

namespace {

struct Outcome {
  int code = -1;
  std::string out, err;
};

const std::string program = std::string(MV_BIN_DIR) + "/mvprep";

/// Starts the program; returns its process. Output goes to files of the directory.
pid_t start(const std::vector<std::string>& arguments, const TemporaryDirectory& dir, rlim_t file_limit = RLIM_INFINITY) {
  const pid_t child = fork();
  if (child != 0) return child;
  const std::string out = dir / "stdout", err = dir / "stderr";
  dup2(open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666), STDOUT_FILENO);
  dup2(open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666), STDERR_FILENO);
  if (file_limit != RLIM_INFINITY) {
    const rlimit bound{file_limit, file_limit};
    setrlimit(RLIMIT_FSIZE, &bound);
  }
  std::vector<char*> argv = {const_cast<char*>(program.c_str())};
  for (const auto& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  execv(program.c_str(), argv.data());
  _exit(127);
}

Outcome finish(pid_t child, const TemporaryDirectory& dir) {
  int status = 0;
  waitpid(child, &status, 0);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, mv::read_file(dir / "stdout"), mv::read_file(dir / "stderr")};
}

Outcome mvprep(const std::vector<std::string>& arguments, const TemporaryDirectory& dir, rlim_t file_limit = RLIM_INFINITY) {
  return finish(start(arguments, dir, file_limit), dir);
}

/// A valve coarse enough for a test; the spacing gate is met by a coarse fluid grid.
std::string coarse_config(const TemporaryDirectory& dir, const std::string& extra = "") {
  const auto file = dir / "coarse.toml";
  std::ofstream(file) << "[mesh]\nspacing = \"1.5 mm\"\n[tube]\nspacing = \"4 mm\"\n" << extra;
  return file;
}

bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

int count(const std::string& text, const std::string& part) {
  int n = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

std::vector<std::string> hidden_files(const std::filesystem::path& directory) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(directory)) {
    const std::string name = entry.path().filename();
    if (name.starts_with(".") || holds(name, ".tmp")) names.push_back(name);
  }
  return names;
}

const std::vector<std::string> case_files = {"case.toml",   "leaflets.vtu",  "chordae.vtp",  "tube.vtu",
                                             "annulus.vtp", "papillary.vtp", "quality.json", "manifest.json"};

}  // namespace

TEST(Mvprep, run_makes_a_complete_case_and_a_second_run_skips_everything) {
  const TemporaryDirectory dir;
  const auto config = coarse_config(dir);
  const auto first = mvprep({"run", "-c", config, "-o", dir / "case"}, dir);
  ASSERT_EQ(first.code, 0) << first.err;
  for (const char* stage : {"source", "annulus", "mesh", "chordae", "fibers", "tube", "gates"})
    EXPECT_TRUE(holds(first.out, stage)) << stage;
  EXPECT_EQ(count(first.out, " s   "), 7) << first.out;
  std::map<std::string, std::string> hashes;
  for (const auto& file : case_files) {
    ASSERT_TRUE(std::filesystem::exists(dir / ("case/" + file))) << file;
    hashes[file] = mv::sha256_of_file(dir / ("case/" + file));
  }
  EXPECT_TRUE(hidden_files(dir / "case").empty());
  EXPECT_TRUE(nlohmann::json::parse(mv::read_file(dir / "case/quality.json")).at("passed").get<bool>());

  const auto mesh = mv::read_leaflets(dir / "case/leaflets.vtu");
  const auto chordae = mv::read_chordae(dir / "case/chordae.vtp");
  const auto tube = mv::read_tube(dir / "case/tube.vtu");
  EXPECT_GT(mesh.tets.size(), 1000u);
  EXPECT_EQ(mesh.fibre.size(), mesh.tets.size());
  EXPECT_GE(chordae.segments.size(), 22u);
  EXPECT_GT(tube.hexes.size(), 100u);

  const auto second = mvprep({"run", "-c", config, "-o", dir / "case"}, dir);
  ASSERT_EQ(second.code, 0) << second.err;
  EXPECT_EQ(count(second.out, "skipped"), 7) << second.out;
  for (const auto& [file, hash] : hashes) EXPECT_EQ(mv::sha256_of_file(dir / ("case/" + file)), hash) << file;

  const auto changed = mvprep({"run", "-c", config, "-o", dir / "case", "--set", "chordae.slack=1.05"}, dir);
  ASSERT_EQ(changed.code, 0) << changed.err;
  EXPECT_EQ(count(changed.out, "skipped"), 4) << changed.out;  // fibres can follow the chordae

  const auto forced = mvprep({"run", "-c", config, "-o", dir / "case", "--from", "fibers"}, dir);
  ASSERT_EQ(forced.code, 0) << forced.err;
  EXPECT_EQ(count(forced.out, "skipped"), 3) << forced.out;  // chordae changes back
}

TEST(Mvprep, the_same_input_gives_the_same_bytes) {
  const TemporaryDirectory dir;
  const auto config = coarse_config(dir);
  ASSERT_EQ(mvprep({"run", "-c", config, "-o", dir / "a"}, dir).code, 0);
  ASSERT_EQ(mvprep({"run", "-c", config, "-o", dir / "b"}, dir).code, 0);
  for (const auto& file : case_files) EXPECT_EQ(mv::read_file(dir / ("a/" + file)), mv::read_file(dir / ("b/" + file))) << file;
}

TEST(Mvprep, a_case_is_repeated_from_its_own_case_toml) {
  const TemporaryDirectory dir;
  ASSERT_EQ(mvprep({"run", "-c", coarse_config(dir), "-o", dir / "a"}, dir).code, 0);
  const auto again = mvprep({"run", "-c", dir / "a/case.toml", "-o", dir / "b"}, dir);
  ASSERT_EQ(again.code, 0) << again.err;
  for (const char* file : {"leaflets.vtu", "chordae.vtp", "tube.vtu", "annulus.vtp", "papillary.vtp", "quality.json"}) {
    EXPECT_EQ(mv::read_file(dir / (std::string("a/") + file)), mv::read_file(dir / (std::string("b/") + file))) << file;
  }
}

TEST(Mvprep, single_stages_run_again_on_what_is_there) {
  const TemporaryDirectory dir;
  ASSERT_EQ(mvprep({"run", "-c", coarse_config(dir), "-o", dir / "case"}, dir).code, 0);
  const std::string before = mv::read_file(dir / "case/leaflets.vtu");
  for (const char* stage : {"annulus", "mesh", "chordae", "fibers", "tube"}) {
    const auto outcome = mvprep({stage, dir / "case"}, dir);
    EXPECT_EQ(outcome.code, 0) << stage << ": " << outcome.err;
    EXPECT_TRUE(holds(outcome.out, stage));
  }
  EXPECT_EQ(mv::read_file(dir / "case/leaflets.vtu"), before);
  EXPECT_FALSE(std::filesystem::exists(dir / "case/quality.json")) << "the verdict was about another state";
  const auto check = mvprep({"check", dir / "case"}, dir);
  EXPECT_EQ(check.code, 0) << check.err;
  EXPECT_TRUE(holds(check.out, "leaflets.self_intersections")) << check.out;
}

TEST(Mvprep, dry_run_prints_numbers_and_writes_nothing) {
  const TemporaryDirectory dir;
  const auto outcome = mvprep({"run", "-c", coarse_config(dir), "-o", dir / "case", "--dry-run"}, dir);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  for (const char* part : {"solid points", "tetrahedra", "fluid cells", "memory", "stable step", "run time"})
    EXPECT_TRUE(holds(outcome.out, part)) << part;
  EXPECT_FALSE(std::filesystem::exists(dir / "case"));
}

TEST(Mvprep, config_prints_a_valid_configuration_with_every_key) {
  const TemporaryDirectory dir;
  for (const auto& arguments : {std::vector<std::string>{"config"}, {"config", "--defaults"}}) {
    const auto outcome = mvprep(arguments, dir);
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(mv::Config::from_string(outcome.out, "printed").to_toml(), mv::Config().to_toml());
  }
  EXPECT_TRUE(holds(mvprep({"config"}, dir).out, "# leaflet thickness"));
}

TEST(Mvprep, exit_0_for_help_and_version) {
  const TemporaryDirectory dir;
  for (const char* flag : {"--help", "--version"}) {
    const auto outcome = mvprep({flag}, dir);
    EXPECT_EQ(outcome.code, 0);
    EXPECT_FALSE(outcome.out.empty());
  }
  for (const char* command : {"run", "generic", "annulus", "mesh", "chordae", "fibers", "tube", "check", "config"}) {
    EXPECT_EQ(mvprep({command, "--help"}, dir).code, 0) << command;
  }
}

TEST(Mvprep, exit_2_for_a_wrong_command_line) {
  const TemporaryDirectory dir;
  const auto config = coarse_config(dir);
  for (const auto& arguments :
       std::vector<std::vector<std::string>>{{},
                                             {"walk"},
                                             {"run"},
                                             {"run", "-c", config},
                                             {"run", "-c", config, "-o", dir / "case", "--no-such-flag"},
                                             {"mesh"},
                                             {"check"},
                                             {"run", "-c", config, "-o", dir / "case", "--from", "meshes"}}) {
    const auto outcome = mvprep(arguments, dir);
    EXPECT_EQ(outcome.code, 2) << outcome.err;
    EXPECT_FALSE(outcome.err.empty());
  }
  EXPECT_TRUE(holds(mvprep({"run", "-c", config, "-o", dir / "case", "--from", "meshes"}, dir).err, "'mesh'"));
  EXPECT_FALSE(std::filesystem::exists(dir / "case"));
}

TEST(Mvprep, exit_3_for_a_wrong_configuration) {
  const TemporaryDirectory dir;
  for (const char* extra :
       {"[fluid]\nviscosty = \"1 mPa s\"\n", "[fluid]\nviscosity = 1\n", "[fluid]\nviscosity = \"1 mm\"\n", "[fluid\n"}) {
    const auto outcome = mvprep({"run", "-c", coarse_config(dir, extra), "-o", dir / "case"}, dir);
    EXPECT_EQ(outcome.code, 3) << extra << outcome.err;
    EXPECT_TRUE(holds(outcome.err, "coarse.toml:5") || holds(outcome.err, "coarse.toml:6")) << outcome.err;
  }
  EXPECT_TRUE(holds(mvprep({"run", "-c", coarse_config(dir, "[fluid]\nviscosty = \"1 mPa s\"\n"), "-o", dir / "case"}, dir).err,
                    "fluid.viscosity"));
  EXPECT_EQ(mvprep({"run", "-c", coarse_config(dir), "-o", dir / "case", "--set", "mesh.spacing=1"}, dir).code, 3);
  EXPECT_EQ(mvprep({"run", "-c", coarse_config(dir), "-o", dir / "case", "--set", "nonsense"}, dir).code, 3);
  EXPECT_FALSE(std::filesystem::exists(dir / "case"));
}

TEST(Mvprep, exit_4_for_damaged_input) {
  const TemporaryDirectory dir;
  std::ofstream(dir / "ring.csv") << "x_mm,y_mm,z_mm\n1,2,three\n";
  const auto csv = mvprep({"run", "-c", coarse_config(dir, "[generic]\nannulus = \"ring.csv\"\n"), "-o", dir / "case"}, dir);
  EXPECT_EQ(csv.code, 4) << csv.err;
  EXPECT_TRUE(holds(csv.err, "error ring.csv: line 2")) << csv.err;
  EXPECT_TRUE(hidden_files(dir / "case").empty());

  ASSERT_EQ(mvprep({"run", "-c", coarse_config(dir), "-o", dir / "good"}, dir).code, 0);
  std::string bytes = mv::read_file(dir / "good/leaflets.vtu");
  bytes[bytes.size() / 2] ^= 1;
  mv::write_text_atomically(dir / "good/leaflets.vtu", bytes);
  const auto damaged = mvprep({"chordae", dir / "good"}, dir);
  EXPECT_EQ(damaged.code, 4) << damaged.err;
  EXPECT_TRUE(holds(damaged.err, "leaflets.vtu")) << damaged.err;
  const auto repaired = mvprep({"run", "-c", coarse_config(dir), "-o", dir / "good"}, dir);
  EXPECT_EQ(repaired.code, 0) << repaired.err;
  mv::read_leaflets(dir / "good/leaflets.vtu");

  mv::write_text_atomically(dir / "good/manifest.json", "{");
  EXPECT_EQ(mvprep({"run", "-c", coarse_config(dir), "-o", dir / "good"}, dir).code, 4);
}

TEST(Mvprep, exit_5_for_a_failed_gate_that_names_element_and_reason) {
  const TemporaryDirectory dir;
  const std::vector<std::string> strict = {"run",        "-c",    coarse_config(dir),         "-o",
                                           dir / "case", "--set", "gates.min_dihedral=59 deg"};
  const auto outcome = mvprep(strict, dir);
  ASSERT_EQ(outcome.code, 5) << outcome.err;
  EXPECT_TRUE(holds(outcome.err, "dihedral")) << outcome.err;
  const auto quality = nlohmann::json::parse(mv::read_file(dir / "case/quality.json"));
  EXPECT_FALSE(quality.at("passed").get<bool>());
  EXPECT_EQ(mvprep(strict, dir).code, 5) << "a failed gate must not count as done";
  EXPECT_EQ(mvprep({"check", dir / "case"}, dir).code, 5);
  const auto lenient = mvprep({"run", "-c", coarse_config(dir), "-o", dir / "case"}, dir);
  EXPECT_EQ(lenient.code, 0) << lenient.err;
  EXPECT_EQ(count(lenient.out, "skipped"), 5) << "the gate of angles decides how patient leaflets are thinned, so the source is made again";
}

TEST(Mvprep, a_failing_stage_leaves_no_case_of_mixed_parts) {
  const TemporaryDirectory dir;
  ASSERT_EQ(mvprep({"run", "-c", coarse_config(dir), "-o", dir / "case"}, dir).code, 0);
  // More removed chordae than there are: the chordae stage refuses.
  const auto outcome = mvprep({"run", "-c", coarse_config(dir), "-o", dir / "case", "--set", "chordae.removed=[999]"}, dir);
  EXPECT_EQ(outcome.code, 3) << outcome.err;
  EXPECT_TRUE(std::filesystem::exists(dir / "case/tube.vtu"));
  EXPECT_FALSE(std::filesystem::exists(dir / "case/chordae.vtp"));
  EXPECT_FALSE(std::filesystem::exists(dir / "case/quality.json"));
  EXPECT_TRUE(hidden_files(dir / "case").empty());
}

TEST(Mvprep, exit_7_for_missing_files_and_a_full_disk) {
  const TemporaryDirectory dir;
  EXPECT_EQ(mvprep({"run", "-c", dir / "none.toml", "-o", dir / "case"}, dir).code, 7);
  EXPECT_EQ(mvprep({"run", "-c", coarse_config(dir, "[generic]\nannulus = \"none.csv\"\n"), "-o", dir / "case"}, dir).code, 7);
  EXPECT_EQ(mvprep({"mesh", dir / "none"}, dir).code, 7);
  std::ofstream(dir / "in_the_way") << "x";
  EXPECT_EQ(mvprep({"run", "-c", coarse_config(dir), "-o", dir / "in_the_way"}, dir).code, 7);
  EXPECT_FALSE(std::filesystem::exists(dir / "case"));

  const auto full = mvprep({"run", "-c", coarse_config(dir), "-o", dir / "full"}, dir, 20000);
  EXPECT_EQ(full.code, 7) << full.err;
  EXPECT_TRUE(hidden_files(dir / "full").empty());
  EXPECT_FALSE(std::filesystem::exists(dir / "full/leaflets.vtu"));
}

TEST(Mvprep, exit_130_when_interrupted_and_the_next_run_goes_on) {
  const TemporaryDirectory dir;
  const auto config = coarse_config(dir);
  const pid_t child = start({"run", "-c", config, "-o", dir / "case"}, dir);
  while (!std::filesystem::exists(dir / "stdout") || !holds(mv::read_file(dir / "stdout"), "source")) usleep(1000);
  kill(child, SIGINT);
  const auto outcome = finish(child, dir);
  EXPECT_EQ(outcome.code, 130) << outcome.out << outcome.err;
  EXPECT_TRUE(holds(outcome.err, "interrupted"));
  EXPECT_TRUE(hidden_files(dir / "case").empty());
  const auto rest = mvprep({"run", "-c", config, "-o", dir / "case"}, dir);
  EXPECT_EQ(rest.code, 0) << rest.err;
  EXPECT_TRUE(holds(rest.out, "skipped"));
}

TEST(Mvprep, an_interrupt_does_not_wait_for_the_end_of_a_stage) {
  const TemporaryDirectory dir;
  const pid_t child = start({"run", "-c", coarse_config(dir), "-o", dir / "case", "--set", "mesh.spacing=0.2 mm"}, dir);
  while (!std::filesystem::exists(dir / "case") || hidden_files(dir / "case").empty()) usleep(1000);
  const auto begin = std::chrono::steady_clock::now();
  kill(child, SIGTERM);
  const auto outcome = finish(child, dir);
  EXPECT_EQ(outcome.code, 130) << outcome.out << outcome.err;
  EXPECT_FALSE(holds(outcome.out, "source")) << "the stage was over: no test of an interrupt";
  EXPECT_TRUE(holds(outcome.err, "interrupted"));
  EXPECT_TRUE(hidden_files(dir / "case").empty());
  EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(), 2);
}

TEST(Mvprep, a_measured_annulus_with_measured_papillary_points_becomes_a_case) {
  const TemporaryDirectory dir;
  const std::string config = std::string(MV_SOURCE_DIR) + "/configs/normal_1.toml";
  const auto outcome =
      mvprep({"run", "-c", config, "-o", dir / "case", "--set", "mesh.spacing=1.5 mm", "--set", "tube.spacing=4 mm"}, dir);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto annulus = mv::read_annulus(dir / "case/annulus.vtp");
  const auto papillary = mv::read_papillary(dir / "case/papillary.vtp");
  double perimeter = 0;
  for (std::size_t i = 0; i < annulus.points.size(); ++i)
    perimeter += (annulus.points[(i + 1) % annulus.points.size()] - annulus.points[i]).norm();
  EXPECT_NEAR(perimeter, 120.5, 2.5);  // smoothing takes a little off the measured 120.5 mm
  ASSERT_EQ(papillary.tips.size(), 2u);
  for (const auto& tip : papillary.tips) EXPECT_GT((tip - annulus.origin).dot(annulus.normal), 5);
  EXPECT_TRUE(std::filesystem::exists(dir / "case/inputs/pressure.csv.csv"));
}

TEST(Mvprep, a_valve_without_chordae_and_fibres_is_complete) {
  const TemporaryDirectory dir;
  const std::string config = std::string(MV_SOURCE_DIR) + "/configs/no_chordae.toml";
  const auto outcome =
      mvprep({"run", "-c", config, "-o", dir / "case", "--set", "mesh.spacing=1.5 mm", "--set", "tube.spacing=4 mm"}, dir);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_TRUE(mv::read_chordae(dir / "case/chordae.vtp").segments.empty());
}

TEST(Mvprep, metrics_of_the_generic_valve_are_its_parameters_under_slicerhearts_names) {
  const TemporaryDirectory dir;
  const auto config = coarse_config(dir);
  ASSERT_EQ(mvprep({"run", "-q", "-c", config, "-o", dir / "valve"}, dir).code, 0);
  const auto done = mvprep({"metrics", dir / "valve/", "-o", dir / "tables", "--phase", "MS"}, dir);
  ASSERT_EQ(done.code, 0) << done.err;
  std::map<std::string, double> value;
  std::istringstream table(mv::read_file(dir / "tables/QuantificationResults_long.csv"));
  std::string line;
  std::getline(table, line);
  EXPECT_EQ(line, "Filename,Phase,Measurement,Value");
  std::getline(table, line);
  EXPECT_EQ(line, "valve,MS,ValveType,MitralValve");
  while (std::getline(table, line)) {
    ASSERT_TRUE(line.starts_with("valve,MS,")) << line;
    value[line.substr(9, line.rfind(',') - 9)] = std::stod(line.substr(line.rfind(',') + 1));
  }
  EXPECT_NEAR(value.at("Annulus circumference (3D)"), 107.2, 0.1);
  EXPECT_NEAR(value.at("A-P distance"), 30, 0.01);
  EXPECT_NEAR(value.at("AL-PM distance"), 38, 0.01);
  EXPECT_NEAR(value.at("Sphericity index (A-P / AL-PM)"), 30.0 / 38, 1e-3);
  EXPECT_NEAR(value.at("Annulus height"), 0, 1e-6);
  EXPECT_NEAR(value.at("Annulus area (2D)"), std::acos(-1.0) / 4 * 38 * 30, 0.5);
  // the commissures are 36 mm of arc apart, on chords of the ellipse
  EXPECT_NEAR(value.at("ALC-PMC distance"), 31.5, 1.5);
  EXPECT_NEAR(value.at("Leaflet thickness estimate - anterior leaflet"), 1, 0.05);
  EXPECT_NEAR(value.at("Leaflet area - all"),
              value.at("Leaflet area - anterior leaflet") + value.at("Leaflet area - posterior leaflet"), 1e-2);
  EXPECT_TRUE(holds(mv::read_file(dir / "tables/QuantificationUnits.csv"), "Annulus area (2D),mm*mm\n"));
  const std::string wide = mv::read_file(dir / "tables/QuantificationResults_wide.csv");
  EXPECT_TRUE(wide.starts_with("Filename,Phase,Measurement,Annulus circumference (3D),A-P distance,")) << wide;
  EXPECT_EQ(count(wide, "\n"), 2);
  EXPECT_EQ(mvprep({"metrics", dir / "valve", dir / "tables/../valve"}, dir).code, 2) << "two rows of one name";
  EXPECT_EQ(mvprep({"metrics", dir / "tables"}, dir).code, 7);
}

TEST(Mvprep, export_copies_the_case_in_the_asked_space) {
  const TemporaryDirectory dir;
  const auto config = coarse_config(dir);
  ASSERT_EQ(mvprep({"run", "-q", "-c", config, "-o", dir / "valve"}, dir).code, 0);
  ASSERT_EQ(mvprep({"export", dir / "valve", "-o", dir / "lps", "--space", "LPS"}, dir).code, 0);
  ASSERT_EQ(mvprep({"export", dir / "valve", "-o", dir / "ras"}, dir).code, 0);
  EXPECT_THROW(mv::read_leaflets(dir / "lps/leaflets.vtu"), mv::InputError) << "our own programs take RAS only";
  const auto ras = mv::read_leaflets(dir / "ras/leaflets.vtu"), original = mv::read_leaflets(dir / "valve/leaflets.vtu");
  ASSERT_EQ(ras.points.size(), original.points.size());
  EXPECT_EQ(ras.points, original.points);
  EXPECT_EQ(ras.fibre, original.fibre);
  EXPECT_EQ(mvprep({"export", dir / "valve", "-o", dir / "valve", "--space", "LPS"}, dir).code, 2);
  EXPECT_EQ(mvprep({"export", dir / "valve", "-o", dir / "x", "--space", "ABC"}, dir).code, 2);
}
