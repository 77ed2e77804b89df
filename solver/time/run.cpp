// SPDX-License-Identifier: BSD-3-Clause
#include "solver/time/run.h"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <deque>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "geometry/core/log.h"
#include "geometry/core/parallel.h"
#include "geometry/core/version.h"
#include "solver/output/contact_map.h"
#include "solver/output/frame_writer.h"
#include "solver/report/report.h"
#include "solver/solid/stress.h"
#include "solver/time/checkpoint.h"
#include "solver/time/summarize.h"

namespace mv {
namespace {

using Clock = std::chrono::steady_clock;
constexpr double leak_window = 0.05;       // s, over which the net leak is averaged
constexpr double progress_seconds = 2.0;   // wall time between two progress lines

std::string hash_of_case(const Scene& scene) {
  // A finished run may be resumed to a later end.
  Config config = scene.config;
  config.set("time.end=1 s");
  std::string text = config.to_toml();
  for (const char* file : {"leaflets.vtu", "tube.vtu", "annulus.vtp", "papillary.vtp"}) text += sha256_of_file(scene.directory / file);
  for (const char* key : {"annulus.motion", "papillary.motion"})
    if (!scene.config.text(key).empty()) text += sha256_of_file(scene.config.path(key));
  if (scene.has_chordae()) text += sha256_of_file(scene.directory / "chordae.vtp");
  return sha256(text);
}

/// Instants n * period; the counter n is part of the checkpoint.
double instant(long n, double period) { return static_cast<double>(n) * period; }

/// Vectors as the xyz-interleaved numbers they are in memory.
std::span<const double> flat(const std::vector<Vec3>& v) { return {v.empty() ? nullptr : v.front().data(), 3 * v.size()}; }

class Recorder {
 public:
  Recorder(Simulation& simulation, const std::filesystem::path& results, double resume_time)
      : simulation_(simulation),
        results_(results),
        frames_(results, simulation.scene().mesh, simulation.scene().chordae, simulation.scene().annulus,
                SolverFrame{simulation.scene().tube.origin, simulation.scene().tube.axes}, resume_time),
        series_(results, resume_time) {
    if (simulation.scene().has_chordae()) chordae_.emplace(results, simulation.scene().chordae, resume_time);
  }

  void series(const State& state, const std::string& limiter, double leak_net) {
    const ContactMeasure contact = measure_contact(simulation_, state, true);
    SeriesRow row = measure_series(simulation_, state, contact);
    row.limiter = limiter;
    row.leak_net_ml_s = leak_net;
    series_.append(row);
    if (chordae_) chordae_->append(state.time, simulation_.structure().chordae()->tensions());
    peak_velocity = std::max(peak_velocity, std::isfinite(row.peak_velocity_m_s) ? row.peak_velocity_m_s : 0.0);
    volume_drift_max = std::max(volume_drift_max, std::abs(row.solid_volume_drift));
  }

  void leaflets(State& state) {
    simulation_.refresh(state);
    const ContactMeasure contact = measure_contact(simulation_, state);
    const std::size_t points = contact.gap.size();
    const ElementStress stress = element_stress(simulation_.structure().solid(), std::span<const double>(state.x.data(), 3 * points));
    LeafletsState frame;
    frame.time = state.time;
    frame.positions = std::span<const double>(state.x.data(), 3 * points);
    frame.velocities = std::span<const double>(state.v.data(), 3 * points);
    if (simulation_.structure().contact()) {
      frame.contact_forces = flat(contact.force);
      frame.contact_pressures = contact.traction;
    }
    frame.von_mises = stress.von_mises;
    frame.fibre_stresses = stress.fibre_stress;
    frame.fibre_strains = stress.fibre_strain;
    frame.volume_ratios = stress.J;
    frames_.write_leaflets(frame);
    if (const ChordaeTension* chordae = simulation_.structure().chordae()) {
      ChordaeState chordae_frame;
      chordae_frame.time = state.time;
      std::vector<Vec3> tree;
      chordae->point_positions(state.x, simulation_.structure().tips(), tree);
      chordae_frame.positions = flat(tree);
      chordae_frame.tensions = chordae->tensions();
      frames_.write_chordae(chordae_frame);
    }
  }

  void fluid(const State& state) {
    const NavierStokes* fluid = simulation_.fluid();
    if (!fluid) return;
    const FluidGrid& grid = fluid->grid();
    FluidState frame;
    frame.time = state.time;
    frame.grid = {grid.lower, grid.n, grid.h};
    const auto sy = static_cast<std::size_t>(grid.stride_y()), sz = static_cast<std::size_t>(grid.stride_z());
    frame.velocity = [&, sy, sz](int i, int j, int k) {
      const std::size_t p = static_cast<std::size_t>(grid.index(i, j, k));
      const auto& u = state.flow.velocity.c;
      return Vec3(0.5 * (u[0][p] + u[0][p + 1]), 0.5 * (u[1][p] + u[1][p + sy]), 0.5 * (u[2][p] + u[2][p + sz]));
    };
    frame.pressure = [&](int i, int j, int k) { return state.flow.pressure[static_cast<std::size_t>(grid.index(i, j, k))]; };
    const auto& open = fluid->wall().stencil[2].open;
    frame.is_blood = [&](int i, int j, int) { return open[static_cast<std::size_t>((i + FluidGrid::ghosts) + grid.padded(0) * (j + FluidGrid::ghosts))] > 0; };
    frames_.write_fluid(frame);
  }

  void contact_map(const ContactMeasure& contact) {
    write_contact_map(results_ / "contact_map.vtp",
                      make_contact_map(simulation_.scene().mesh, contact.traction, flat(contact.force), contact.gap, contact.in_contact));
  }

  double peak_velocity = 0, volume_drift_max = 0;

 private:
  Simulation& simulation_;
  std::filesystem::path results_;
  FrameWriter frames_;
  SeriesWriter series_;
  std::optional<ChordaeSeriesWriter> chordae_;
};

void copy_case_files(const Scene& scene, const std::filesystem::path& results) {
  for (const char* name : {"quality.json", "manifest.json"})
    if (std::filesystem::exists(scene.directory / name)) write_text_atomically(results / "case" / name, read_file(scene.directory / name));
  write_text_atomically(results / "case" / "case.toml", scene.config.to_toml());
}

void write_run_json(const RunOptions& options, const Scene& scene, const std::string& case_hash) {
  Json run;
  run["program"] = "mvsolve";
  run["version"] = version();
  run["revision"] = git_revision();
  run["libraries"] = library_versions();
  run["command"] = options.command_line;
  run["case_sha256"] = case_hash;
  run["threads"] = thread_count();
  Json settings = Json::array();
  for (const std::string& s : options.settings) settings.push_back(s);
  run["settings"] = settings;
  Json inputs = Json::object();
  for (const char* file : {"case.toml", "leaflets.vtu", "chordae.vtp", "tube.vtu", "annulus.vtp", "papillary.vtp"})
    if (std::filesystem::exists(scene.directory / file)) inputs[file] = sha256_of_file(scene.directory / file);
  run["inputs_sha256"] = inputs;
  write_json(options.results / "run.json", run);
}

/// Mean over the last `leak_window` of backward flow less what the leaflets sweep.
class LeakWindow {
 public:
  void add(double time, double passed_net) {
    samples_.emplace_back(time, passed_net);
    while (samples_.size() > 2 && time - samples_[1].first >= leak_window) samples_.pop_front();
  }
  std::vector<std::pair<double, double>> samples() const { return {samples_.begin(), samples_.end()}; }
  double span() const { return samples_.size() < 2 ? 0.0 : samples_.back().first - samples_.front().first; }
  /// Difference of the averages over both ends' oscillations would need their period; a least-squares slope damps them as well.
  double rate() const {
    if (samples_.size() < 2) return 0.0;
    double t_mean = 0, v_mean = 0;
    for (const auto& [t, v] : samples_) {
      t_mean += t;
      v_mean += v;
    }
    t_mean /= static_cast<double>(samples_.size());
    v_mean /= static_cast<double>(samples_.size());
    double covariance = 0, variance = 0;
    for (const auto& [t, v] : samples_) {
      covariance += (t - t_mean) * (v - v_mean);
      variance += (t - t_mean) * (t - t_mean);
    }
    return variance > 0 ? covariance / variance : 0.0;
  }

 private:
  std::deque<std::pair<double, double>> samples_;
};

}  // namespace

RunEnd run_case(const RunOptions& options) {
  Simulation simulation(load_scene(options.case_directory, options.settings));
  const Scene& scene = simulation.scene();
  const Config& config = scene.config;
  const std::string case_hash = hash_of_case(scene);
  const auto checkpoint_file = options.results / "checkpoint" / "state.bin";

  State state;
  Checkpoint progress;
  if (options.is_resumed) {
    progress = read_checkpoint(checkpoint_file);
    if (progress.case_hash != case_hash)
      throw InputError(fmt::format("{}: belongs to another case or other settings; run without --resume, or with the settings of the first run", checkpoint_file.string()));
    if (progress.state.time > config.number("time.end") + 1e-12)
      throw InputError(fmt::format("{}: is at {:.6f} s, beyond time.end; run without --resume, or with a later time.end", checkpoint_file.string(), progress.state.time));
    state = progress.state;
    if (progress.has_snapshot) simulation.restore_snapshot(progress.snapshot);
    spdlog::info("resuming at {:.6f} s, step {}", state.time, state.step);
  } else {
    state = simulation.initial_state();
  }
  std::error_code code;
  std::filesystem::create_directories(options.results / "case", code);
  if (code) throw IoError(fmt::format("{}: cannot be created: {}", options.results.string(), code.message()));
  for (const char* stale : {"summary.json", "report.html", "contact_map.vtp"}) std::filesystem::remove(options.results / stale, code);
  if (!options.is_resumed) std::filesystem::remove_all(options.results / "checkpoint", code);
  copy_case_files(scene, options.results);
  write_run_json(options, scene, case_hash);
  Recorder recorder(simulation, options.results, options.is_resumed ? state.time : -1.0);

  const double end = config.number("time.end");
  const double series_every = config.number("output.series_every"), frames_every = config.number("output.frames_every");
  const double fluid_every = config.number("output.fluid_every"), checkpoint_every = config.number("output.checkpoint_every");
  LeakWindow leak;
  if (options.is_resumed)
    for (const auto& [t, v] : progress.leak_samples) leak.add(t, v);
  const double wall_before = progress.wall_seconds;
  recorder.peak_velocity = progress.peak_velocity;
  recorder.volume_drift_max = progress.volume_drift_max;
  const auto start = Clock::now();
  auto wall = [&] { return wall_before + std::chrono::duration<double>(Clock::now() - start).count(); };
  auto last_line = start;
  const double time_at_start = state.time;
  std::string limiter = progress.limiter, reason;
  double leak_time = progress.leak_time_before, leak_volume = progress.leak_volume_before;

  auto save = [&] {
    progress.state = state;
    progress.has_snapshot = simulation.snapshot() != nullptr;
    if (progress.has_snapshot) progress.snapshot = *simulation.snapshot();
    progress.leak_time_before = leak_time;
    progress.leak_volume_before = leak_volume;
    progress.leak_samples = leak.samples();
    progress.peak_velocity = recorder.peak_velocity;
    progress.volume_drift_max = recorder.volume_drift_max;
    progress.limiter = limiter;
    progress.wall_seconds = wall();
    progress.case_hash = case_hash;
    write_checkpoint(checkpoint_file, progress);
  };

  bool is_interrupted = false;
  while (true) {
    // Everything that is due at this instant.
    const double slack = 1e-12;
    const auto output_start = Clock::now();
    if (state.time >= instant(progress.next_series, series_every) - slack) {
      const double passed = state.volume_backward - state.volume_swept;
      const double rate = state.time > leak_time ? (passed - leak_volume) / (state.time - leak_time) : 0.0;
      leak_time = state.time;
      leak_volume = passed;
      leak.add(state.time, passed);
      recorder.series(state, limiter, 1e6 * rate);
      ++progress.next_series;
    }
    if (state.time >= instant(progress.next_frame, frames_every) - slack) {
      recorder.leaflets(state);
      ++progress.next_frame;
    }
    if (simulation.fluid() && state.time >= instant(progress.next_fluid, fluid_every) - slack) {
      recorder.fluid(state);
      ++progress.next_fluid;
    }
    if (state.time >= instant(progress.next_checkpoint, checkpoint_every) - slack) {
      ++progress.next_checkpoint;
      save();
    }
    simulation.times().output += std::chrono::duration<double>(Clock::now() - output_start).count();
    if (state.time >= end - slack) break;
    if (options.is_interrupted && *options.is_interrupted) {
      is_interrupted = true;
      break;
    }

    const double stop = std::min({end, instant(progress.next_series, series_every), instant(progress.next_frame, frames_every),
                                  simulation.fluid() ? instant(progress.next_fluid, fluid_every) : end, instant(progress.next_checkpoint, checkpoint_every)});
    try {
      const std::string now = simulation.step(state, stop);
      if (now != "output") limiter = now;
    } catch (const TrustError& error) {
      reason = error.what();
      break;
    }
    const auto instant_now = Clock::now();
    if (std::chrono::duration<double>(instant_now - last_line).count() > progress_seconds) {
      last_line = instant_now;
      const double used = std::chrono::duration<double>(instant_now - start).count();
      const double left = state.time > time_at_start ? used * (end - state.time) / (state.time - time_at_start) : 0.0;
      spdlog::info("t {:.4f} of {:.4f} s  step {}  dt {:.2f} us ({})  flow {:+.1f} ml/s  about {:.0f} s left", state.time, end, state.step, 1e6 * state.dt,
                   limiter, -1e6 * state.flow_rate, left);
    }
  }

  if (is_interrupted) {
    save();
    spdlog::warn("interrupted at {:.6f} s, step {}; go on with: mvsolve run {} -o {} --resume", state.time, state.step, options.case_directory.string(),
                 options.results.string());
    return RunEnd::interrupted;
  }

  const auto output_start = Clock::now();
  if (!reason.empty()) recorder.leaflets(state);
  if (!reason.empty()) recorder.fluid(state);
  simulation.refresh(state);
  const ContactMeasure contact = measure_contact(simulation, state);
  if (simulation.structure().contact()) recorder.contact_map(contact);
  RunFacts facts;
  facts.leak_rate = leak.rate();
  facts.leak_window = leak.span();
  facts.peak_velocity = recorder.peak_velocity;
  facts.volume_drift_max = recorder.volume_drift_max;
  facts.end = reason.empty() ? "finished" : reason;
  simulation.times().output += std::chrono::duration<double>(Clock::now() - output_start).count();
  facts.wall_seconds = wall();
  Summary summary = summarize(simulation, state, contact, facts);
  std::vector<std::string> failed = failed_trust_gates(summary);
  if (!reason.empty()) failed.insert(failed.begin(), reason);
  Json gates = Json::array();
  for (const std::string& f : failed) gates.push_back(f);
  summary.set("trust.passed", failed.empty());
  summary.set("trust.failed", gates);
  summary.write(options.results / "summary.json");
  write_report(options.results);
  if (!failed.empty()) throw TrustError(fmt::format("{}: not trustworthy: {}", options.results.string(), fmt::join(failed, "; ")));
  return RunEnd::finished;
}

}  // namespace mv
