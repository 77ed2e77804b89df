// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/recommended.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "geometry/core/config.h"
#include "geometry/core/errors.h"
#include "geometry/core/log.h"

namespace mv {
namespace {

// Spacings this much wider than asked still pass: files carry rounded numbers.
constexpr double spacing_slack = 1.001;

std::string quoted_list(const std::vector<std::string>& texts) {
  std::string out;
  for (const std::string& t : texts) out += (out.empty() ? "\"" : ", \"") + t + "\"";
  return out;
}

std::string percent_text(double value) { return std::isfinite(value) ? fmt::format("{:.2g} %", value) : "none"; }

std::string mvprep_settings(const RecommendedSettings& entry) {
  return fmt::format("--set tube.spacing=\"{:g} mm\" --set mesh.spacing=\"{:g} mm\"{}", entry.fluid_mm, entry.solid_mm, entry.order == 2 ? " --set mesh.order=2" : "");
}

}  // namespace

std::vector<RecommendedSettings> recommended_settings(const StudyTable& closure) {
  std::vector<RecommendedSettings> out;
  const std::vector<RunErrors> runs = run_errors(closure);
  for (double asked : asked_errors) {
    const Recommendation found = recommend(runs, asked);
    RecommendedSettings entry;
    entry.asked_percent = asked;
    for (std::size_t q : found.met) entry.met.push_back(closure.quantities[q].name);
    for (std::size_t q : found.not_met)
      entry.not_met.emplace_back(closure.quantities[q].name, found.run >= 0 ? runs[static_cast<std::size_t>(found.run)].errors[q] : std::nan(""));
    if (found.run >= 0) {
      const StudyRow& row = closure.rows[static_cast<std::size_t>(found.run)];
      entry.run = row.run;
      entry.fluid_mm = row.mesh.fluid_mm;
      entry.solid_mm = row.mesh.solid_mm;
      entry.order = row.mesh.order;
      entry.settings = row.settings;
      entry.seconds = row.seconds;
    }
    out.push_back(std::move(entry));
  }
  return out;
}

std::string recommended_toml(const std::vector<RecommendedSettings>& table, const std::string& command) {
  std::string out = "# The cheapest settings for an asked error, from the ladder of: " + command + "\n";
  for (const RecommendedSettings& e : table) {
    out += fmt::format("\n[[accuracy]]\nasked_percent = {:g}\nrun = \"{}\"\n", e.asked_percent, e.run);
    if (!e.run.empty())
      out += fmt::format("tube.spacing = \"{:g} mm\"\nmesh.spacing = \"{:g} mm\"\nmesh.order = {}\nsettings = [{}]\nprocessor_s = {:.4g}\n", e.fluid_mm, e.solid_mm, e.order, quoted_list(e.settings),
                         e.seconds);
    out += fmt::format("met = [{}]\n", quoted_list(e.met));
    out += "not_met = {";
    for (std::size_t i = 0; i < e.not_met.size(); ++i)
      out += fmt::format("{} {} = {}", i ? "," : "", e.not_met[i].first, std::isfinite(e.not_met[i].second) ? fmt::format("{:.3g}", e.not_met[i].second) + (e.not_met[i].second >= 100 ? ".0" : "") : "nan");
    out += e.not_met.empty() ? "}\n" : " }   # error of this run, per cent\n";
  }
  return out;
}

std::string recommended_source(const std::vector<RecommendedSettings>& table, const std::string& command) {
  std::string out = "// SPDX-License-Identifier: BSD-3-Clause\n// Written by: " + command +
                    "\n// Repeat with: mvsolve accuracy -o DIR --table solver/study/recommended_table.cpp\n#include <limits>\n\n#include \"solver/study/recommended.h\"\n\nnamespace mv {\n\n"
                    "const std::vector<RecommendedSettings>& recommended_table() {\n"
                    "  [[maybe_unused]] constexpr double none = std::numeric_limits<double>::quiet_NaN();\n  static const std::vector<RecommendedSettings> table{\n";
  for (const RecommendedSettings& e : table) {
    out += fmt::format("      {{{:g}, \"{}\", {:g}, {:g}, {}, {{{}}}, {:.4g},\n       {{{}}},\n       {{", e.asked_percent, e.run, e.fluid_mm, e.solid_mm, e.order, quoted_list(e.settings), e.seconds,
                       quoted_list(e.met));
    for (std::size_t i = 0; i < e.not_met.size(); ++i)
      out += fmt::format("{}{{\"{}\", {}}}", i ? ", " : "", e.not_met[i].first, std::isfinite(e.not_met[i].second) ? fmt::format("{:.3g}", e.not_met[i].second) : "none");
    out += "}},\n";
  }
  return out + "  };\n  return table;\n}\n\n}  // namespace mv\n";
}

double parse_percent(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  while (end && *end == ' ') ++end;
  if (end == text.c_str() || std::string(end) != "%" || !(value > 0) || !(value <= 100))
    throw UsageError(fmt::format("--accuracy '{}': an error in per cent such as 2% was expected", text));
  return value;
}

const RecommendedSettings& entry_for(const std::vector<RecommendedSettings>& table, double asked_percent) {
  const RecommendedSettings* found = nullptr;
  double smallest = 1e300;
  for (const RecommendedSettings& e : table) {
    smallest = std::min(smallest, e.asked_percent);
    if (e.asked_percent <= asked_percent * (1 + 1e-9) && (!found || e.asked_percent > found->asked_percent)) found = &e;
  }
  if (!found) throw ConfigError(fmt::format("--accuracy {:g}%: the recorded ladder goes down to {:g}%; see 'mvsolve accuracy --help' to measure a finer one", asked_percent, smallest));
  if (found->met.empty()) {
    std::string best;
    for (const auto& [name, error] : found->not_met) best += fmt::format("{}{} {}", best.empty() ? "" : ", ", name, percent_text(error));
    throw ConfigError(fmt::format("--accuracy {:g}%: the recorded ladder gives no quantity within {:g}%; errors of its best run: {}. Ask for a larger error, or measure a finer ladder with "
                                  "'mvsolve accuracy'",
                                  asked_percent, found->asked_percent, best));
  }
  return *found;
}

std::vector<std::string> settings_for_accuracy(const std::filesystem::path& case_directory, double asked_percent, const std::vector<RecommendedSettings>& table) {
  const RecommendedSettings& entry = entry_for(table, asked_percent);
  const Config config = Config::from_file(case_directory / "case.toml");
  const double fluid = config.number_in("tube.spacing", "mm");
  // What counts is the distance of neighbouring points: half the edge of a quadratic element.
  auto point_distance = [](double spacing, long order) { return order == 2 ? 0.5 * spacing : spacing; };
  const double solid = point_distance(config.number_in("mesh.spacing", "mm"), config.integer("mesh.order"));
  if (fluid > spacing_slack * entry.fluid_mm || solid > spacing_slack * point_distance(entry.solid_mm, entry.order))
    throw ConfigError(fmt::format("--accuracy {:g}%: the case is too coarse (tube.spacing {:g} mm, mesh.spacing {:g} mm); make it with: mvprep run -c config.toml -o {} {}", asked_percent, fluid,
                                  config.number_in("mesh.spacing", "mm"), case_directory.string(), mvprep_settings(entry)));
  spdlog::info("--accuracy {:g}%: settings of {} ({:.0f} s of one thread for the generic valve){}{}", asked_percent, entry.run, entry.seconds, entry.settings.empty() ? "" : ": ",
               fmt::join(entry.settings, ", "));
  spdlog::info("within {:g}% on the generic valve: {}", entry.asked_percent, entry.met.empty() ? "nothing" : fmt::format("{}", fmt::join(entry.met, ", ")));
  if (!entry.not_met.empty()) {
    std::string list;
    for (const auto& [name, error] : entry.not_met) list += fmt::format("{}{} ({})", list.empty() ? "" : ", ", name, percent_text(error));
    spdlog::warn("not within {:g}% (with its error there): {}", entry.asked_percent, list);
  }
  return entry.settings;
}

}  // namespace mv
