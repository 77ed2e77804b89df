// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/closure_ladder.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <mutex>
#include <thread>
#include <utility>

#include "geometry/core/case_files.h"
#include "geometry/core/config.h"
#include "geometry/core/errors.h"
#include "geometry/core/log.h"
#include "solver/output/summary.h"
#include "solver/study/case_maker.h"
#include "solver/study/quantities.h"
#include "solver/study/richardson.h"
#include "solver/study/timed_process.h"

namespace mv {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
constexpr double systole = 0.3;  // s
constexpr const char* resolution_axis = "resolution";

/// What makes two runs the same; not which revision made the case.
std::string hash_of(const fs::path& case_directory, const std::vector<std::string>& settings) {
  std::string text = Config::from_file(case_directory / "case.toml").to_toml();
  for (const char* file : {"leaflets.vtu", "chordae.vtp", "tube.vtu", "annulus.vtp", "papillary.vtp"}) text += sha256_of_file(case_directory / file) + "\n";
  for (const std::string& s : settings) text += s + "\n";
  return sha256(text);
}

struct Record {
  std::string hash, revision, failure;
  double seconds = 0;
};

bool read_record(const fs::path& file, Record& record) {
  if (!fs::exists(file)) return false;
  const Json json = read_json(file);
  record.hash = json.value("hash", "");
  record.revision = json.value("revision", "");
  record.failure = json.value("failure", "");
  record.seconds = json.value("processor_s", 0.0);
  return true;
}

/// Why the numbers of a finished run are not to be trusted, or why there are none.
std::string failure_of(const fs::path& results, int exit_code) {
  if (exit_code == 0) return "";
  std::string why = fmt::format("mvsolve ended with code {}", exit_code);
  if (fs::exists(results / "summary.json")) {
    const Json failed = json_at(read_json(results / "summary.json"), "trust.failed");
    if (failed.is_array() && !failed.empty()) {
      why.clear();
      for (const Json& f : failed) why += (why.empty() ? "" : "; ") + f.get<std::string>();
    }
  }
  return why;
}

bool has_finished(const fs::path& results) {
  if (!fs::exists(results / "summary.json")) return false;
  const Json end = json_at(read_json(results / "summary.json"), "run.end");
  return end.is_string() && end.get<std::string>() == "finished";
}

/// Work of a rung relative to others, as measured: cells grow with 1/h^3, elements and contact with 1/h^2, steps with less than 1/h as long as the largest step limits
/// the open valve.
double relative_work(const ClosureMesh& mesh) {
  const double steps = 1 / std::sqrt(mesh.fluid_mm), fluid = steps / std::pow(mesh.fluid_mm, 3), solid = steps / std::pow(2 * mesh.solid_mm, 2);
  return 0.3 * fluid + 0.7 * solid * (mesh.order == 2 ? 12 : 1);
}

class LadderRunner {
 public:
  explicit LadderRunner(const LadderOptions& options) : options_(options), start_(Clock::now()) {}

  std::vector<StudyRow> run() {
    const std::vector<Rung> rungs = closure_ladder(options_);
    rows_.resize(rungs.size());
    for (std::size_t i = 0; i < rungs.size(); ++i) {
      StudyRow& row = rows_[i];
      row.run = rungs[i].name;
      row.axis = rungs[i].axis;
      row.what = rungs[i].what;
      row.mesh = rungs[i].mesh;
      row.settings = rungs[i].settings;
    }
    std::vector<std::thread> workers;
    for (int j = 1; j < options_.jobs; ++j) workers.emplace_back([this] { work(); });
    work();
    for (std::thread& w : workers) w.join();
    if (error_) std::rethrow_exception(error_);
    return std::move(rows_);
  }

 private:
  void work() {
    try {
      while (true) {
        std::size_t mine;
        {
          const std::lock_guard lock(mutex_);
          if (next_ >= rows_.size() || error_) return;
          mine = next_++;
        }
        do_rung(rows_[mine]);
      }
    } catch (...) {
      const std::lock_guard lock(mutex_);
      error_ = std::current_exception();
    }
  }

  MadeCase make_case(const StudyRow& row) {
    const std::lock_guard lock(case_mutex_);
    return CaseMaker(options_.output, options_.mvprep).make(mesh_name(row.mesh), closure_case_toml(row.mesh));
  }

  /// Seconds that a rung may take, from those that are done; 0 when nothing is known.
  double expected(const StudyRow& row) {
    double best = 0;
    for (std::size_t i = 0; i < next_ && i < rows_.size(); ++i)
      if (rows_[i].has_values) best = rows_[i].seconds * relative_work(row.mesh) / relative_work(rows_[i].mesh);
    return best;
  }

  void do_rung(StudyRow& row) {
    const fs::path results = options_.output / "runs" / row.run, record_file = results / "study.json";
    const MadeCase made = make_case(row);
    if (!made.is_made()) {
      row.failure = "the case cannot be made: " + made.error;
      spdlog::warn("{}: {}", row.run, row.failure);
      return;
    }
    std::vector<std::string> settings = ladder_settings(options_);
    settings.insert(settings.end(), row.settings.begin(), row.settings.end());
    Record record;
    const std::string hash = hash_of(made.directory, settings);
    if (options_.is_fresh || !read_record(record_file, record) || record.hash != hash) {
      double left, needed;
      bool is_first;
      {
        const std::lock_guard lock(mutex_);
        is_first = !std::exchange(has_run_, true);
        left = options_.budget - std::chrono::duration<double>(Clock::now() - start_).count();
        needed = expected(row);
      }
      // One run at least, or there would be nothing to estimate the others from.
      const bool fits = needed > 0 ? needed <= left : is_first || left > 0;
      if (!fits) {
        row.failure = fmt::format("left out: it needs about {:.0f} s, the budget has {:.0f} s left", needed, std::max(left, 0.0));
        spdlog::warn("{}: {}", row.run, row.failure);
        return;
      }
      spdlog::info("{}: {}{}", row.run, row.what, needed > 0 ? fmt::format(", about {:.0f} s", needed) : "");
      record = run_rung(row, made.directory, results, settings, hash);
    }
    row.seconds = record.seconds;
    row.revision = record.revision;
    row.failure = record.failure;
    if (has_finished(results)) {
      row.values = read_quantities(results, options_.window);
      const std::lock_guard lock(mutex_);
      row.has_values = true;
    } else if (row.failure.empty()) {
      row.failure = "the run did not reach its end";
    }
    spdlog::info("{}: {:.0f} s{}{}", row.run, row.seconds, row.failure.empty() ? "" : ", ", row.failure);
  }

  Record run_rung(const StudyRow& row, const fs::path& case_directory, const fs::path& results, const std::vector<std::string>& settings, const std::string& hash) {
    std::error_code code;
    fs::remove_all(results, code);
    fs::create_directories(results, code);
    if (code) throw IoError(fmt::format("{}: cannot be created: {}", results.string(), code.message()));
    std::vector<std::string> arguments{"run", case_directory.string(), "-o", results.string(), "--threads", "1"};
    for (const std::string& s : settings) arguments.insert(arguments.end(), {"--set", s});
    const ProcessOutcome outcome = run_timed(own_program(), arguments, options_.output / "runs" / (row.run + ".log"));
    if (outcome.exit_code == 130 || outcome.exit_code == 128 + 2) throw TrustError(row.run + ": interrupted");
    Record record{hash, "", failure_of(results, outcome.exit_code), outcome.processor_seconds};
    if (fs::exists(results / "run.json")) record.revision = read_json(results / "run.json").value("revision", "");
    write_json(results / "study.json", {{"hash", record.hash},
                                        {"revision", record.revision},
                                        {"failure", record.failure},
                                        {"exit_code", outcome.exit_code},
                                        {"processor_s", outcome.processor_seconds},
                                        {"wall_s", outcome.wall_seconds},
                                        {"threads", 1}});
    return record;
  }

  const LadderOptions& options_;
  Clock::time_point start_;
  std::vector<StudyRow> rows_;
  std::size_t next_ = 0;
  bool has_run_ = false;   // a run was started or found not to fit
  std::mutex mutex_, case_mutex_;
  std::exception_ptr error_;
};

}  // namespace

std::vector<std::string> ladder_settings(const LadderOptions& options) {
  // The same gap counts as contact on every grid. Fewer fluid frames and checkpoints: they are not what is timed.
  return {fmt::format("time.end={:.9g} s", options.end), "contact.threshold=1 mm", "output.frames_every=5 ms", "output.fluid_every=1 s", "output.checkpoint_every=1 s"};
}

std::vector<Rung> closure_ladder(const LadderOptions& options) {
  std::vector<Rung> rungs;
  const auto& levels = options.spacings_mm;
  for (double h : levels) {
    const ClosureMesh mesh{h, 0.5 * h, 1};
    rungs.push_back({mesh_name(mesh), resolution_axis, fmt::format("fluid {:g} mm, solid {:g} mm", h, 0.5 * h), mesh, {}});
  }
  if (!options.has_variations || levels.empty()) return rungs;
  auto vary = [&](double h, const char* axis, const std::string& suffix, const std::string& what, std::vector<std::string> settings) {
    const ClosureMesh mesh{h, 0.5 * h, 1};
    rungs.push_back({mesh_name(mesh) + "-" + suffix, axis, fmt::format("{} at {:g} mm", what, h), mesh, std::move(settings)});
  };
  const double h = levels.size() > 1 ? levels[1] : levels[0];
  vary(h, "step", "safety0.9", "time.safety 0.9", {"time.safety=0.9"});
  vary(h, "step", "safety0.4", "time.safety 0.4", {"time.safety=0.4"});
  vary(h, "step", "step100", "steps to 100 us", {"time.step_max=100 us"});
  vary(h, "kernel", "ib3", "kernel ib3", {"fluid.kernel=ib3"});
  vary(h, "kernel", "cbs32", "kernel cbs32", {"fluid.kernel=cbs32"});
  vary(h, "coupling", "faces", "annulus held by faces", {"coupling.annulus=faces"});
  vary(h, "coupling", "interpolation", "interpolation, relaxed", {"coupling.scheme=interpolation"});
  vary(h, "coupling", "plain", "interpolation, no relaxation", {"coupling.scheme=interpolation", "coupling.relaxation=false"});
  vary(h, "coupling", "drainage2.5", "drainage in 2.5 ms", {"coupling.drainage_time=2.5 ms"});
  vary(h, "search interval", "search1", "contact search every step", {"contact.search_every=1"});
  vary(h, "search interval", "search5", "contact search every 5 steps", {"contact.search_every=5"});
  auto mesh_rung = [&](const char* axis, const ClosureMesh& mesh, const std::string& what) { rungs.push_back({mesh_name(mesh), axis, what, mesh, {}}); };
  mesh_rung("solid spacing", {h, 0.75 * h, 1}, fmt::format("solid spacing {:g} mm at {:g} mm", 0.75 * h, h));
  mesh_rung("solid spacing", {h, std::round(100 * h / 3) / 100, 1}, fmt::format("solid spacing {:g} mm at {:g} mm", std::round(100 * h / 3) / 100, h));
  mesh_rung("solid order", {h, h, 2}, fmt::format("quadratic elements of {:g} mm at {:g} mm", h, h));
  // What saves time on the coarse grid is tried where it matters.
  for (std::size_t i = 2; i < levels.size(); ++i) {
    mesh_rung("solid spacing", {levels[i], 0.75 * levels[i], 1}, fmt::format("solid spacing {:g} mm at {:g} mm", 0.75 * levels[i], levels[i]));
    vary(levels[i], "kernel", "ib3", "kernel ib3", {"fluid.kernel=ib3"});
    vary(levels[i], "kernel", "cbs32", "kernel cbs32", {"fluid.kernel=cbs32"});
    vary(levels[i], "coupling", "faces", "annulus held by faces", {"coupling.annulus=faces"});
    vary(levels[i], "step", "step100", "steps to 100 us", {"time.step_max=100 us"});
    vary(levels[i], "step", "safety0.9", "time.safety 0.9", {"time.safety=0.9"});
  }
  return rungs;
}

void put_closure_reference(StudyTable& table) {
  table.quantities.clear();
  std::vector<const StudyRow*> levels;
  for (const StudyRow& row : table.rows)
    if (row.axis == resolution_axis && row.has_values) levels.push_back(&row);
  std::sort(levels.begin(), levels.end(), [](const StudyRow* a, const StudyRow* b) { return a->mesh.fluid_mm > b->mesh.fluid_mm; });
  if (levels.empty()) throw TrustError("no run of the resolution ladder has numbers");
  for (std::size_t q = 0; q < quantities().size(); ++q) {
    const Quantity& quantity = quantities()[q];
    StudyQuantity out{quantity.name, quantity.unit, quantity.title, quantity.how, levels.back()->values[q], std::nan(""), std::nan(""), std::string(quantity.name) == "leak", 1};
    double uncertainty = std::nan("");
    if (levels.size() >= 3) {
      std::array<double, 3> h{}, value{};
      for (std::size_t i = 0; i < 3; ++i) {
        h[i] = levels[levels.size() - 3 + i]->mesh.fluid_mm;
        value[i] = levels[levels.size() - 3 + i]->values[q];
      }
      const Richardson limit = richardson(h, value);
      uncertainty = limit.uncertainty;
      out.order = limit.order;
    } else if (levels.size() == 2) {
      uncertainty = std::abs(levels[1]->values[q] - levels[0]->values[q]);
    }
    if (out.is_leak) out.leak_scale = std::abs(table.quantities.front().reference) / systole;
    const double scale = out.is_leak ? out.leak_scale : std::abs(out.reference);
    out.uncertainty_percent = scale > 0 ? 100 * uncertainty / scale : std::nan("");
    table.quantities.push_back(out);
  }
  put_errors(table);
}

StudyTable closure_table(const LadderOptions& options) {
  StudyTable table;
  table.id = "closure";
  table.title = "Closure of the generic valve";
  table.rows = LadderRunner(options).run();
  put_closure_reference(table);
  return table;
}

}  // namespace mv
