// SPDX-License-Identifier: BSD-3-Clause
// Tables, CSV and pages from made-up runs.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>
#include <sstream>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "solver/study/accuracy.h"
#include "solver/study/quantities.h"
#include "solver/study/svg_plot.h"
#include "unit/core/sample_case.h"

namespace mv {
namespace {

/// A closure table in which every quantity is (1 + h/100) times its limit, exactly first order; seconds grow with 1/h^4.
StudyTable made_up_closure() {
  StudyTable table;
  table.id = "closure";
  table.title = "Closure of the generic valve";
  for (double h : {3.0, 2.0, 1.5, 1.0}) {
    StudyRow row;
    row.mesh = {h, 0.5 * h, 1};
    row.run = mesh_name(row.mesh);
    row.axis = "resolution";
    row.what = "made up";
    row.seconds = 600 / (h * h * h * h);
    row.has_values = true;
    for (std::size_t q = 0; q < quantities().size(); ++q) row.values.push_back((q == 2 ? 0.0 : 10.0) * (1 + 0.01 * h) + (q == 2 ? 0.1 * h : 0.0));
    table.rows.push_back(row);
  }
  StudyRow fast = table.rows[1];
  fast.run = "f2-s1-fast";
  fast.axis = "step";
  fast.settings = {"time.safety=0.9"};
  fast.seconds *= 0.5;
  table.rows.push_back(fast);
  StudyRow broken = table.rows[1];
  broken.run = "f2-s1-broken";
  broken.axis = "coupling";
  broken.seconds = 1;
  broken.failure = "3 pairs of leaflet triangles <cross>";
  table.rows.push_back(broken);
  StudyRow missing;
  missing.run = "f2-s2-q";
  missing.axis = "solid order";
  missing.mesh = {2, 2, 2};
  missing.failure = "left out: it needs about 500 s";
  table.rows.push_back(missing);
  put_closure_reference(table);
  return table;
}

TEST(StudyTable, errors_hold_the_distance_to_the_reference_and_its_uncertainty) {
  const StudyTable table = made_up_closure();
  // Reference 10.1 at h = 1, limit 10: uncertainty 1.25 * 0.1.
  EXPECT_NEAR(table.quantities[0].reference, 10.1, 1e-12);
  EXPECT_NEAR(table.quantities[0].order, 1, 1e-4);
  EXPECT_NEAR(table.quantities[0].uncertainty_percent, 100 * 0.125 / 10.1, 1e-4);
  EXPECT_NEAR(table.rows[1].errors[0], 100 * 0.1 / 10.1 + 100 * 0.125 / 10.1, 1e-4);
  EXPECT_NEAR(table.rows[3].errors[0], table.quantities[0].uncertainty_percent, 1e-12);
  // The leak by what it adds in 0.3 s: 0.1 ml/s more on 10.1 ml.
  EXPECT_NEAR(table.rows[1].errors[2] - table.quantities[2].uncertainty_percent, 100 * 0.1 * 0.3 / 10.1, 1e-9);
}

TEST(StudyTable, untrusted_and_missing_runs_are_never_on_a_front_nor_recommended) {
  const StudyTable table = made_up_closure();
  const auto front = pareto_front(cost_errors(table, 0));
  EXPECT_EQ(front, (std::vector<std::size_t>{0, 4, 2, 3}));  // 3 mm, fast, 1.5 mm, 1 mm; the plain 2 mm run is beaten by the fast one
  const auto recommended = recommended_settings(table);
  ASSERT_EQ(recommended.size(), 3u);
  EXPECT_EQ(recommended[0].run, "f3-s1.5");     // 5 %: 3.2 % for all
  EXPECT_EQ(recommended[1].run, "f1.5-s0.75");  // 2 %: 1.73 %
  EXPECT_EQ(recommended[2].run, "f1-s0.5");     // 1 %: 1.24 %, out of reach, and the best there is
  EXPECT_EQ(recommended[0].met.size(), quantities().size());
}

TEST(StudyTable, csv_has_one_row_a_run_and_quantity_and_reads_back) {
  const StudyTable table = made_up_closure();
  const mv_test::TemporaryDirectory directory;
  std::string csv = study_csv_head() + study_csv_rows(table);
  EXPECT_EQ(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')), 1 + table.rows.size() * table.quantities.size());
  std::istringstream lines(csv);
  std::string line;
  std::getline(lines, line);
  const auto columns = std::count(line.begin(), line.end(), ',');
  int on_front = 0;
  while (std::getline(lines, line)) {
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), columns) << line;
    on_front += line.find(",closing_volume,") != std::string::npos && line.find(",yes,yes,") != std::string::npos;
  }
  EXPECT_EQ(on_front, 4);
  EXPECT_NE(csv.find("closure,f2-s1-fast,\"step\",2,1,1,\"time.safety=0.9\",18.75,1,closing_volume,ml,10.2,10.1,"), std::string::npos);
}

TEST(AccuracyPage, says_what_to_use_and_loads_nothing) {
  AccuracyResult result;
  result.closure = made_up_closure();
  result.recommended = recommended_settings(result.closure);
  AccuracyOptions options;
  options.command_line = "mvsolve accuracy -o \"DIR\"";
  const std::string page = accuracy_page(result, options);
  for (const char* text : {"What to use", "f1.5-s0.75", "left out: it needs about 500 s", "leaflet triangles &lt;cross&gt;", "Median of all quantities", "Fibre stress, trigones", "Runs without numbers"})
    EXPECT_NE(page.find(text), std::string::npos) << text;
  for (const char* text : {"<cross>", "http://cdn", "https://", "<script", "nan", "src="}) EXPECT_EQ(page.find(text), std::string::npos) << text;
  // One panel a quantity and the median, one front line each.
  std::size_t panels = 0, at = 0;
  while ((at = page.find("<svg", at)) != std::string::npos) ++panels, ++at;
  EXPECT_EQ(panels, quantities().size() + 1);
}

TEST(SvgPlot, marks_points_at_the_place_of_their_values) {
  Plot plot;
  plot.title = "t & t";
  plot.points = {{1, 1, "a <b>", "", "#000000", Marker::circle, true}, {100, 10, "c", "", "#000000", Marker::circle, false}, {std::nan(""), 1, "gone", "", "", Marker::circle, false}};
  const std::string text = svg(plot);
  EXPECT_NE(text.find("t &amp; t"), std::string::npos);
  EXPECT_NE(text.find("a &lt;b&gt;"), std::string::npos);
  EXPECT_EQ(text.find("gone"), std::string::npos);
  EXPECT_EQ(text.find("nan"), std::string::npos);
  // On a logarithmic axis 10 lies halfway between 1 and 100.
  plot.points = {{1, 1, "", "", "#000", Marker::circle, true}, {10, 1, "", "", "#000", Marker::circle, true}, {100, 1, "", "", "#000", Marker::circle, true}};
  std::vector<double> x;
  const std::string three = svg(plot);
  for (std::size_t at = 0; (at = three.find("cx=\"", at)) != std::string::npos; ++at) x.push_back(std::stod(three.substr(at + 4)));
  ASSERT_EQ(x.size(), 3u);
  EXPECT_NEAR(x[1] - x[0], x[2] - x[1], 0.11);
  EXPECT_GT(x[1], x[0]);
}

TEST(Recommended, percent_is_read_and_nonsense_refused) {
  EXPECT_DOUBLE_EQ(parse_percent("2%"), 2);
  EXPECT_DOUBLE_EQ(parse_percent("0.5 %"), 0.5);
  for (const char* wrong : {"2", "", "%", "two%", "-1%", "0%", "200%", "2%x", "nan%"}) EXPECT_THROW(parse_percent(wrong), UsageError) << wrong;
}

TEST(Recommended, entry_is_the_largest_listed_error_not_above_the_asked_one) {
  const auto table = recommended_settings(made_up_closure());
  EXPECT_EQ(entry_for(table, 5).run, "f3-s1.5");
  EXPECT_EQ(entry_for(table, 30).run, "f3-s1.5");
  EXPECT_EQ(entry_for(table, 3).run, "f1.5-s0.75");
  EXPECT_THROW(entry_for(table, 0.5), ConfigError);
  try {
    entry_for(table, 1);  // every quantity but the leak is above it
    EXPECT_EQ(entry_for(table, 1).met, (std::vector<std::string>{"leak"}));
  } catch (const ConfigError&) {
    FAIL() << "the leak is within 1 %";
  }
  auto hopeless = table;
  hopeless[2].met.clear();
  EXPECT_THROW(entry_for(hopeless, 1), ConfigError);
}

TEST(Recommended, a_case_that_is_too_coarse_is_refused_with_what_mvprep_needs) {
  const mv_test::TemporaryDirectory directory;
  auto table = recommended_settings(made_up_closure());
  table[1].settings = {"fluid.kernel=ib3"};
  write_text_atomically(directory / "case.toml", "[tube]\nspacing = \"2 mm\"\n[mesh]\nspacing = \"1 mm\"\n");
  EXPECT_TRUE(settings_for_accuracy(directory.path(), 5, table).empty());
  try {
    settings_for_accuracy(directory.path(), 2, table);
    FAIL() << "2 mm was taken for 2 %";
  } catch (const ConfigError& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("--set tube.spacing=\"1.5 mm\" --set mesh.spacing=\"0.75 mm\""), std::string::npos) << message;
  }
  write_text_atomically(directory / "case.toml", "[tube]\nspacing = \"1.5 mm\"\n[mesh]\nspacing = \"0.75 mm\"\n");
  EXPECT_EQ(settings_for_accuracy(directory.path(), 2, table), (std::vector<std::string>{"fluid.kernel=ib3"}));
  // Quadratic elements of twice the size have their points as near.
  write_text_atomically(directory / "case.toml", "[tube]\nspacing = \"1.5 mm\"\n[mesh]\nspacing = \"1.5 mm\"\norder = 2\n");
  EXPECT_EQ(settings_for_accuracy(directory.path(), 2, table).size(), 1u);
}

TEST(Recommended, toml_and_source_carry_the_table) {
  const auto table = recommended_settings(made_up_closure());
  const std::string toml = recommended_toml(table, "mvsolve accuracy -o DIR"), source = recommended_source(table, "mvsolve accuracy -o DIR");
  EXPECT_NE(toml.find("asked_percent = 2\nrun = \"f1.5-s0.75\"\ntube.spacing = \"1.5 mm\""), std::string::npos) << toml;
  EXPECT_NE(source.find("{2, \"f1.5-s0.75\", 1.5, 0.75, 1, {}"), std::string::npos) << source;
  EXPECT_NE(source.find("mvsolve accuracy -o DIR --table"), std::string::npos);
}

TEST(Ladder, names_are_unique_and_levels_come_first) {
  LadderOptions options;
  const auto rungs = closure_ladder(options);
  std::set<std::string> names;
  for (const Rung& rung : rungs) EXPECT_TRUE(names.insert(rung.name).second) << rung.name;
  for (std::size_t i = 0; i < options.spacings_mm.size(); ++i) EXPECT_EQ(rungs[i].axis, "resolution");
  // Every level has the same tube: 40 and 20 mm (the defaults of tube.length_ventricle and tube.length_atrium) in whole cells.
  for (double h : options.spacings_mm)
    for (double length : {40.0, 20.0}) EXPECT_NEAR(length / h, std::round(length / h), 1e-9) << h;
  std::set<std::string> axes;
  for (const Rung& rung : rungs) axes.insert(rung.axis);
  EXPECT_EQ(axes, (std::set<std::string>{"resolution", "solid spacing", "solid order", "step", "kernel", "coupling", "search interval"}));
}

}  // namespace
}  // namespace mv
