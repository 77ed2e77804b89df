// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/bench.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "geometry/core/parallel.h"
#include "solver/study/sheet.h"
#include "solver/study/triad.h"

namespace mv {
namespace {

Scene small_scene() {
  SheetShape shape;
  shape.fluid_mm = 4;
  shape.solid_mm = 2;
  return sheet_scene(shape, {"time.step_max=20 us"});
}

TEST(Bench, parts_of_a_step_add_up_to_the_step) {
  Simulation simulation(small_scene());
  const State from = bring_to(simulation, 0.002);
  EXPECT_NEAR(from.time, 0.002, 1e-12);
  const StepTiming timing = time_steps(simulation, from, 100, 3);
  double sum = 0;
  for (double s : timing.part) sum += s;
  std::printf("wall %.4g ms, parts %.4g ms\n", 1e3 * timing.wall, 1e3 * sum);
  EXPECT_GT(sum, 0.5 * timing.wall);
  EXPECT_LT(sum, 1.2 * timing.wall);
  EXPECT_NEAR(timing.dt, 20e-6, 1e-12);
  EXPECT_EQ(timing.part[3], 0);  // no contact in this scene
  EXPECT_EQ(timing.part[4], 0);  // no chordae
}

TEST(Bench, the_timed_steps_end_the_same_with_one_thread_and_two) {
  const int before = thread_count();
  Simulation simulation(small_scene());
  set_thread_count(1);
  const State from = bring_to(simulation, 0.001);
  const State one = time_steps(simulation, from, 20, 1).end;
  set_thread_count(2);
  const State two = time_steps(simulation, from, 20, 1).end;
  set_thread_count(before);
  EXPECT_GT(one.step, from.step);
  EXPECT_EQ(one.x, two.x);
  EXPECT_EQ(one.flow.pressure, two.flow.pressure);
}

TEST(Bench, growth_and_bandwidth_shares_of_made_up_rows) {
  BenchResult result;
  for (double n : {1e3, 8e3}) {
    BenchRow row;
    row.scene = n < 2e3 ? "small" : "large";
    row.size.cells = row.size.grid_values = n;
    row.size.nodes = n / 2;
    row.size.elements = 2 * n;
    row.size.surface_nodes = n / 4;
    row.timing.part = {n * 1e-9, n * std::sqrt(n) * 1e-9, 2e-6, n * n * 1e-9, 0, 0, 0};
    row.timing.wall = 1e-3;
    row.triad = 1e10;
    row.bytes = least_bytes(row.size);
    result.rows.push_back(row);
  }
  const auto exponents = growth(result.rows, 1);
  EXPECT_NEAR(exponents[0], 1, 1e-12);
  EXPECT_NEAR(exponents[1], 1.5, 1e-12);
  EXPECT_NEAR(exponents[2], 0, 1e-12);
  EXPECT_NEAR(exponents[3], 2, 1e-12);
  EXPECT_TRUE(std::isnan(growth(result.rows, 7)[0]));
  EXPECT_DOUBLE_EQ(result.rows[0].bytes[0], 21 * 8 * 1e3);
  EXPECT_DOUBLE_EQ(result.rows[0].bytes[1], 12 * 8 * 1e3 + 29 * 8 * 500);
  const std::string page = bench_page(result, "mvsolve bench -o <DIR>"), csv = bench_csv(result);
  for (const char* text : {"Time per step by part", "Share of the memory-bandwidth limit", "exponent, smallest to largest", "&lt;DIR&gt;"}) EXPECT_NE(page.find(text), std::string::npos) << text;
  EXPECT_EQ(page.find("<script"), std::string::npos);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 3);
  EXPECT_EQ(std::count(csv.begin(), csv.begin() + static_cast<long>(csv.find('\n')), ','), std::count(csv.rbegin(), csv.rbegin() + static_cast<long>(csv.size() - csv.rfind('\n', csv.size() - 2)), ','));
}

TEST(Bench, triad_is_a_plausible_bandwidth) {
  const double bandwidth = triad_bandwidth(2);
  EXPECT_GT(bandwidth, 5e8);
  EXPECT_LT(bandwidth, 5e12);
}

TEST(Bench, a_part_that_is_off_leaves_no_time_behind) {
  std::vector<ScenePart> rows(3);
  rows[0].name = "full scene";
  rows[1].name = "no <blood>";
  rows[1].setting = "fluid.enabled=false";
  rows[2].name = "no fibres";
  rows[2].setting = "fibers.model=none";
  rows[2].part = 2;
  rows[2].failure = "elements are inverted";
  rows[0].timing.wall = 4e-3;
  rows[0].timing.part = {1e-3, 2e-3, 1e-3, 0, 0, 0, 0};
  rows[1].timing.wall = 1e-3;
  rows[1].timing.part = {0, 0, 1e-3, 0, 0, 0, 0};
  const std::string html = scene_parts_html(rows), csv = scene_parts_csv(rows);
  EXPECT_NE(html.find("no &lt;blood&gt;"), std::string::npos);
  EXPECT_NE(html.find("75 %"), std::string::npos);
  EXPECT_NE(html.find("elements are inverted"), std::string::npos);
  EXPECT_NE(csv.find("no <blood>,fluid.enabled=false,1,0,0,1,0,0,0,0,3,0"), std::string::npos) << csv;
}

}  // namespace
}  // namespace mv
