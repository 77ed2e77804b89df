// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// mvsolve bench: what a step costs, by part, size and threads, against the machine's memory bandwidth.

#include <filesystem>
#include <string>
#include <vector>

#include "solver/output/summary.h"
#include "solver/study/byte_model.h"
#include "solver/study/scene_parts.h"

namespace mv {

struct BenchOptions {
  std::filesystem::path output;
  std::filesystem::path case_directory;       // the user's own case; empty: the generic valve at `spacings_mm`
  std::filesystem::path mvprep;               // empty: beside mvsolve
  std::vector<double> spacings_mm{3, 2, 1.5}; // fluid; the solid has half of it
  std::vector<int> threads;                   // empty: 1, 2, 4, ... up to the threads in use
  int steps = 100, repeats = 3;
  double at = 0.06;                           // s, the instant that is timed: the generic valve is closed by then
  bool has_scene_parts = true;                // time what a scene leaves out as well
  std::string command_line;
};

/// One scene with one thread count.
struct BenchRow {
  std::string scene;
  int threads = 1;
  SceneSize size;
  StepTiming timing;
  double triad = 0;                             // bytes/s with these threads
  std::array<double, part_count> bytes{};       // least traffic a step
  std::array<double, part_count> share{};       // of the bandwidth limit, NaN for parts without a count
  double share_total = 0;                       // counted bytes over what the triad moves in the time of the counted parts
  double x_difference = 0;                      // m, u: m/s, p: Pa: largest difference to the first thread count after the timed steps
  double u_difference = 0, p_difference = 0;
};

struct BenchResult {
  std::vector<BenchRow> rows;
  std::vector<ScenePart> parts;
  std::string parts_scene;
  int steps = 0, repeats = 0;
  double at = 0;
};

/// Exponents b of time = a n^b between the smallest and the largest scene of one thread count, n the part's own measure: grid values for fluid, nodes for coupling,
/// elements for tissue, surface nodes for contact. NaN with one size only.
std::array<double, part_count> growth(const std::vector<BenchRow>& rows, int threads);

/// Measures; no files but the cases.
BenchResult measure_bench(const BenchOptions& options);

std::string bench_csv(const BenchResult& result);
Json bench_json(const BenchResult& result);
std::string bench_page(const BenchResult& result, const std::string& command);
/// What goes to stdout.
std::string bench_text(const BenchResult& result);

/// measure_bench, then DIR/bench.csv, bench.json, scene_parts.csv, bench.svg and bench.html. Returns the result.
BenchResult run_bench(const BenchOptions& options);

}  // namespace mv
