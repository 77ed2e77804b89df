// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/layout.h"

#include <fmt/format.h>
#include <unistd.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <sstream>

#include "geometry/annulus/annulus_fit.h"
#include "geometry/chordae/chordae_file.h"
#include "geometry/chordae/chordae_grower.h"
#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "geometry/core/log.h"
#include "geometry/core/program.h"
#include "geometry/core/vtk_dataset.h"
#include "pipeline/case_directory.h"
#include "pipeline/layout_rules.h"
#include "pipeline/runner.h"
#include "pipeline/source_file.h"

namespace mv {
namespace {

namespace fs = std::filesystem;

constexpr double hole_memory = 8.0;  // mm: a hole of the next trial nearer than this is the same hole
constexpr double progress = 0.05;    // share by which a hole must shrink for a change to stay
constexpr const char* coarse_dihedral = "5 deg";  // of the trials' tetrahedra: long edges across thick leaflets are slender where these bend
constexpr int finer_meshes = 3;      // tried when the coarse one does not pass its gates
constexpr double finer = 0.85;       // each by this

/// Coarse but otherwise the user's case.
Config coarse_config(const LayoutOptions& options) {
  Config config = Config::from_file(options.config);
  for (const std::string& setting : options.settings) config.set(setting);
  const double fluid = parse_quantity(options.fluid_spacing, Dimension::length, "--fluid"), end = parse_quantity(options.time_end, Dimension::time, "--time");
  // Solid points as much nearer than half a fluid cell as the user's own case has them, for the same reason (faces of thick or bent leaflets are longer).
  const double coarser = fluid / config.number("tube.spacing");
  const long layers = config.integer("mesh.layers");
  config.set("tube.spacing=" + options.fluid_spacing);
  config.set(fmt::format("mesh.spacing={} mm", std::min(0.5 * fluid, coarser * config.number("mesh.spacing")) / unit_factor("mm")));
  config.set(fmt::format("mesh.layers={}", std::max(std::min(layers, 2L), std::lround(static_cast<double>(layers) / coarser))));
  if (config.number("gates.min_dihedral") > parse_quantity(coarse_dihedral, Dimension::angle, "gates.min_dihedral")) config.set(std::string("gates.min_dihedral=") + coarse_dihedral);
  if (config.number("time.end") > end) config.set("time.end=" + options.time_end);
  config.set(fmt::format("output.frames_every={} s", config.number("time.end")));
  config.set(fmt::format("output.fluid_every={} s", config.number("time.end")));
  return config;
}

/// Last file a collection names.
fs::path last_frame(const fs::path& results) {
  const std::string text = read_file(results / "leaflets.pvd");
  const auto found = text.rfind("file=\"");
  if (found == std::string::npos) throw InputError((results / "leaflets.pvd").string() + ": names no frame");
  const auto begin = found + 6;
  return results / text.substr(begin, text.find('"', begin) - begin);
}

std::vector<double> last_tensions(const fs::path& file, std::size_t segments) {
  std::istringstream in(read_file(file));
  std::string line, last;
  while (std::getline(in, line))
    if (!line.empty()) last = line;
  std::vector<double> values;
  std::istringstream row(last);
  for (std::string cell; std::getline(row, cell, ',');) values.push_back(std::strtod(cell.c_str(), nullptr));
  if (values.size() != segments + 1) throw InputError(file.string() + ": the last row does not hold one tension a segment");
  values.erase(values.begin());
  return values;
}

std::optional<LayoutObservation> observe(const fs::path& results, std::size_t segments) {
  if (!fs::exists(results / "summary.json")) return std::nullopt;
  const auto json = nlohmann::json::parse(read_file(results / "summary.json"));
  const auto value = [&](const std::string& name) -> nlohmann::json {
    if (json.contains(name)) return json.at(name);
    const auto dot = name.find('.');
    const std::string group = name.substr(0, dot), key = name.substr(dot + 1);
    return json.contains(group) && json.at(group).contains(key) ? json.at(group).at(key) : nlohmann::json();
  };
  if (!value("seal.hole_area_mm2").is_number()) return std::nullopt;
  LayoutObservation seen;
  seen.area = value("seal.hole_area_mm2").get<double>();
  for (const auto& hole : value("seal.holes")) {
    const auto& p = hole.at("place_mm");
    seen.holes.push_back({hole.at("location").get<std::string>(), Vec3(p[0].get<double>(), p[1].get<double>(), p[2].get<double>()), hole.at("area_mm2").get<double>()});
  }
  const fs::path frame = last_frame(results);
  const auto grid = read_unstructured_grid(frame);
  const auto x = DatasetReader(frame, grid).coordinates();
  for (std::size_t i = 0; i + 2 < x.size(); i += 3) seen.points.emplace_back(x[i], x[i + 1], x[i + 2]);
  seen.tension = last_tensions(results / "chordae.csv", segments);
  return seen;
}

struct Trial {
  int number = 0;
  int exit_code = 0;
  Chordae chordae;  // as the case holds it
  std::optional<LayoutObservation> seen;
  double area() const { return seen ? seen->area : std::numeric_limits<double>::max(); }
};

struct Attempt {
  LayoutHole hole;
  LayoutChange change;
};

class LayoutSearch {
 public:
  explicit LayoutSearch(const LayoutOptions& options) : options_(options), coarse_(coarse_config(options)) {
    if (options.mvsolve.empty()) {
      std::error_code code;
      mvsolve_ = fs::read_symlink("/proc/self/exe", code).parent_path() / "mvsolve";
    } else {
      mvsolve_ = options.mvsolve;
    }
    if (!fs::exists(mvsolve_)) throw IoError(mvsolve_.string() + ": no such program; build mvsolve beside mvprep or name it with --mvsolve");
    if (coarse_.text("chordae.model") == "none") throw ConfigError("chordae.model = \"none\": a layout needs chordae to start from; expected generic, density or file");
    std::error_code failure;
    fs::create_directories(options.directory, failure);
    if (failure) throw IoError(options.directory.string() + ": cannot be made: " + failure.message());
  }

  void run() {
    log_ = "trial,exit_code,hole_area_mm2,holes,kept,changes,places\n";
    find_mesh();
    Trial first = close(1, std::nullopt);
    note(first, true, {});
    best_ = first;
    prepare();
    for (int k = 2; k <= options_.trials && best_.area() > options_.target_area; ++k) {
      const std::vector<Attempt> attempts = next_attempts();
      if (attempts.empty()) break;
      Chordae next = best_.chordae;
      for (const Attempt& a : attempts) apply(next, a.change);
      write_chordae_csv(options_.directory / "next.csv", next);
      const Trial trial = close(k, options_.directory / "next.csv");
      judge(trial, attempts);
    }
    finish();
  }

 private:
  fs::path directory_of(int trial) const { return options_.directory / fmt::format("trial_{:02d}", trial); }

  Trial close(int number, const std::optional<fs::path>& network) {
    Config config = coarse_;
    if (network) use_file(config, fs::absolute(*network));
    const fs::path directory = directory_of(number), case_directory = directory / "case", results = directory / "results";
    fs::create_directories(directory);
    if (number > 1 && !fs::exists(case_directory)) fs::copy(directory_of(1) / "case", case_directory, fs::copy_options::recursive);  // only the chordae are made anew
    make_case(config, case_directory);
    fs::remove_all(results);
    Trial trial;
    trial.number = number;
    trial.exit_code = run_program(mvsolve_, {"run", case_directory.string(), "-o", results.string(), "--threads", std::to_string(options_.threads)}, directory / "mvsolve.log");
    trial.chordae = read_chordae(case_directory / "chordae.vtp");
    trial.seen = observe(results, trial.chordae.segments.size());
    if (!trial.seen && number == 1)
      throw TrustError(fmt::format("{}: mvsolve ended with code {} and no verdict, see {}", case_directory.string(), trial.exit_code, (directory / "mvsolve.log").string()));
    return trial;
  }

  void make_case(const Config& config, const fs::path& case_directory) const {
    Manifest manifest = read_manifest(case_directory);
    const Config resolved = set_up_case(config, options_.config, case_directory, manifest.inputs);
    run_all_stages(resolved, case_directory, manifest, std::nullopt, [](const StageReport&) {});
  }

  // The coarse mesh, finer where it does not pass its gates.
  void find_mesh() {
    for (int k = 0;; ++k) {
      try {
        make_case(coarse_, directory_of(1) / "case");
        return;
      } catch (const GateError& e) {
        if (k == finer_meshes) throw;
        const double spacing = finer * coarse_.number_in("mesh.spacing", "mm");
        std::string reason = e.what();  // a line a gate
        while (!reason.empty() && reason.back() == '\n') reason.pop_back();
        spdlog::info("the mesh of the trials does not pass: {}\nagain with mesh.spacing = {:.3g} mm", reason, spacing);
        coarse_.set(fmt::format("mesh.spacing={} mm", spacing));
      }
    }
  }

  static void use_file(Config& config, const fs::path& network) {
    config.set("chordae.model=file");
    config.set("chordae.file=" + network.string());
    config.set("chordae.file_unit=mm");
    config.set("chordae.file_space=ras");
    config.set("chordae.slack=1");
    config.set("chordae.removed=[]");
  }

  void prepare() {
    const fs::path directory = directory_of(1) / "case";
    mesh_ = read_leaflets(directory / "leaflets.vtu");
    annulus_ = read_annulus(directory / "annulus.vtp");
    papillary_ = read_papillary(directory / "papillary.vtp");
    chart_.emplace(mesh_);
    depth_ = coarse_.number_in("chordae.coaptation_depth", "mm") * read_source(directory / "mid_surface.vtp").scale;
  }

  std::vector<Attempt> next_attempts() {
    std::vector<Attempt> out;
    if (!best_.seen) return out;
    std::set<int> changed;
    for (const LayoutHole& hole : best_.seen->holes) {
      if (hole.area < 0.1 * best_.area()) continue;
      for (const LayoutChange& change : propose_changes(mesh_, *chart_, annulus_, best_.chordae, *best_.seen, hole)) {
        if (refused_.count(change.name())) continue;
        const bool overlaps = std::any_of(change.segments.begin(), change.segments.end(), [&](int s) { return changed.count(s) > 0; });
        Chordae probe = best_.chordae;
        if (overlaps || (change.action != LayoutChange::add && !change_lengths(probe, change))) continue;
        changed.insert(change.segments.begin(), change.segments.end());
        out.push_back({hole, change});
        break;
      }
    }
    return out;
  }

  void apply(Chordae& chordae, const LayoutChange& change) const {
    if (change.action != LayoutChange::add) {
      change_lengths(chordae, change);
      return;
    }
    std::vector<Vec3> heads;
    for (std::size_t p = 0; p < chordae.points.size(); ++p)
      if (chordae.muscle_of_point[p] >= 0) heads.push_back(chordae.points[p]);
    ChordaeGrower grower(mesh_, annulus_, papillary_, heads, {1.0, depth_, 40, true});
    int primaries = 1;
    for (const ChordaSegment& s : chordae.segments) primaries += s.kind == ChordaKind::primary;
    const double radius = influence_radius(chart_->border_length(), primaries, chart_->border_uv(change.arc).y());
    grower.grow({grower.border_end(change.arc, radius, 0.2)}, ChordaKind::primary, coarse_.number_in("chordae.area_primary", "mm2"), true);
    const Chordae& grown = grower.chordae();
    const int offset = static_cast<int>(chordae.points.size());
    chordae.points.insert(chordae.points.end(), grown.points.begin(), grown.points.end());
    chordae.muscle_of_point.insert(chordae.muscle_of_point.end(), grown.muscle_of_point.begin(), grown.muscle_of_point.end());
    for (ChordaSegment s : grown.segments) {
      s.a += offset;
      s.b += offset;
      chordae.segments.push_back(s);
    }
    for (Insertion i : grown.insertions) {
      i.point += offset;
      chordae.insertions.push_back(i);
    }
  }

  // What is left open near a hole of the best layout.
  static double area_near(const LayoutObservation& seen, const Vec3& place) {
    double sum = 0;
    for (const LayoutHole& h : seen.holes)
      if ((h.place - place).norm() < hole_memory) sum += h.area;
    return sum;
  }

  void judge(const Trial& trial, const std::vector<Attempt>& attempts) {
    const bool is_better = trial.area() < (1 - progress) * best_.area() || (trial.area() <= options_.target_area && trial.area() < best_.area());
    for (const Attempt& a : attempts) {
      const bool has_helped = trial.seen && area_near(*trial.seen, a.hole.place) < (1 - progress) * area_near(*best_.seen, a.hole.place);
      if (!has_helped || (!is_better && attempts.size() == 1)) refused_.insert(a.change.name());
    }
    // Several changes of which some helped: the others are now refused, so the next trial repeats the helpful ones alone.
    note(trial, is_better, attempts);
    if (is_better) best_ = trial;
    else if (std::all_of(attempts.begin(), attempts.end(), [&](const Attempt& a) { return !refused_.count(a.change.name()); }))
      for (const Attempt& a : attempts) refused_.insert(a.change.name());
  }

  void note(const Trial& trial, bool is_kept, const std::vector<Attempt>& attempts) {
    std::string changes, places;
    for (const Attempt& a : attempts) changes += (changes.empty() ? "" : "; ") + fmt::format("{} by {:.2g} mm at {} ({})", a.change.name(), a.change.amount, a.hole.location, a.change.reason);
    if (trial.seen)
      for (const LayoutHole& h : trial.seen->holes) places += (places.empty() ? "" : "; ") + fmt::format("{} {:.1f} mm2", h.location, h.area);
    const std::string area = trial.seen ? fmt::format("{:.2f}", trial.area()) : "";
    log_ += fmt::format("{},{},{},{},{},\"{}\",\"{}\"\n", trial.number, trial.exit_code, area, trial.seen ? trial.seen->holes.size() : 0, is_kept ? 1 : 0, changes, places);
    write_text_atomically(options_.directory / "trials.csv", log_);
    spdlog::info("trial {}: {} mm2 open{}{}; {}", trial.number, trial.seen ? area : "unknown", places.empty() ? "" : " at ", places, changes.empty() ? "as configured" : changes);
    write_best(is_kept ? trial : best_);
  }

  void write_best(const Trial& trial) const {
    write_chordae_csv(options_.directory / "layout.csv", trial.chordae);
    write_text_atomically(options_.directory / "layout.toml",
                          fmt::format("# Found by `mvprep layout`, trial {}: {:.2f} mm2 open on a fluid grid of {}.\n[chordae]\nmodel = \"file\"\nfile = \"layout.csv\"\nslack = 1\n", trial.number,
                                      trial.area(), options_.fluid_spacing));
  }

  void finish() const {
    const fs::path file = options_.directory / "layout.csv";
    if (std::fputs(fmt::format("trials = {}\nbest = trial {}\nhole_area_mm2 = {:.2f}\nlayout = {}\n", std::count(log_.begin(), log_.end(), '\n') - 1, best_.number, best_.area(), file.string()).c_str(),
                   stdout) < 0)
      throw IoError("cannot write to the standard output");
    if (best_.area() > options_.target_area)
      throw GateError(fmt::format("no layout within {:.2g} mm2 found: the best leaves {:.2f} mm2 open ({}); see {}, raise --trials, start from another chordae.model or "
                                  "chordae.border_density, or check whether the leaflets are large enough",
                                  options_.target_area, best_.area(), best_.seen && !best_.seen->holes.empty() ? best_.seen->holes[0].location : "no place", (options_.directory / "trials.csv").string()));
  }

  const LayoutOptions& options_;
  Config coarse_;
  fs::path mvsolve_;
  LeafletMesh mesh_;
  Annulus annulus_;
  Papillary papillary_;
  std::optional<LeafletChart> chart_;
  double depth_ = 5;
  Trial best_;
  std::set<std::string> refused_;
  std::string log_;
};

}  // namespace

void layout_command(const LayoutOptions& options) { LayoutSearch(options).run(); }

}  // namespace mv
