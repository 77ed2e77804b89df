// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <cmath>

#include "solver/output/series.h"
#include "solver/report/html.h"
#include "solver/study/bench.h"
#include "solver/study/study_page.h"
#include "solver/study/svg_plot.h"

namespace mv {
namespace {

constexpr std::size_t counted_parts = 4;

std::string percent(double share) { return std::isfinite(share) ? html::number(std::round(1000 * share) / 10) + " %" : "–"; }

std::vector<int> thread_counts(const BenchResult& result) {
  std::vector<int> out;
  for (const BenchRow& row : result.rows)
    if (std::find(out.begin(), out.end(), row.threads) == out.end()) out.push_back(row.threads);
  return out;
}

const BenchRow* row_of(const BenchResult& result, const std::string& scene, int threads) {
  for (const BenchRow& row : result.rows)
    if (row.scene == scene && row.threads == threads) return &row;
  return nullptr;
}

std::string parts_section(const BenchResult& result) {
  StackedBars bars;
  bars.title = "Milliseconds per step, by part";
  bars.unit = "ms";
  for (const char* name : part_names()) bars.parts.push_back(name);
  std::vector<std::vector<std::string>> table{{"scene", "threads", "cells", "nodes", "elements", "mean step", "ms per step"}};
  for (const char* name : part_names()) table[0].push_back(name);
  table[0].push_back("spread of repeats");
  for (const BenchRow& row : result.rows) {
    std::vector<double> ms;
    for (double s : row.timing.part) ms.push_back(1e3 * s);
    bars.rows.emplace_back(fmt::format("{}, {} thr.", row.scene, row.threads), ms);
    table.push_back({html::escape(row.scene), std::to_string(row.threads), html::number(row.size.cells), html::number(row.size.nodes), html::number(row.size.elements),
                     seconds_text(row.timing.dt), html::number(1e3 * row.timing.wall)});
    for (double m : ms) table.back().push_back(html::number(m));
    table.back().push_back(percent(row.timing.spread));
  }
  return fmt::format("<p class=\"lead\">Medians of {} repeats of {} steps from {:g} ms, when the generic valve is closed. Output is what a run computes for its series and leaflet frames, spread over the "
                     "steps between them; writing files is not in it. Milliseconds in the columns of the parts.</p>\n<figure>",
                     result.repeats, result.steps, 1e3 * result.at) +
         svg(bars) + "</figure>\n" + html::table(table, true);
}

std::string bandwidth_section(const BenchResult& result) {
  std::vector<std::vector<std::string>> table{{"scene", "threads", "triad, GB/s", "least traffic, MB per step"}};
  for (std::size_t p = 0; p < counted_parts; ++p) table[0].push_back(part_names()[p]);
  table[0].push_back("counted parts together");
  for (const BenchRow& row : result.rows) {
    double bytes = 0;
    for (double b : row.bytes) bytes += b;
    table.push_back({html::escape(row.scene), std::to_string(row.threads), html::number(1e-9 * row.triad), html::number(1e-6 * bytes)});
    for (std::size_t p = 0; p < counted_parts; ++p) table.back().push_back(percent(row.share[p]));
    table.back().push_back(percent(row.share_total));
  }
  return "<p class=\"lead\">How near a part comes to what the machine's memory allows: the least bytes it has to move, over the bytes the triad a = b + s c moves in the same time. Counted once a step: "
         "21 numbers a padded grid value for the fluid (velocity, old rate, force, pressure, Poisson right side and potential); 12 a grid value and 29 a node for the coupling; 13 numbers and "
         "the indices of each element point for the tissue; 18 numbers a surface node, its faces and candidate pairs for contact. A small share says that arithmetic or repeated passes, not memory, take the time; "
         "above 100 % the arrays stay in the caches.</p>\n" +
         html::table(table, true);
}

std::string growth_section(const BenchResult& result) {
  static const char* const measures[] = {"grid value", "node", "element", "surface node"};
  std::string out = "<p class=\"lead\">Time of each part over its own measure of size. An exponent of 1 means that cost grows in proportion.</p>\n";
  std::vector<std::vector<std::string>> table{{"threads", "scene"}};
  for (std::size_t p = 0; p < counted_parts; ++p) table[0].push_back(fmt::format("{}, ns per {}", part_names()[p], measures[p]));
  table[0].push_back("all, ns per cell");
  Plot plot;
  plot.title = "Cost of a step over the number of cells";
  plot.x_label = "cells of the fluid box";
  plot.y_label = "ms per step";
  plot.width = 460;
  plot.height = 300;
  std::size_t index = 0;
  for (int threads : thread_counts(result)) {
    PlotLine line;
    line.colour = series_colour(index);
    line.name = fmt::format("{} thr.", threads);
    for (const BenchRow& row : result.rows) {
      if (row.threads != threads) continue;
      const double n[] = {row.size.grid_values, row.size.nodes, row.size.elements, row.size.surface_nodes};
      table.push_back({std::to_string(threads), html::escape(row.scene)});
      for (std::size_t p = 0; p < counted_parts; ++p) table.back().push_back(n[p] > 0 ? html::number(1e9 * row.timing.part[p] / n[p]) : "–");
      table.back().push_back(row.size.cells > 0 ? html::number(1e9 * row.timing.wall / row.size.cells) : "–");
      if (row.size.cells > 0) {
        line.points.emplace_back(row.size.cells, 1e3 * row.timing.wall);
        plot.points.push_back({row.size.cells, 1e3 * row.timing.wall, row.scene, "", series_colour(index), Marker::circle, true});
      }
    }
    const auto exponents = growth(result.rows, threads);
    if (std::isfinite(exponents[0])) {
      table.push_back({std::to_string(threads), "exponent, smallest to largest"});
      for (std::size_t p = 0; p < counted_parts; ++p) table.back().push_back(html::number(exponents[p]));
      table.back().push_back("");
    }
    plot.lines.push_back(line);
    ++index;
  }
  if (plot.points.size() > 2) out += "<figure>" + svg(plot) + "</figure>\n";
  return out + html::table(table, true);
}

std::string threads_section(const BenchResult& result) {
  const std::vector<int> counts = thread_counts(result);
  std::vector<std::vector<std::string>> table{{"scene", "threads", "faster than with " + std::to_string(counts.front())}};
  for (std::size_t p = 0; p < counted_parts; ++p) table[0].push_back(part_names()[p]);
  for (const char* head : {"difference in x, m", "in u, m/s", "in p, Pa"}) table[0].push_back(head);
  for (const BenchRow& row : result.rows) {
    const BenchRow* one = row_of(result, row.scene, counts.front());
    if (&row == one) continue;
    auto times = [](double a, double b) { return b > 0 ? html::number(std::round(100 * a / b) / 100) + " ×" : std::string("–"); };
    table.push_back({html::escape(row.scene), std::to_string(row.threads), times(one->timing.wall, row.timing.wall)});
    for (std::size_t p = 0; p < counted_parts; ++p) table.back().push_back(times(one->timing.part[p], row.timing.part[p]));
    for (double d : {row.x_difference, row.u_difference, row.p_difference}) table.back().push_back(html::number(d));
  }
  return fmt::format("<p class=\"lead\">Speed with more threads, and the largest difference of positions, velocities and pressures after the same {} steps: 0 means the same bytes.</p>\n", result.steps) +
         (table.size() > 1 ? html::table(table, true) : html::missing("Only one thread count was measured."));
}

}  // namespace

std::string bench_csv(const BenchResult& result) {
  std::string out = "scene,threads,cells,grid_values,nodes,elements,surface_nodes,candidate_pairs,dt_s,step_ms";
  for (const char* name : part_names()) {
    std::string column = name;
    std::replace(column.begin(), column.end(), ' ', '_');
    out += fmt::format(",{}_ms", column);
  }
  out += ",triad_GB_s";
  for (std::size_t p = 0; p < counted_parts; ++p) out += fmt::format(",{0}_least_MB,{0}_bandwidth_share", part_names()[p]);
  out += ",bandwidth_share,repeat_spread,difference_x_m,difference_u_m_s,difference_p_Pa\n";
  for (const BenchRow& r : result.rows) {
    out += fmt::format("\"{}\",{},{},{},{},{},{},{},{},{}", r.scene, r.threads, r.size.cells, r.size.grid_values, r.size.nodes, r.size.elements, r.size.surface_nodes,
                       r.size.candidate_pairs, format_number(r.timing.dt), format_number(1e3 * r.timing.wall));
    auto cell = [](double value) { return std::isfinite(value) ? format_number(value) : std::string(); };
    for (double s : r.timing.part) out += fmt::format(",{}", cell(1e3 * s));
    out += fmt::format(",{}", cell(1e-9 * r.triad));
    for (std::size_t p = 0; p < counted_parts; ++p) out += fmt::format(",{},{}", cell(1e-6 * r.bytes[p]), cell(r.share[p]));
    out += fmt::format(",{},{},{},{},{}\n", cell(r.share_total), cell(r.timing.spread), cell(r.x_difference), cell(r.u_difference), cell(r.p_difference));
  }
  return out;
}

Json bench_json(const BenchResult& result) {
  Json out;
  out["machine"] = machine_name();
  out["steps"] = result.steps;
  out["repeats"] = result.repeats;
  out["at_s"] = result.at;
  out["rows"] = Json::array();
  for (const BenchRow& r : result.rows) {
    Json row;
    row["scene"] = r.scene;
    row["threads"] = r.threads;
    row["cells"] = r.size.cells;
    row["nodes"] = r.size.nodes;
    row["elements"] = r.size.elements;
    row["surface_nodes"] = r.size.surface_nodes;
    row["candidate_pairs"] = r.size.candidate_pairs;
    row["dt_s"] = r.timing.dt;
    row["step_s"] = r.timing.wall;
    for (std::size_t p = 0; p < part_count; ++p) row["part_s"][part_names()[p]] = r.timing.part[p];
    row["triad_bytes_s"] = r.triad;
    for (std::size_t p = 0; p < counted_parts; ++p) {
      row["least_bytes"][part_names()[p]] = r.bytes[p];
      row["bandwidth_share"][part_names()[p]] = std::isfinite(r.share[p]) ? Json(r.share[p]) : Json();
    }
    row["difference_between_thread_counts"] = {{"x_m", r.x_difference}, {"u_m_s", r.u_difference}, {"p_Pa", r.p_difference}};
    out["rows"].push_back(row);
  }
  for (int threads : thread_counts(result)) {
    const auto exponents = growth(result.rows, threads);
    for (std::size_t p = 0; p < counted_parts; ++p)
      if (std::isfinite(exponents[p])) out["growth_exponent"][std::to_string(threads)][part_names()[p]] = exponents[p];
  }
  return out;
}

std::string bench_text(const BenchResult& result) {
  std::string out = fmt::format("{:<24} {:>7} {:>9} {:>9} {:>8}", "scene", "threads", "cells", "elements", "ms/step");
  for (const char* name : part_names()) out += fmt::format(" {:>13}", name);
  out += fmt::format(" {:>10} {:>9} {:>12}\n", "triad GB/s", "of limit", "thread diff");
  for (const BenchRow& r : result.rows) {
    out += fmt::format("{:<24} {:>7} {:>9.0f} {:>9.0f} {:>8.3f}", r.scene, r.threads, r.size.cells, r.size.elements, 1e3 * r.timing.wall);
    for (double s : r.timing.part) out += fmt::format(" {:>13.3f}", 1e3 * s);
    out += fmt::format(" {:>10.1f} {:>8.1f}% {:>10.2g} m\n", 1e-9 * r.triad, 100 * r.share_total, r.x_difference);
  }
  for (const ScenePart& p : result.parts)
    out += p.failure.empty() ? fmt::format("{:<32} {:>8.3f} ms/step, its part ({}) {:.3f} ms, repeats within {:.0f} %\n", p.name, 1e3 * p.timing.wall, part_names()[p.part],
                                           1e3 * p.timing.part[p.part], 100 * p.timing.spread)
                             : fmt::format("{:<32} not timed: {}\n", p.name, p.failure);
  return out;
}

std::string bench_page(const BenchResult& result, const std::string& command) {
  std::vector<PageSection> sections{{"parts", "Time per step by part", parts_section(result)},
                                    {"bandwidth", "Share of the memory-bandwidth limit", bandwidth_section(result)},
                                    {"growth", "Growth with cells and elements", growth_section(result)},
                                    {"threads", "Threads", threads_section(result)}};
  if (!result.parts.empty()) sections.push_back({"scene", "What a scene leaves out (" + result.parts_scene + ")", scene_parts_html(result.parts)});
  return study_page("What a step costs", "Measured by <code>mvsolve bench</code>; the numbers are in bench.csv and bench.json.", sections, command);
}

}  // namespace mv
