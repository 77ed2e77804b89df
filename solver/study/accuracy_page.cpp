// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "solver/report/html.h"
#include "solver/study/accuracy.h"
#include "solver/study/study_page.h"
#include "solver/study/svg_plot.h"

namespace mv {
namespace {

using html::escape;

std::string percent(double value) { return std::isfinite(value) ? html::number(value, 2) + " %" : "–"; }

Marker marker_of(const std::string& axis) {
  if (axis == "resolution" || axis == "fluid spacing") return Marker::circle;
  if (axis.starts_with("solid")) return Marker::square;
  if (axis == "step" || axis == "search interval") return Marker::triangle;
  return Marker::diamond;
}

double median_of(std::vector<double> values) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  return values.empty() ? std::nan("") : median(values);
}

std::vector<CostError> median_errors(const StudyTable& t) {
  std::vector<CostError> points;
  for (const StudyRow& row : t.rows) points.push_back({row.seconds, row.is_usable() ? median_of(row.errors) : std::nan("")});
  return points;
}

/// Colour by fluid spacing, coarse to fine.
std::map<double, std::string> colours_of(const StudyTable& table) {
  std::map<double, std::string> out;
  for (const StudyRow& row : table.rows) out[-row.mesh.fluid_mm] = "";
  std::size_t i = 0;
  for (auto& [h, colour] : out) colour = series_colour(i++);
  return out;
}

std::string key_of(const StudyTable& table) {
  std::string out = "<p class=\"scale\">";
  for (const auto& [h, colour] : colours_of(table))
    out += "<span class=\"key\"><i style=\"background:" + colour + "\"></i>fluid " + html::number(-h) + " mm</span> ";
  return out + "<span>● resolution, ■ solid, ▲ step and search, ◆ kernel and coupling; filled: on the front, hollow: beaten by another run, ✕: not to be trusted; dotted: 5, 2 and 1 %</span></p>\n";
}

std::string recommendation_section(const AccuracyResult& result) {
  std::map<std::string, std::string> titles;
  for (const StudyQuantity& q : result.closure.quantities) titles[q.name] = q.title;
  std::vector<std::vector<std::string>> table{{"asked error", "run", "tube.spacing", "mesh.spacing", "run settings", "seconds, one thread", "within it", "not within it (its error)"}};
  for (const RecommendedSettings& e : result.recommended) {
    std::string met, not_met;
    for (const std::string& name : e.met) met += (met.empty() ? "" : ", ") + escape(titles[name]);
    for (const auto& [name, error] : e.not_met) not_met += (not_met.empty() ? "" : ", ") + escape(titles[name]) + " (" + percent(error) + ")";
    const bool is_there = !e.run.empty();
    table.push_back({html::number(e.asked_percent) + " %", is_there ? "<code>" + escape(e.run) + "</code>" : "none", is_there ? html::number(e.fluid_mm) + " mm" : "",
                     is_there ? html::number(e.solid_mm) + " mm" + (e.order == 2 ? ", quadratic" : "") : "",
                     !is_there ? "" : e.settings.empty() ? "defaults" : "<code>" + escape(fmt::format("{}", fmt::join(e.settings, ", "))) + "</code>", is_there ? html::number(e.seconds) : "",
                     met.empty() ? "–" : met, not_met.empty() ? "–" : not_met});
  }
  std::string out = "<p class=\"lead\">For each asked error the cheapest run that gives every quantity within it, or nearly as well as any run does where none reaches it. An error here is the distance to the "
                    "reference and the reference's own uncertainty together. <code>mvsolve run CASE -o RESULTS --accuracy 2%</code> uses the table that is built into the program and refuses a case that is too coarse.</p>\n" +
                    html::table(table, true);
  std::size_t at = 0;
  // The two columns of names may wrap.
  while ((at = out.find("<td>", at)) != std::string::npos) {
    const std::size_t end = out.find("</td>", at);
    if (end - at > 60) out.replace(at, 4, "<td class=\"wrap\">");
    at = end;
  }
  return out;
}

std::string reference_section(const StudyTable& t) {
  std::vector<std::vector<std::string>> table{{"quantity", "reference", "uncertainty", "observed order", "2 % expected at", "what it is"}};
  double finest = 1e300;
  for (const StudyRow& row : t.rows)
    if (row.axis == "resolution" && row.has_values) finest = std::min(finest, row.mesh.fluid_mm);
  for (const StudyQuantity& q : t.quantities) {
    const double spacing = finest * std::pow(2 / q.uncertainty_percent, 1 / std::clamp(q.order, 0.5, 2.0));
    table.push_back({escape(q.title), html::number(q.reference) + " " + escape(q.unit), percent(q.uncertainty_percent), std::isfinite(q.order) ? html::number(q.order, 2) : "not monotone",
                     q.uncertainty_percent <= 2 ? "reached" : std::isfinite(spacing) ? html::number(spacing, 2) + " mm" : "–", escape(q.how)});
  }
  return "<p class=\"lead\">The reference is the finest resolution. What it still lacks is estimated from the three finest ones: with values that approach a limit, 1.25 times the distance to Richardson's limit, the "
         "order kept between 0.5 and 2; otherwise the range of the three. It is part of every error on this page. The fluid spacing at which the "
         "uncertainty would fall to 2 % continues the observed order and is a guess.</p>\n" +
         html::table(table, true);
}

/// Values or errors of all runs.
std::string runs_table(const StudyTable& t, bool is_errors) {
  std::vector<std::vector<std::string>> table{{"run", "what differs", "seconds"}};
  for (const StudyQuantity& q : t.quantities) table[0].push_back(escape(q.title) + (is_errors ? ", %" : ", " + escape(q.unit)));
  table[0].push_back("remark");
  std::vector<std::vector<std::size_t>> fronts;
  for (std::size_t q = 0; q < t.quantities.size(); ++q) fronts.push_back(pareto_front(cost_errors(t, q)));
  for (std::size_t r = 0; r < t.rows.size(); ++r) {
    const StudyRow& row = t.rows[r];
    if (!row.has_values) continue;
    table.push_back({"<code>" + escape(row.run) + "</code>", escape(row.what), html::number(row.seconds)});
    for (std::size_t q = 0; q < t.quantities.size(); ++q) {
      const std::string text = is_errors ? (std::isfinite(row.errors[q]) ? html::number(row.errors[q], 2) : "–") : html::number(row.values[q], 4);
      const bool is_on_front = std::find(fronts[q].begin(), fronts[q].end(), r) != fronts[q].end();
      table.back().push_back(is_errors && is_on_front ? "<strong>" + text + "</strong>" : text);
    }
    table.back().push_back(escape(row.failure));
  }
  return "<div class=\"dense\">" + html::table(table, true) + "</div>\n";
}

std::string left_out(const StudyTable& t) {
  std::string out;
  for (const StudyRow& row : t.rows)
    if (!row.has_values) out += "<li><code>" + escape(row.run) + "</code>, " + escape(row.what) + ": " + escape(row.failure) + "</li>\n";
  return out.empty() ? "" : "<h3>Runs without numbers</h3>\n<ul>" + out + "</ul>\n";
}

/// What a single setting changes: values against the baseline of the same mesh, seconds as a ratio.
std::string effects_section(const StudyTable& t) {
  std::vector<std::vector<std::string>> table{{"setting", "seconds, ×"}};
  for (const StudyQuantity& q : t.quantities) table[0].push_back(escape(q.title));
  for (const StudyRow& row : t.rows) {
    if (row.axis == "resolution" || !row.has_values) continue;
    const StudyRow* base = nullptr;
    for (const StudyRow& b : t.rows)
      if (b.axis == "resolution" && b.has_values && b.mesh.fluid_mm == row.mesh.fluid_mm) base = &b;
    if (!base) continue;
    table.push_back({escape(row.what) + (row.failure.empty() ? "" : " ✕"), fmt::format("{:.2f}", row.seconds / base->seconds)});
    for (std::size_t q = 0; q < t.quantities.size(); ++q) {
      const double scale = t.quantities[q].is_leak ? t.quantities[q].leak_scale : std::abs(base->values[q]);
      const double change = 100 * (row.values[q] - base->values[q]) / scale;
      table.back().push_back(std::isfinite(change) ? fmt::format("{:+.1f} %", change) : "–");
    }
  }
  return "<p class=\"lead\">What one setting changes against the run with the same mesh and the default settings, and how its time compares. A change far below the resolution's own error buys nothing; a setting that is "
         "faster and changes no more than that is worth taking.</p>\n" +
         (table.size() > 1 ? "<div class=\"dense\">" + html::table(table, true) + "</div>\n" : html::missing("No run with other settings."));
}

std::string closure_section(const AccuracyResult& result, const AccuracyOptions& options) {
  const StudyTable& t = result.closure;
  std::string out = fmt::format(
      "<p class=\"lead\">The generic valve of configs/demo.toml, 120 mmHg, {:g} ms simulated; what oscillates after the impact is averaged over the last {:g} ms; gaps below 1 mm count as contact on every "
      "grid. Seconds are processor time of one thread, report included. Hover over a point for its settings.</p>\n",
      1e3 * options.ladder.end, 1e3 * options.ladder.window);
  out += key_of(t) + "<figure class=\"panels\">" + front_figure(t) + "</figure>\n";
  out += "<h3>Error of every run, per cent (bold: on the front)</h3>\n" + runs_table(t, true);
  out += left_out(t) + html::details("Values of every run", runs_table(t, false));
  return out;
}

std::string known_section(const StudyTable& t) {
  std::string out = "<p class=\"lead\">" + t.explanation + "</p>\n" + key_of(t) + "<figure class=\"panels\">" + front_figure(t) + "</figure>\n";
  std::vector<std::vector<std::string>> references{{"quantity", "right answer", "its uncertainty"}};
  for (const StudyQuantity& q : t.quantities)
    references.push_back({escape(q.title), html::number(q.reference, 5) + " " + escape(q.unit), q.uncertainty_percent == 0 ? "exact" : percent(q.uncertainty_percent)});
  return out + html::table(references, true) + "<h3>Error of every run, per cent (bold: on the front)</h3>\n" + runs_table(t, true) + left_out(t) +
         html::details("Values of every run", runs_table(t, false));
}

std::string revision_note(const StudyTable& t) {
  std::vector<std::string> seen;
  for (const StudyRow& row : t.rows)
    if (!row.revision.empty() && std::find(seen.begin(), seen.end(), row.revision) == seen.end()) seen.push_back(row.revision);
  if (seen.size() < 2) return "";
  return "<p><strong>Runs of different revisions stand beside each other (" + escape(fmt::format("{}", fmt::join(seen, ", "))) + ");</strong> <code>--fresh</code> repeats them all.</p>\n";
}

}  // namespace

std::string front_figure(const StudyTable& t) {
  std::string out;
  const auto colours = colours_of(t);
  for (std::size_t panel = 0; panel <= t.quantities.size(); ++panel) {
    // The first panel is the median of all quantities.
    const std::size_t q = panel - 1;
    if (panel == 0 && t.quantities.size() < 4) continue;
    const std::vector<CostError> points = panel == 0 ? median_errors(t) : cost_errors(t, q);
    auto error_of = [&](std::size_t r) { return panel == 0 ? median_of(t.rows[r].errors) : t.rows[r].errors[q]; };
    const std::vector<std::size_t> front = pareto_front(points);
    Plot plot;
    plot.title = panel == 0 ? "Median of all quantities" : t.quantities[q].title;
    plot.x_label = "seconds";
    plot.y_label = "error, %";
    plot.levels = {5, 2, 1};
    plot.smallest_y = 1e-3;
    PlotLine line;
    line.colour = "#59626d";
    for (std::size_t r : front) line.points.emplace_back(t.rows[r].seconds, error_of(r));
    plot.lines.push_back(line);
    for (std::size_t r = 0; r < t.rows.size(); ++r) {
      const StudyRow& row = t.rows[r];
      if (!row.has_values || !std::isfinite(error_of(r))) continue;
      const bool is_marked = std::find(front.begin(), front.end(), r) != front.end();
      plot.points.push_back({row.seconds, error_of(r), fmt::format("{}: {}; {:.3g} %, {:.3g} s{}", row.run, row.what, error_of(r), row.seconds, row.failure.empty() ? "" : "; " + row.failure), "",
                             colours.at(-row.mesh.fluid_mm), row.failure.empty() ? marker_of(row.axis) : Marker::cross, is_marked});
    }
    out += svg(plot);
  }
  return out;
}

std::string accuracy_page(const AccuracyResult& result, const AccuracyOptions& options) {
  std::vector<PageSection> sections{{"use", "What to use", recommendation_section(result)},
                                    {"closure", result.closure.title, revision_note(result.closure) + closure_section(result, options)},
                                    {"reference", "How certain the reference is", reference_section(result.closure)},
                                    {"effects", "What one setting changes", effects_section(result.closure)}};
  for (const StudyTable& table : result.known) sections.push_back({table.id, table.title, known_section(table)});
  if (!result.parts.empty()) sections.push_back({"scene", "What a scene leaves out (" + result.parts_scene + ")", scene_parts_html(result.parts)});
  return study_page("Error against run time", "Measured by <code>mvsolve accuracy</code>; every number is in accuracy.csv, the settings to use in recommended.toml.", sections, options.command_line);
}

}  // namespace mv
