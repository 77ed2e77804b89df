// SPDX-License-Identifier: BSD-3-Clause
// A coarse valve that closes in blood while its annulus contracts and moves along the tube: case, run, interrupt and results.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "geometry/core/case_files.h"
#include "geometry/core/motion_table.h"
#include "solver/output/frame_reader.h"
#include "unit/core/sample_case.h"

namespace {

namespace fs = std::filesystem;
using mv::Vec3;
using mv_test::TemporaryDirectory;

constexpr double contraction = 0.06, lift = 2.5, duration = 0.04;  // share, mm along the normal, s

int run(const std::string& command, const fs::path& log) {
  const int status = std::system((std::string(MV_BIN_DIR) + "/" + command + " > '" + log.string() + "' 2>&1").c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

const std::string coarse = " --set mesh.spacing='1.5 mm' --set tube.spacing='3 mm' --set leaflet.bulk='1 MPa'";

void write_config(const fs::path& file, const std::string& motion) { std::ofstream(file) << (motion.empty() ? "" : "[annulus]\nmotion = \"" + motion + "\"\n"); }

/// Contraction in the plane and a movement along the normal, of every fourth point of the annulus.
void write_motion(const fs::path& file, const mv::Annulus& annulus, double factor = 1) {
  std::vector<Vec3> rest;
  std::vector<std::vector<Vec3>> u;
  for (std::size_t i = 0; i < annulus.points.size(); i += 4) {
    const Vec3 d = annulus.points[i] - annulus.origin;
    rest.push_back(annulus.points[i]);
    u.push_back({Vec3::Zero(), factor * (lift * annulus.normal - contraction * (d - d.dot(annulus.normal) * annulus.normal))});
  }
  mv::write_motion(file, {0, duration}, rest, u);
}

}  // namespace

TEST(MovingAnnulus, a_valve_closes_while_its_annulus_moves) {
  const TemporaryDirectory dir;
  write_config(dir / "rest.toml", "");
  ASSERT_EQ(run("mvprep run -c '" + (dir / "rest.toml").string() + "' -o '" + (dir / "rest").string() + "'" + coarse, dir / "log"), 0) << mv::read_file(dir / "log");
  write_motion(dir / "motion.csv", mv::read_annulus(dir / "rest/annulus.vtp"));
  write_config(dir / "moving.toml", "motion.csv");
  ASSERT_EQ(run("mvprep run -c '" + (dir / "moving.toml").string() + "' -o '" + (dir / "case").string() + "'" + coarse, dir / "log"), 0) << mv::read_file(dir / "log");

  const std::string solve = "mvsolve run '" + (dir / "case").string() + "' --threads 1 --set output.checkpoint_every='0.02 s' -o '";
  const int code = run(solve + (dir / "whole").string() + "' --set time.end='0.06 s'", dir / "log");
  ASSERT_TRUE(code == 0 || code == 6) << mv::read_file(dir / "log");  // so coarse a valve may leave crossing faces
  const auto summary = nlohmann::json::parse(mv::read_file(dir / "whole/summary.json"));
  EXPECT_EQ(summary["run"]["end"], "finished");
  EXPECT_LT(summary["energy"]["residual_relative"].get<double>(), 0.02);
  EXPECT_GT(summary["flow"]["closing_volume_ml"].get<double>(), 2);

  // The held nodes are where the file takes them, and so is the annulus' plane.
  const mv::LeafletMesh mesh = mv::read_leaflets(dir / "case/leaflets.vtu");
  const mv::Annulus annulus = mv::read_annulus(dir / "case/annulus.vtp");
  fs::path last;
  for (const auto& entry : fs::directory_iterator(dir / "whole/frames"))
    if (entry.path().filename().string().starts_with("leaflets_") && entry.path() > last) last = entry.path();
  const mv::LeafletsFrame frame = mv::read_leaflets_frame(last);
  double worst = 0;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    if (!mesh.on_annulus[i]) continue;
    const Vec3 d = mesh.points[i] - annulus.origin, flat = d - d.dot(annulus.normal) * annulus.normal;
    // Nodes follow the nearest place of the annulus, half the leaflet's thickness away.
    worst = std::max(worst, (frame.mesh.points[i] - (mesh.points[i] + lift * annulus.normal - contraction * flat)).norm());
  }
  EXPECT_LT(worst, 0.1);
  EXPECT_NEAR((frame.annulus_origin - annulus.origin).dot(annulus.normal), lift, 0.02);

  // In two pieces, cut while it moves: the same to the last digit.
  run(solve + (dir / "pieces").string() + "' --set time.end='0.02 s'", dir / "log");
  EXPECT_EQ(run(solve + (dir / "pieces").string() + "' --set time.end='0.06 s' --resume", dir / "log"), code) << mv::read_file(dir / "log");
  EXPECT_EQ(mv::read_file(dir / "whole/series.csv"), mv::read_file(dir / "pieces/series.csv"));

  // An annulus that leaves its tube is refused before time is spent, by file and remedy.
  write_motion(dir / "wide.csv", annulus, -5);
  EXPECT_EQ(run("mvsolve run '" + (dir / "case").string() + "' -o '" + (dir / "wide").string() + "' --set annulus.motion='" + (dir / "wide.csv").string() + "'", dir / "log"), 4);
  EXPECT_NE(mv::read_file(dir / "log").find("outside the wall of the tube"), std::string::npos) << mv::read_file(dir / "log");
  EXPECT_EQ(run(solve + (dir / "faces").string() + "' --set coupling.annulus=faces", dir / "log"), 3);
}
