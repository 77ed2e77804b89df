// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "geometry/core/log.h"
#include "geometry/core/parallel.h"
#include "solver/study/case_maker.h"
#include "solver/study/closure_case.h"
#include "solver/study/triad.h"

namespace mv {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t counted_parts = 4;  // fluid, coupling, tissue, contact have a byte count

/// Restores the thread count when it goes.
struct ThreadScope {
  int before = thread_count();
  ~ThreadScope() { set_thread_count(before); }
};

std::vector<int> thread_ladder(const BenchOptions& options) {
  if (!options.threads.empty()) return options.threads;
  std::vector<int> out;
  for (int t = 1; t < thread_count(); t *= 2) out.push_back(t);
  out.push_back(thread_count());
  return out;
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.size() != b.size()) return std::numeric_limits<double>::infinity();
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double d = std::abs(a[i] - b[i]);
    if (!(d <= largest)) largest = d;  // NaN too
  }
  return largest;
}

void compare(BenchRow& row, const State& first, const State& now) {
  row.x_difference = largest_difference(first.x, now.x);
  for (std::size_t c = 0; c < 3; ++c) row.u_difference = std::max(row.u_difference, largest_difference(first.flow.velocity.c[c], now.flow.velocity.c[c]));
  row.p_difference = largest_difference(first.flow.pressure, now.flow.pressure);
}

void put_shares(BenchRow& row) {
  row.bytes = least_bytes(row.size);
  row.share.fill(nan);
  double bytes = 0, seconds = 0;
  for (std::size_t p = 0; p < counted_parts; ++p) {
    if (!(row.bytes[p] > 0) || !(row.timing.part[p] > 0)) continue;
    row.share[p] = row.bytes[p] / row.triad / row.timing.part[p];
    bytes += row.bytes[p];
    seconds += row.timing.part[p];
  }
  row.share_total = seconds > 0 ? bytes / row.triad / seconds : nan;
}

void bench_scene(const BenchOptions& options, const std::string& name, const std::filesystem::path& directory, bool has_parts, BenchResult& result) {
  const ThreadScope scope;
  Simulation simulation(load_scene(directory));
  spdlog::info("{}: advancing to {:g} ms", name, 1e3 * options.at);
  const State from = bring_to(simulation, options.at);
  State first;
  for (int threads : thread_ladder(options)) {
    set_thread_count(threads);
    BenchRow row;
    row.scene = name;
    row.threads = thread_count();
    row.triad = triad_bandwidth();
    row.timing = time_steps(simulation, from, options.steps, options.repeats);
    row.size = size_of(simulation);
    put_shares(row);
    if (first.x.empty()) first = row.timing.end;
    compare(row, first, row.timing.end);
    row.timing.end = State();
    spdlog::info("{}, {} threads: {:.3g} ms a step", name, row.threads, 1e3 * row.timing.wall);
    result.rows.push_back(std::move(row));
  }
  if (!has_parts) return;
  // One thread: what is compared are differences of a few per cent.
  set_thread_count(1);
  result.parts = time_scene_parts(directory, options.at, options.steps, options.repeats, &from);
  result.parts_scene = name;
}

double measure_of(const SceneSize& size, std::size_t part) {
  switch (part) {
    case 0: return size.grid_values;
    case 1: return size.nodes;
    case 2: return size.elements;
    case 3: return size.surface_nodes;
    default: return size.nodes;
  }
}

}  // namespace

std::array<double, part_count> growth(const std::vector<BenchRow>& rows, int threads) {
  std::array<double, part_count> out;
  out.fill(nan);
  const BenchRow *smallest = nullptr, *largest = nullptr;
  for (const BenchRow& row : rows) {
    if (row.threads != threads) continue;
    if (!smallest || row.size.nodes < smallest->size.nodes) smallest = &row;
    if (!largest || row.size.nodes > largest->size.nodes) largest = &row;
  }
  if (!smallest || smallest == largest) return out;
  for (std::size_t p = 0; p < part_count; ++p) {
    const double n = measure_of(largest->size, p) / measure_of(smallest->size, p), t = largest->timing.part[p] / smallest->timing.part[p];
    if (n > 1 && t > 0 && std::isfinite(t)) out[p] = std::log(t) / std::log(n);
  }
  return out;
}

BenchResult measure_bench(const BenchOptions& options) {
  BenchResult result;
  result.steps = options.steps;
  result.repeats = options.repeats;
  result.at = options.at;
  if (!options.case_directory.empty()) {
    bench_scene(options, options.case_directory.filename().empty() ? options.case_directory.parent_path().filename().string() : options.case_directory.filename().string(),
                options.case_directory, options.has_scene_parts, result);
    return result;
  }
  CaseMaker maker(options.output, options.mvprep);
  for (double spacing : options.spacings_mm) {
    const ClosureMesh mesh{spacing, 0.5 * spacing, 1};
    const MadeCase made = maker.make(mesh_name(mesh), closure_case_toml(mesh));
    if (!made.is_made()) throw InputError(fmt::format("the case with a fluid spacing of {:g} mm cannot be made: {}", mesh.fluid_mm, made.error));
    bench_scene(options, fmt::format("generic valve, {:g} mm", mesh.fluid_mm), made.directory, false, result);
  }
  if (options.has_scene_parts) {
    const ThreadScope scope;
    set_thread_count(1);
    const double middle = options.spacings_mm[options.spacings_mm.size() / 2];
    result.parts = time_generic_scene_parts(options.output, options.mvprep, middle, options.at, options.steps, options.repeats);
    result.parts_scene = fmt::format("generic valve, {:g} mm", middle);
  }
  return result;
}

BenchResult run_bench(const BenchOptions& options) {
  std::error_code code;
  std::filesystem::create_directories(options.output, code);
  if (code) throw IoError(fmt::format("{}: cannot be created: {}", options.output.string(), code.message()));
  BenchResult result = measure_bench(options);
  write_text_atomically(options.output / "bench.csv", bench_csv(result));
  write_json(options.output / "bench.json", bench_json(result));
  if (!result.parts.empty()) write_text_atomically(options.output / "scene_parts.csv", scene_parts_csv(result.parts));
  write_text_atomically(options.output / "bench.html", bench_page(result, options.command_line));
  return result;
}

}  // namespace mv
