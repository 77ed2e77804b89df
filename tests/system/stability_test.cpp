// SPDX-License-Identifier: BSD-3-Clause
// `mvsolve stability` on a few quick cases: every kind of end is told apart, one bad case makes exit code 6.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>

#include "geometry/core/case_files.h"
#include "geometry/core/parallel.h"
#include "solver/study/scene_alteration.h"
#include "solver/study/stability.h"

namespace {

namespace fs = std::filesystem;
using mv::Verdict;

mv::StabilityCase quick(const std::string& name, double end = 0.01) {
  mv::StabilityCase c;
  c.name = name;
  c.axis = "quick";
  c.geometry = {"mesh.spacing=2 mm", "tube.spacing=4 mm"};
  c.settings = {"pressure.rise_time=5 ms", "time.step_max=100 us"};
  c.end = end;
  c.behaviour = mv::Behaviour::rests;
  return c;
}

mv::StabilityCase refused(const std::string& name, std::function<void(mv::Scene&)> alter) {
  mv::StabilityCase c = quick(name);
  c.alter = std::move(alter);
  c.expected = mv::Expected::refused;
  return c;
}

struct Stability : testing::Test {
  mv::StabilityOptions options;
  Stability() {
    options.output = fs::temp_directory_path() / ("mv_stability_" + std::to_string(::getpid()));
    options.mvprep = fs::path(MV_BIN_DIR) / "mvprep";
    mv::set_thread_count(1);
  }
  ~Stability() override { fs::remove_all(options.output); }
};

TEST_F(Stability, sound_and_refused_cases_end_with_code_0_a_table_and_a_page) {
  std::vector<mv::StabilityCase> cases{quick("sound")};
  cases.push_back(refused("crossing", [](mv::Scene& scene) {
    scene.config.set("gates.min_dihedral=0 deg");
    mv::bring_together(scene, 30);
  }));
  cases.push_back(refused("squashed", [](mv::Scene& scene) { mv::squash_elements(scene, 1); }));
  cases.push_back(refused("inverted", [](mv::Scene& scene) {
    scene.config.set("gates.min_dihedral=0 deg");
    mv::squash_elements(scene, -1);
  }));
  cases.push_back(refused("outside", [](mv::Scene& scene) {
    for (mv::Vec2& p : scene.tube.cross_section) p *= 0.7;
  }));
  cases.push_back(refused("memory", [](mv::Scene& scene) { scene.tube.grid_cells = {4000, 4000, 4000}; }));
  cases.push_back(refused("by_mvprep", {}));
  cases.back().geometry.push_back("tube.spacing=1 mm");
  cases.push_back(refused("no_cut", {}));
  cases.back().settings = {"chordae.cut=[999]"};
  cases.push_back(refused("heavy", {}));
  cases.back().settings = {"leaflet.density=9000 kg/m3"};
  cases.push_back(refused("too_soft", {}));
  cases.back().settings = {"leaflet.bulk=1 Pa"};
  const auto rows = mv::run_stability(cases, options);
  ASSERT_EQ(rows.size(), cases.size());
  EXPECT_EQ(rows[0].judgement.verdict, Verdict::stable) << rows[0].judgement.reason;
  const std::vector<std::pair<std::size_t, const char*>> words{{1, "cross"},        {2, "dihedral"}, {3, "inverted"},  {4, "outside"}, {5, "memory"},
                                                               {6, "fluid spacing"}, {7, "cut"},      {8, "density"}, {9, "Poisson"}};
  for (const auto& [row, word] : words) {
    EXPECT_EQ(rows[row].judgement.verdict, Verdict::refused) << rows[row].stability_case.name << ": " << rows[row].judgement.reason;
    EXPECT_NE(rows[row].judgement.reason.find(word), std::string::npos) << rows[row].judgement.reason;
    EXPECT_EQ(rows[row].outcome.steps, 0);
  }
  EXPECT_EQ(mv::exit_code_of(rows), mv::ExitCode::done);
  const std::string csv = mv::read_file(options.output / "stability.csv"), page = mv::read_file(options.output / "stability.html");
  EXPECT_EQ(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')), cases.size() + 1);
  for (const auto& c : cases) {
    EXPECT_NE(csv.find("\n" + c.name + ","), std::string::npos) << c.name;
    EXPECT_NE(page.find("<code>" + c.name + "</code>"), std::string::npos) << c.name;
  }
}

TEST_F(Stability, a_case_that_diverges_or_crashes_is_recorded_alone_and_gives_code_6) {
  std::vector<mv::StabilityCase> cases{quick("sound")};
  // The blood's grid ends where the leaflets are, the case does not say so.
  cases.push_back(quick("stopped"));
  cases.back().alter = [](mv::Scene& scene) { scene.tube.grid_cells[2] /= 2; };
  cases.push_back(quick("crashed"));
  cases.back().alter = [](mv::Scene&) { std::abort(); };
  cases.push_back(refused("ran_although", {}));
  const auto rows = mv::run_stability(cases, options);
  ASSERT_EQ(rows.size(), cases.size());
  EXPECT_EQ(rows[0].judgement.verdict, Verdict::stable) << rows[0].judgement.reason;
  EXPECT_EQ(rows[1].judgement.verdict, Verdict::unstable);
  EXPECT_NE(rows[1].judgement.reason.find("cannot go on"), std::string::npos) << rows[1].judgement.reason;
  EXPECT_GT(rows[1].outcome.rollbacks, 0);
  EXPECT_EQ(rows[2].judgement.verdict, Verdict::crashed);
  EXPECT_NE(rows[2].judgement.reason.find("signal"), std::string::npos) << rows[2].judgement.reason;
  EXPECT_EQ(rows[3].judgement.verdict, Verdict::unexpected);
  EXPECT_EQ(mv::bad_count(rows), 3);
  EXPECT_EQ(mv::exit_code_of(rows), mv::ExitCode::not_trustworthy);
}

TEST_F(Stability, a_case_that_hangs_or_is_late_is_ended) {
  options.case_seconds = 0.2;
  std::vector<mv::StabilityCase> cases{quick("late", 10), quick("hung")};
  cases.back().alter = [](mv::Scene&) {
    while (true) pause();
  };
  const auto rows = mv::run_stability(cases, options);
  ASSERT_EQ(rows.size(), 2u);
  for (const auto& row : rows) EXPECT_EQ(row.judgement.verdict, Verdict::hung) << row.judgement.reason;
  EXPECT_NE(rows[0].judgement.reason.find("reached"), std::string::npos) << rows[0].judgement.reason;
}

}  // namespace
