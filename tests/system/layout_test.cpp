// SPDX-License-Identifier: GPL-3.0-or-later
// `mvprep layout` as a user runs it, on a coarse generic valve with slack chordae: trials, table, the layout as files that a configuration can use.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "geometry/core/case_files.h"
#include "unit/core/sample_case.h"

using mv_test::TemporaryDirectory;

namespace {

int run(const std::string& arguments, const TemporaryDirectory& dir) {
  const int status = std::system((std::string(MV_BIN_DIR) + "/mvprep " + arguments + " > '" + (dir / "stdout").string() + "' 2> '" + (dir / "stderr").string() + "'").c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

std::string search(const std::filesystem::path& out, int trials) {
  return "layout -c '" + std::string(MV_SOURCE_DIR) + "/configs/demo.toml' -o '" + out.string() + "' --fluid '4 mm' --target 0.5 --trials " + std::to_string(trials) +
         " --set chordae.slack=1.3 --set fibers.model=none --set leaflet.anterior.law=neo_hookean --set leaflet.posterior.law=neo_hookean --set 'contact.threshold=1.5 mm'";
}

struct Row {
  int trial = 0;
  double area = 0;
  bool is_kept = false;
};

std::vector<Row> rows_of(const std::filesystem::path& file) {
  std::istringstream text(mv::read_file(file));
  std::string line;
  std::getline(text, line);
  EXPECT_EQ(line, "trial,exit_code,hole_area_mm2,holes,kept,changes,places");
  std::vector<Row> rows;
  while (std::getline(text, line)) {
    Row row;
    int code = 0, holes = 0, kept = 0;
    if (std::sscanf(line.c_str(), "%d,%d,%lf,%d,%d", &row.trial, &code, &row.area, &holes, &kept) == 5) {
      row.is_kept = kept == 1;
      rows.push_back(row);
    }
  }
  return rows;
}

}  // namespace

TEST(Layout, chordae_are_changed_until_the_holes_shrink_and_the_best_is_kept_as_files) {
  const TemporaryDirectory dir;
  const int code = run(search(dir / "search", 2) + " --time '60 ms'", dir);
  ASSERT_TRUE(code == 0 || code == 5) << code << "\n" << mv::read_file(dir / "stderr");
  const std::vector<Row> rows = rows_of(dir / "search/trials.csv");
  ASSERT_GE(rows.size(), 2u) << mv::read_file(dir / "search/trials.csv");
  EXPECT_TRUE(rows.front().is_kept);
  double best = rows.front().area;
  for (const Row& row : rows) {
    std::printf("trial %d: %.2f mm2%s\n", row.trial, row.area, row.is_kept ? ", kept" : "");
    if (row.is_kept) {
      EXPECT_LE(row.area, best);
      best = row.area;
    }
  }
  EXPECT_LT(best, rows.front().area) << "no change helped";
  EXPECT_EQ(code == 0, best <= 0.5);

  // The same search gives the same rows.
  run(search(dir / "again", 1) + " --time '60 ms'", dir);
  const std::string all = mv::read_file(dir / "search/trials.csv"), one = mv::read_file(dir / "again/trials.csv");
  EXPECT_EQ(all.substr(0, one.size()), one);

  // The layout in a configuration of its own gives the chordae of the best trial again.
  const std::string keys = mv::read_file(dir / "search/layout.toml");
  std::ofstream(dir / "search/again.toml") << "[mesh]\nspacing = \"2 mm\"\n[tube]\nspacing = \"4 mm\"\n[fibers]\nmodel = \"none\"\n" << keys;
  ASSERT_EQ(run("run -c '" + (dir / "search/again.toml").string() + "' -o '" + (dir / "case").string() + "'", dir), 0) << mv::read_file(dir / "stderr");
}

TEST(Layout, a_coarse_mesh_that_does_not_pass_its_gates_is_refined_a_few_times) {
  // Half of the fluid spacing, 2 mm, is what the search starts from.
  const TemporaryDirectory dir;
  const auto gated = [&](const std::string& out, const std::string& ratio) {
    return run(search(dir / out, 1) + " --time '1 ms' --set gates.max_spacing_ratio=" + ratio, dir);
  };
  EXPECT_EQ(gated("refined", "0.45"), 5);
  EXPECT_NE(mv::read_file(dir / "stderr").find("again with mesh.spacing = 1.7 mm"), std::string::npos) << mv::read_file(dir / "stderr");
  EXPECT_EQ(rows_of(dir / "refined/trials.csv").size(), 1u);
  EXPECT_NE(mv::read_file(dir / "refined/trial_01/case/case.toml").find("spacing = \"1.7 mm\""), std::string::npos);

  EXPECT_EQ(gated("hopeless", "0.1"), 5);
  const std::string error = mv::read_file(dir / "stderr"), again = "again with mesh.spacing";
  int times = 0;
  for (auto at = error.find(again); at != std::string::npos; at = error.find(again, at + 1)) ++times;
  EXPECT_EQ(times, 3);
  EXPECT_NE(error.find("leaflets.spacing_max"), std::string::npos) << error;
  EXPECT_FALSE(std::filesystem::exists(dir / "hopeless/trials.csv"));
}

TEST(Layout, what_cannot_be_searched_is_refused) {
  const TemporaryDirectory dir;
  EXPECT_EQ(run(search(dir / "a", 2) + " --set chordae.model=none", dir), 3);
  EXPECT_EQ(run(search(dir / "a", 2) + " --mvsolve /nowhere/mvsolve", dir), 7);
  EXPECT_EQ(run(search(dir / "a", 0), dir), 2);
}
