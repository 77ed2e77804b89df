// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/scene_parts.h"

#include <fmt/format.h>

#include <cmath>

#include "geometry/core/errors.h"
#include "geometry/core/log.h"
#include "solver/output/series.h"
#include "solver/report/html.h"
#include "solver/study/case_maker.h"
#include "solver/study/closure_case.h"
#include "solver/study/svg_plot.h"

namespace mv {
namespace {

struct Variant {
  const char* name;
  const char* setting;
  std::size_t part;
};

constexpr std::size_t fluid = 0, coupling = 1, tissue = 2, contact = 3, chordae = 4;

const Variant variants[] = {
    {"full scene", "", fluid},
    {"no blood", "fluid.enabled=false", fluid},
    {"no contact", "contact.enabled=false", contact},
    {"no friction", "contact.friction=0", contact},
    {"contact on inner faces only", "contact.faces=inner", contact},
    {"no chordae", "chordae.model=none", chordae},
    {"no fibres", "fibers.model=none", tissue},
    {"no distortion control", "leaflet.distortion_factor=0", tissue},
    {"interpolation, no film drainage", "coupling.scheme=interpolation", coupling},
    {"no relaxation", "coupling.relaxation=false", coupling},
    {"neither drainage nor relaxation", "coupling.scheme=interpolation;coupling.relaxation=false", coupling},
};

std::vector<std::string> split(const std::string& settings) {
  std::vector<std::string> out;
  for (std::size_t at = 0; at < settings.size();) {
    const std::size_t end = std::min(settings.find(';', at), settings.size());
    out.push_back(settings.substr(at, end - at));
    at = end + 1;
  }
  return out;
}

/// The full scene's instant for a scene that leaves something out.
State carry_over(Simulation& simulation, const State& full) {
  State state = simulation.initial_state();
  const std::size_t unknowns = std::min(state.x.size(), full.x.size());
  std::copy_n(full.x.begin(), unknowns, state.x.begin());
  std::copy_n(full.v.begin(), unknowns, state.v.begin());
  state.time = full.time;
  state.dt = full.dt;
  if (simulation.fluid()) {
    state.flow = full.flow;
    if (state.holding.size() == full.holding.size()) state.holding = full.holding;
  }
  if (state.friction_slip.size() == full.friction_slip.size()) state.friction_slip = full.friction_slip;
  // A first estimate of the stiffest mode takes more products than later ones.
  if (state.x.size() == full.x.size()) {
    state.mode_shape = full.mode_shape;
    state.frequency = full.frequency;
    state.stiffest_part = full.stiffest_part;
  }
  return state;
}

}  // namespace

std::vector<ScenePart> time_scene_parts(const std::filesystem::path& case_directory, double at, int steps, int repeats, const State* given) {
  std::vector<ScenePart> rows;
  State full;
  if (given) full = *given;
  for (const Variant& variant : variants) {
    ScenePart row;
    row.name = variant.name;
    row.setting = variant.setting;
    row.part = variant.part;
    try {
      Simulation simulation(load_scene(case_directory, split(variant.setting)));
      if (rows.empty() && !given) full = bring_to(simulation, at);
      row.timing = time_steps(simulation, rows.empty() ? full : carry_over(simulation, full), steps, repeats);
      spdlog::info("{}: {:.3g} ms a step", row.name, 1e3 * row.timing.wall);
    } catch (const Error& error) {
      if (rows.empty()) throw;
      row.failure = error.what();
      spdlog::warn("{}: cannot be timed: {}", row.name, row.failure);
    }
    row.timing.end = State();
    rows.push_back(std::move(row));
  }
  return rows;
}

std::vector<ScenePart> time_generic_scene_parts(const std::filesystem::path& output, const std::filesystem::path& mvprep, double fluid_mm, double at, int steps, int repeats) {
  ClosureMesh mesh{fluid_mm, 0.5 * fluid_mm, 1};
  mesh.atrium_mm = 36;  // room for the leaflets turned over
  const MadeCase made = CaseMaker(output, mvprep).make(mesh_name(mesh) + "-long", closure_case_toml(mesh));
  if (!made.is_made()) throw InputError("the case for what a scene leaves out cannot be made: " + made.error);
  return time_scene_parts(made.directory, at, steps, repeats);
}

std::string scene_parts_csv(const std::vector<ScenePart>& parts) {
  std::string out = "scene,setting,step_ms";
  for (const char* name : part_names()) {
    std::string column = name;
    for (char& c : column)
      if (c == ' ') c = '_';
    out += fmt::format(",{}_ms", column);
  }
  out += ",less_than_full_ms,repeat_spread_percent\n";
  for (const ScenePart& p : parts) {
    out += p.name.find(',') != std::string::npos ? "\"" + p.name + "\"" : p.name;
    out += fmt::format(",{}", p.setting);
    if (!p.failure.empty()) {
      out += std::string(part_count + 3, ',') + "\n";
      continue;
    }
    out += fmt::format(",{}", format_number(1e3 * p.timing.wall));
    for (double s : p.timing.part) out += fmt::format(",{}", format_number(1e3 * s));
    out += fmt::format(",{},{}\n", format_number(1e3 * (parts.front().timing.wall - p.timing.wall)), format_number(100 * p.timing.spread));
  }
  return out;
}

std::string scene_parts_html(const std::vector<ScenePart>& parts) {
  if (parts.empty()) return html::missing("Not timed.");
  StackedBars bars;
  bars.title = "Milliseconds per step of the closed valve, by part";
  bars.unit = "ms";
  for (const char* name : part_names()) bars.parts.push_back(name);
  std::vector<std::vector<std::string>> table{{"scene", "setting", "ms per step", "less than the full scene", "part it touches", "in the full scene", "left when off", "spread of repeats"}};
  const StepTiming& full = parts.front().timing;
  for (const ScenePart& p : parts) {
    if (!p.failure.empty()) {
      table.push_back({html::escape(p.name), "<code>" + html::escape(p.setting) + "</code>", "–", html::escape(p.failure), "", "", "", ""});
      continue;
    }
    std::vector<double> ms;
    for (double s : p.timing.part) ms.push_back(1e3 * s);
    bars.rows.emplace_back(p.name, ms);
    const bool is_full = p.setting.empty();
    table.push_back({html::escape(p.name), is_full ? "" : "<code>" + html::escape(p.setting) + "</code>", html::number(1e3 * p.timing.wall),
                     is_full ? "" : html::number(std::round(1000 * (1 - p.timing.wall / full.wall)) / 10) + " %", is_full ? "" : part_names()[p.part],
                     is_full ? "" : html::number(1e3 * full.part[p.part]) + " ms", is_full ? "" : html::number(1e3 * p.timing.part[p.part]) + " ms",
                     html::number(std::round(100 * p.timing.spread)) + " %"});
  }
  return "<p class=\"lead\">One closed valve, one thread, advanced by the same number of steps with each part switched off. A part that is off must leave nothing behind: "
         "the columns compare what its part of the step costs with and without it. Friction, fibres and distortion control are terms inside a part, not parts. "
         "A scene that leaves something out soon moves otherwise: faster leaflets search for contact more often, which is contact's cost and not that of what is off; the whole step says less than the column of "
         "what is left.</p>\n<figure>" +
         svg(bars) + "</figure>\n" + html::table(table, true);
}

}  // namespace mv
