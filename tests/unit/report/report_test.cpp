// SPDX-License-Identifier: BSD-3-Clause
#include "solver/report/report.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "solver/report/figures_data.h"
#include "solver/report/html.h"
#include "solver/report/page.h"
#include "solver/report/verdict.h"
#include "support/synthetic_results.h"

namespace fs = std::filesystem;
using namespace mv;

namespace {

constexpr test::SyntheticOptions small{.columns = 72, .rows = 10};

class Report : public testing::Test {
 protected:
  void SetUp() override {
    results_ =
        fs::temp_directory_path() / ("mv_report_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(results_);
  }
  void TearDown() override { fs::remove_all(results_); }
  std::string make(const test::SyntheticOptions& options = small) {
    test::write_synthetic_results(results_, options);
    return read_file(write_report(results_));
  }
  fs::path results_;
};

bool has(const std::string& page, const std::string& text) { return page.find(text) != std::string::npos; }

std::size_t times(const std::string& page, const std::string& text) {
  std::size_t n = 0;
  for (std::size_t at = page.find(text); at != std::string::npos; at = page.find(text, at + 1)) ++n;
  return n;
}

TEST_F(Report, page_holds_every_section_and_figure_and_loads_nothing) {
  std::string page = make();
  for (const char* part : {"id=\"verdict\"",
                           "id=\"numbers\"",
                           "id=\"map\"",
                           "id=\"views\"",
                           "id=\"flow\"",
                           "id=\"contact\"",
                           "id=\"chordae\"",
                           "id=\"trust\"",
                           "id=\"mesh\"",
                           "id=\"settings\"",
                           "id=\"fig-map\"",
                           "id=\"fig-flow\"",
                           "id=\"fig-contact\"",
                           "id=\"fig-chordae\"",
                           "id=\"fig-chordae-bars\"",
                           "id=\"fig-energy\"",
                           "id=\"fig-step\"",
                           "leaflets.dihedral_min_deg",
                           "21.7 deg",
                           "≥ 10",
                           "gcc 12.2.0",
                           "aaaaaaaaaaaaaaaaaaaa"})
    EXPECT_TRUE(has(page, part)) << part;
  EXPECT_TRUE(has(page, "<strong class=\"word\">Sealed</strong>"));
  EXPECT_EQ(times(page, "data:image/png;base64,"), 8u);
  for (const char* picture :
       {"open_atrial", "closed_atrial", "closed_ventricular", "closed_cut", "contact_map", "overview", "stress_atrial"})
    EXPECT_GT(fs::file_size(results_ / "pictures" / (std::string(picture) + ".png")), 5000u) << picture;
  EXPECT_EQ(read_file(write_report(results_)), page) << "the same results must give the same bytes";

  // what it is given is escaped
  EXPECT_TRUE(has(page, "synthetic &lt;valve&gt; &amp; co"));
  EXPECT_FALSE(has(page, "synthetic <valve>"));
  EXPECT_FALSE(has(page, "# <spacing>"));
  // outside the plotting library there is no address at all
  page.erase(page.find(assets::plotly_js), assets::plotly_js.size());
  EXPECT_FALSE(has(page, "http"));
  EXPECT_FALSE(has(page, " src=\"") && !has(page, " src=\"data:"));
  EXPECT_EQ(times(page, "<script"), 3u);
  EXPECT_EQ(times(page, "</script>"), 3u);
}

TEST_F(Report, holes_are_told_by_place_and_area) {
  const std::string page = make({.is_sealed = false, .columns = 72, .rows = 10});
  EXPECT_TRUE(has(page, "Leaks through 2 holes"));
  EXPECT_TRUE(has(page, "between A2 and P2 (9.1 mm²"));
  EXPECT_TRUE(has(page, "posteromedial commissure (2.5 mm²"));
  EXPECT_TRUE(has(page, "seal only at a threshold above 2.9 mm"));
  EXPECT_TRUE(has(page, "The contact belt is interrupted: anterior leaflet, u 14.2 to 21.6 mm"));
  // a hole between two leaflets is drawn on both
  const Json figures = figure_data(read_results(results_), std::nullopt, 1);
  ASSERT_EQ(figures["holes"][0]["u"].size(), 2u);
  EXPECT_NEAR(figures["holes"][0]["u"][0].get<double>(), 36 + 71.2 / 2, 3);
  EXPECT_NEAR(figures["holes"][0]["u"][1].get<double>(), 18, 3);
  EXPECT_EQ(figures["interruptions"].size(), 1u);
}

TEST_F(Report, a_scene_without_fluid_and_chordae_has_its_page_too) {
  const std::string page = make({.has_fluid = false, .has_chordae = false, .columns = 72, .rows = 10});
  EXPECT_TRUE(has(page, "The scene has no fluid"));
  EXPECT_TRUE(has(page, "No chordae in this scene"));
  EXPECT_FALSE(has(page, "id=\"fig-chordae\""));
}

TEST_F(Report, a_summary_alone_is_enough_and_missing_parts_are_said) {
  fs::create_directories(results_);
  write_text_atomically(results_ / "summary.json", R"({"run": {"end": "element 12 inverted"}})");
  const std::string page = read_file(write_report(results_));
  EXPECT_TRUE(has(page, "No verdict"));
  EXPECT_TRUE(has(page, "element 12 inverted"));
  for (const char* missing :
       {"contact_map.vtp is not", "leaflets.pvd is not", "series.csv is not", "quality.json is not", "run.json is not"})
    EXPECT_TRUE(has(page, missing)) << missing;
}

TEST_F(Report, works_for_a_turned_valve_with_quadratic_elements) {
  const std::string page = make({.order = 2, .columns = 48, .rows = 6, .tilt_degrees = 40});
  EXPECT_EQ(times(page, "data:image/png;base64,"), 8u);
}

TEST_F(Report, missing_and_damaged_inputs_are_named) {
  EXPECT_THROW(write_report(results_), IoError);
  fs::create_directories(results_);
  EXPECT_THROW(write_report(results_), IoError);
  test::write_synthetic_results(results_, small);
  std::ofstream(results_ / "summary.json") << "{";
  EXPECT_THROW(write_report(results_), InputError);
  test::write_synthetic_results(results_, small);
  fs::resize_file(results_ / "contact_map.vtp", 700);
  EXPECT_THROW(write_report(results_), InputError);
}

TEST_F(Report, names_on_the_map_follow_the_papillary_tips) {
  test::write_synthetic_results(results_, small);
  ResultsData data = read_results(results_);
  // u = 0 lies at +x, where tip 0 is
  MapView view = make_map_view(*data.map, data.frames.open, data.frames.open_chordae);
  const auto u_of = [&](const std::string& name) {
    for (const MapLabel& label : view.labels)
      if (label.name == name) return label.u;
    return std::nan("");
  };
  EXPECT_NEAR(u_of("anterolateral commissure"), 0, 1e-6);
  EXPECT_NEAR(u_of("posteromedial commissure"), 36, 1.5);
  EXPECT_NEAR(u_of("A2"), 18, 1);
  EXPECT_NEAR(u_of("P3"), 36 + 71.2 / 6, 2);
  EXPECT_NEAR(u_of("P2"), 36 + 71.2 / 2, 2);
  EXPECT_NEAR(u_of("P1"), 36 + 71.2 * 5 / 6, 2);
  std::swap(data.frames.open_chordae->points[0], data.frames.open_chordae->points[1]);
  view = make_map_view(*data.map, data.frames.open, data.frames.open_chordae);
  EXPECT_NEAR(u_of("P1"), 36 + 71.2 / 6, 2);
  EXPECT_NEAR(u_of("posteromedial commissure"), 0, 1e-6);
  view = make_map_view(*data.map, data.frames.open, std::nullopt);
  EXPECT_TRUE(std::isnan(u_of("anterolateral commissure")));
}

TEST_F(Report, the_drawn_belt_encloses_the_contact) {
  test::write_synthetic_results(results_, small);
  const ResultsData data = read_results(results_);
  const MapView view = make_map_view(*data.map, std::nullopt, std::nullopt);
  ASSERT_FALSE(view.belt.empty());
  const MapGrid grid = sample_map(*data.map, 0.2);
  double sampled = 0, sampled_contact = 0, area = 0;
  for (std::size_t c = 0; c < grid.region.size(); ++c) {
    sampled += grid.region[c] != 0 ? 0.04 : 0;
    sampled_contact += grid.pressure[c] > 0 ? 0.04 : 0;
  }
  for (const auto& t : data.map->triangles) {
    const Vec2 a = data.map->points[static_cast<std::size_t>(t[1])] - data.map->points[static_cast<std::size_t>(t[0])];
    const Vec2 b = data.map->points[static_cast<std::size_t>(t[2])] - data.map->points[static_cast<std::size_t>(t[0])];
    area += std::abs(a.x() * b.y() - a.y() * b.x()) / 2;
  }
  EXPECT_NEAR(sampled, area, 0.01 * area);
  EXPECT_GT(sampled_contact, 0.2 * area);
  EXPECT_LT(sampled_contact, 0.6 * area);
}

TEST(VerdictTest, failed_gates_take_the_trust_away) {
  Summary s;
  s.set("seal.sealed", true);
  s.set("seal.threshold_mm", 0.6);
  s.set("energy.residual_relative", 0.02);
  EXPECT_TRUE(make_verdict(s.json()).is_trustworthy);
  EXPECT_EQ(make_verdict(s.json()).word, "Sealed");
  s.set("energy.residual_relative", -0.2);
  EXPECT_FALSE(make_verdict(s.json()).is_trustworthy);
  EXPECT_EQ(make_verdict(s.json()).word, "Sealed, but not trustworthy");
  s.set("trust.passed", true);  // the run's own judgement decides; the failed check is still said
  EXPECT_TRUE(make_verdict(s.json()).is_trustworthy);
  EXPECT_EQ(make_verdict(s.json()).sentences.back(), "1 check is outside the limit.");
  s.set("run.end", "step too small");
  EXPECT_FALSE(make_verdict(s.json()).is_trustworthy);
  EXPECT_EQ(make_verdict(s.json()).sentences.front(), "The run ended early: step too small.");
  s.set("run.end", "finished");
  s.set("trust.passed", false);
  s.set("trust.failed", Json{"2 pairs cross"});
  EXPECT_FALSE(make_verdict(s.json()).is_trustworthy);
  const auto sentences = make_verdict(s.json()).sentences;
  EXPECT_NE(std::find(sentences.begin(), sentences.end(), "Not trustworthy: 2 pairs cross."), sentences.end());
  EXPECT_EQ(make_verdict(Json::object()).finding, Finding::none);
}

TEST(HtmlTest, numbers_and_scripts_are_safe) {
  EXPECT_EQ(html::number(104880), "104880");
  EXPECT_EQ(html::number(0.123456), "0.123");
  EXPECT_EQ(html::number(0.123456, html::exact), "0.123456");
  EXPECT_EQ(html::number(371.49), "371");
  EXPECT_EQ(html::number(-2.345), "-2.35");
  EXPECT_EQ(html::number(NAN), "–");
  EXPECT_EQ(html::number(-0.0), "0");
  EXPECT_EQ(html::script_json(Json{{"a", "</script><!--"}}), "{\"a\":\"\\u003c/script>\\u003c!--\"}");
  EXPECT_EQ(html::value(Json{1.5, 2.5}), "1.5, 2.5");
  EXPECT_EQ(html::escape("<a href=\"x\">&"), "&lt;a href=&quot;x&quot;&gt;&amp;");
}

TEST(ScaleTest, rounds_up_to_readable_numbers) {
  EXPECT_DOUBLE_EQ(round_up_nicely(13), 15);
  EXPECT_DOUBLE_EQ(round_up_nicely(0.021), 0.025);
  EXPECT_DOUBLE_EQ(round_up_nicely(8), 8);
  EXPECT_DOUBLE_EQ(round_up_nicely(8.1), 10);
  EXPECT_DOUBLE_EQ(round_up_nicely(0), 1);
}

}  // namespace
