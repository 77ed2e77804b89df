// SPDX-License-Identifier: BSD-3-Clause
#include "solver/report/page.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "solver/report/colours.h"
#include "solver/report/figures_data.h"
#include "solver/report/html.h"
#include "solver/report/png.h"
#include "solver/report/verdict.h"

namespace mv {

namespace {

using html::escape;

std::string hex(const Rgb& colour) {
  char text[8];
  std::snprintf(text, sizeof text, "#%02x%02x%02x", static_cast<int>(255 * colour[0] + 0.5f),
                static_cast<int>(255 * colour[1] + 0.5f), static_cast<int>(255 * colour[2] + 0.5f));
  return text;
}

std::string colour_bar(std::span<const unsigned> stops, double scale, const std::string& name) {
  std::string gradient;
  for (unsigned stop : stops) gradient += (gradient.empty() ? "" : ", ") + hex(rgb(stop));
  return "<span class=\"key\">0 <span class=\"bar\" style=\"background:linear-gradient(to right, " + gradient + ")\"></span> " +
         html::number(scale) + " kPa " + escape(name) + "</span>";
}

std::string colour_key(const Rgb& colour, const std::string& name) {
  return "<span class=\"key\"><i style=\"background:" + hex(colour) + "\"></i>" + escape(name) + "</span>";
}

/// case.name of case.toml, which mvprep writes with one key a line.
std::string case_name(const ResultsData& data) {
  if (const Json& name = json_at(data.run, "case.name"); name.is_string()) return name.get<std::string>();
  const std::size_t section = data.case_toml.find("[case]"), key = data.case_toml.find("\nname = \"", section);
  if (section == std::string::npos || key == std::string::npos) return "";
  const std::size_t begin = data.case_toml.find('"', key) + 1, end = data.case_toml.find('"', begin);
  return data.case_toml.substr(begin, end - begin);
}

std::string verdict_section(const Verdict& verdict) {
  const char* kind = verdict.finding == Finding::none                               ? ""
                     : verdict.finding == Finding::sealed && verdict.is_trustworthy ? " good"
                                                                                    : " bad";
  std::string out = std::string("<section class=\"verdict") + kind + "\" id=\"verdict\"><strong class=\"word\">" +
                    escape(verdict.word) + "</strong>\n<p>";
  for (const std::string& s : verdict.sentences) out += s + " ";  // values in the sentences are escaped where they are put in
  out += "</p>\n<ul class=\"gates\" aria-label=\"trust gates\">\n";
  for (const TrustGate& gate : verdict.gates)
    out += std::string("<li class=\"") + (gate.is_passed ? "pass" : "fail") + "\" title=\"limit: " + gate.limit +
           "\"><span class=\"mark\">" + (gate.is_passed ? "✓" : "✗") + "</span>" + gate.name + " " + gate.value +
           " <span class=\"note\">(" + gate.limit + ")</span></li>\n";
  return out + "</ul></section>\n";
}

std::string key_numbers(const Json& summary) {
  struct Number {
    const char *name, *key, *unit;
    double factor = 1;
  };
  static constexpr Number numbers[] = {{"closing volume", "flow.closing_volume_ml", "ml"},
                                       {"closing time", "flow.closing_time_s", "ms", 1000},
                                       {"leak volume after closure", "flow.leak_volume_ml", "ml"},
                                       {"mean net leak at the end", "flow.leak_rate_ml_s", "ml/s"},
                                       {"smallest sealing threshold", "seal.smallest_sealing_threshold_mm", "mm"},
                                       {"contact threshold", "seal.threshold_mm", "mm"},
                                       {"area of holes", "seal.hole_area_mm2", "mm²"},
                                       {"orifice area", "orifice.area_cm2", "cm²"},
                                       {"orifice area, open", "orifice.open_area_cm2", "cm²"},
                                       {"contact force", "contact.force_N", "N"},
                                       {"contact area", "contact.area_mm2", "mm²"},
                                       {"mean belt width", "contact.belt_width_mm_mean", "mm"},
                                       {"median gap in the belt", "contact.belt_gap_mm_median", "mm"},
                                       {"largest penetration", "contact.penetration_max_mm", "mm"},
                                       {"primary chordae, sum", "chordae.force_primary_N", "N"},
                                       {"secondary chordae, sum", "chordae.force_secondary_N", "N"},
                                       {"papillary forces", "papillary.force_N", "N"},
                                       {"bulging volume", "bulging.volume_ml", "ml"},
                                       {"bulging area", "bulging.area_ratio", "%", 100},
                                       {"peak velocity", "flow.peak_velocity_m_s", "m/s"},
                                       {"fluid cells", "fluid.cells", ""},
                                       {"grid spacing", "fluid.spacing_mm", "mm"},
                                       {"tetrahedra", "solid.tets", ""},
                                       {"simulated", "run.simulated_s", "s"},
                                       {"steps", "run.steps", ""},
                                       {"mean step", "run.dt_mean_s", "µs", 1e6},
                                       {"solve time", "run.wall_s", "s"},
                                       {"threads", "run.threads", ""}};
  std::string out;
  for (const Number& n : numbers) {
    const Json& value = json_at(summary, n.key);
    if (value.is_null()) continue;
    const std::string text = value.is_number() ? html::number(n.factor * value.get<double>()) : html::value(value);
    out += "<div><dt>" + escape(n.name) + "</dt><dd>" + text + (*n.unit != 0 ? "<small>" + escape(n.unit) + "</small>" : "") +
           "</dd></div>\n";
  }
  return out.empty() ? out : "<dl class=\"numbers\" id=\"numbers\">\n" + out + "</dl>\n";
}

std::string plot(const std::string& id, const std::string& caption) {
  return "<figure><div class=\"plot\" id=\"" + id + "\"></div><figcaption>" + caption + "</figcaption></figure>\n";
}

std::string picture_figure(const Picture& picture, const std::string& title) {
  return "<figure><img alt=\"" + escape(title + ", " + picture.caption) + "\" width=\"" + std::to_string(picture.image.width) +
         "\" height=\"" + std::to_string(picture.image.height) + "\" src=\"data:image/png;base64," + base64(picture.png) +
         "\"><figcaption>" + escape(title + ", " + picture.caption) + "</figcaption></figure>\n";
}

std::string map_section(const ResultsData& data, const std::optional<MapView>& view, const Scales& scales) {
  std::string out = "<h2 id=\"map\">Contact map</h2>\n";
  if (!data.map || !view) return out + html::missing("No contact map: contact_map.vtp is not in the results.");
  out +=
      "<p class=\"lead\">What the atrial faces press on each other at the end of the run, drawn on the unfolded valve: the "
      "annulus runs along the top, the free edge hangs below. A belt "
      "that joins commissure to commissure without a gap means that the leaflets close all along.</p>\n";
  std::string caption = "Contact pressure (total crossing the belt above atrial pressure). Grey: no contact. Colours end at " +
                        html::number(scales.pressure) + " kPa";
  const double highest = *std::max_element(data.map->contact_pressure.begin(), data.map->contact_pressure.end());
  if (highest > scales.pressure) caption += "; the highest value, " + html::number(highest) + " kPa, is drawn in the last colour";
  if (json_at(data.summary, "seal.sealed") == false) caption += ". Dashed: the leaflets' places nearest to each hole";
  if (json_at(data.summary, "contact.belt_continuous") == false) caption += ". Shaded: where the belt is interrupted";
  return out + plot("fig-map", caption + ". Point at the map for values.");
}

std::string views_section(const std::vector<Picture>& pictures, const ResultsData& data, const Scales& scales) {
  std::string out = "<h2 id=\"views\">The valve, open and closed</h2>\n";
  if (pictures.empty()) return out + html::missing("No views: leaflets.pvd is not in the results.");
  const auto group = [&](const std::string& prefix, const std::string& title, const char* style) {
    std::string figures;
    for (const Picture& p : pictures)
      if (p.name.starts_with(prefix + "_")) figures += picture_figure(p, title);
    return figures.empty() ? figures : std::string("<div class=\"") + style + "\">\n" + figures + "</div>\n";
  };
  const auto at = [](double time) { return " at " + html::number(1e3 * time) + " ms"; };
  out += "<div class=\"scale\">" + colour_key(anterior_colour, "anterior leaflet") +
         colour_key(posterior_colour, "posterior leaflet");
  if (data.frames.open_chordae)
    out += colour_key(primary_colour, "primary chordae") + colour_key(secondary_colour, "secondary chordae") +
           colour_key(muscle_colour, "papillary tips");
  if (scales.pressure > 0) out += colour_bar(viridis_stops, scales.pressure, "contact pressure");
  out += "</div>\n";
  if (data.frames.open)
    out += "<h3>First frame" + at(data.frames.open->time) + "</h3>\n" + group("open", "first frame", "pictures");
  if (data.frames.closed)
    out += "<h3>Last frame" + at(data.frames.closed->time) + "</h3>\n" + group("closed", "last frame", "pictures");
  const std::string stress = group("stress", "von Mises stress", "pictures two");
  if (!stress.empty())
    out += "<h3>Von Mises stress in the last frame</h3>\n<div class=\"scale\">" +
           colour_bar(cividis_stops, scales.stress, "von Mises stress") + "</div>\n" + stress;
  return out;
}

std::string flow_section(const Json& figures) {
  std::string out = "<h2 id=\"flow\">Flow and pressure</h2>\n";
  if (!figures.contains("time_ms"))
    return out + html::missing("No time series: series.csv is not in the results, or it is empty.");
  if (!figures["series"].contains("flow_ml_s"))
    return out +
           (figures["series"].contains("pressure_difference_mmHg")
                ? plot(
                      "fig-flow",
                      "Pressure difference across the valve. The scene has no fluid: the pressure acts on the ventricular faces.")
                : html::missing("The scene has neither fluid nor pressure."));
  return out + plot("fig-flow",
                    "Pressure difference, flow through the annulus plane (forward, from atrium to ventricle, is positive), the "
                    "net leak after closure (backward is positive), and the integral of the flow over time.");
}

std::string contact_section(const Json& figures) {
  if (!figures["series"].contains("contact_force_N")) return "";
  return "<h2 id=\"contact\">Contact over time</h2>\n" + plot("fig-contact",
                                                              "Force between the leaflets with its two parts (contact law and "
                                                              "blood film), the area in contact and the deepest penetration.");
}

std::string chordae_section(const Json& figures) {
  std::string out = "<h2 id=\"chordae\">Chordae</h2>\n";
  if (!figures.contains("chordae")) return out + html::missing("No chordae in this scene, or chordae.csv is not in the results.");
  return out +
         plot("fig-chordae",
              "Force in one chorda: mean and range of the primary chordae (to the border) and of the secondary ones (inside); "
              "below, their sums and the pull on each papillary tip.") +
         plot("fig-chordae-bars", "Mean force of each chorda over the last 50 ms.");
}

std::string numerics_section(const ResultsData& data, const Json& figures) {
  std::string out = "<h2 id=\"trust\">Energy and time step</h2>\n";
  if (!figures.contains("time_ms"))
    return out + html::missing("No time series: series.csv is not in the results, or it is empty.");
  std::string tables;
  if (figures["series"].contains("work_pressure_J"))
    out += plot("fig-energy",
                "Energy budget: what pressures and moving boundaries put in, and where it went. The residual is what the "
                "computed terms leave unexplained, over the work.");
  if (figures["series"].contains("dt_s")) {
    std::map<std::string, int> count;
    for (const Json& name : figures["limiter"]) ++count[name.get<std::string>()];
    out += plot("fig-step", "Time step with what limited it, volume ratio J of the elements, and trust measures.");
    std::vector<std::vector<std::string>> rows{{"limit of the step", "share of output rows"}};
    for (const auto& [name, n] : count)
      if (!name.empty())
        rows.push_back(
            {escape(name), html::number(std::round(1000.0 * n / static_cast<double>(figures["limiter"].size())) / 10) + " %"});
    if (rows.size() > 1) tables += html::table(rows, true);
  }
  if (const Json& share = json_at(data.summary, "run.share"); share.is_object()) {
    std::vector<std::vector<std::string>> rows{{"part", "share of solve time"}};
    for (const auto& [name, part] : share.items())
      if (part.is_number()) rows.push_back({escape(name), html::number(std::round(1000 * part.get<double>()) / 10) + " %"});
    tables += html::table(rows, true);
  }
  return tables.empty() ? out : out + "<div class=\"beside\">\n" + tables + "</div>\n";
}

std::string gates_section(const ResultsData& data) {
  std::string out = "<h2 id=\"mesh\">Mesh gates</h2>\n";
  if (!data.quality.is_object()) return out + html::missing("case/quality.json is not in the results.");
  return out + "<p class=\"lead\">Checks that mvprep made on the case before the run.</p>\n" +
         html::tables_of_gates(data.quality);
}

std::string settings_section(const ResultsData& data) {
  std::string out = "<h2 id=\"settings\">Settings, versions and hashes</h2>\n";
  Json run = data.run.is_object() ? data.run : Json::object(), settings = Json::object();
  if (run.contains("settings") && run["settings"].is_object()) {
    settings = run["settings"];
    run.erase("settings");
  }
  if (!run.empty())
    out += html::table_of_leaves(run);
  else
    out += html::missing("run.json is not in the results.");
  if (!settings.empty()) out += html::details("Solver settings", html::table_of_leaves(settings));
  if (!data.case_toml.empty())
    out += html::details("The case's resolved configuration (case.toml)", "<pre>" + escape(data.case_toml) + "</pre>\n");
  if (data.manifest.is_object())
    out += html::details("How the case was made (manifest.json)", html::table_of_leaves(data.manifest));
  return out + html::details("All numbers of summary.json", html::table_of_leaves(data.summary));
}

}  // namespace

std::string make_page(const ResultsData& data, const std::optional<MapView>& view, const std::vector<Picture>& pictures,
                      const Scales& scales) {
  const Verdict verdict = make_verdict(data.summary);
  const Json figures = figure_data(data, view, scales.pressure);
  const std::string name = case_name(data), title = "Mitral valve closure" + (name.empty() ? "" : ": " + name);
  std::string page =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
      "content=\"width=device-width, initial-scale=1\">\n<title>" +
      escape(title) + "</title>\n<link rel=\"icon\" href=\"data:,\">\n<style>\n" + std::string(assets::style_css) +
      "</style>\n</head>\n<body>\n<main>\n";
  page += "<header><h1>" + escape(title) + "</h1></header>\n";
  page += verdict_section(verdict);
  page +=
      "<nav class=\"screen-only\"><a href=\"#map\">Contact map</a><a href=\"#views\">Views</a><a href=\"#flow\">Flow and "
      "pressure</a><a href=\"#chordae\">Chordae</a><a href=\"#trust\">Energy and "
      "time step</a><a href=\"#mesh\">Mesh gates</a><a href=\"#settings\">Settings, versions, hashes</a></nav>\n";
  page += key_numbers(data.summary);
  page += "<noscript><p class=\"missing\">The plots need JavaScript; numbers, pictures and tables do not.</p></noscript>\n";
  page += map_section(data, view, scales);
  page += views_section(pictures, data, scales);
  page += flow_section(figures);
  page += contact_section(figures);
  page += chordae_section(figures);
  page += numerics_section(data, figures);
  page += gates_section(data);
  page += settings_section(data);
  page +=
      "<footer>Made by <code>mvsolve report</code> from the files in this folder; nothing on this page is loaded from elsewhere. "
      "Plots: plotly.js, MIT licence, © Plotly Technologies "
      "Inc.</footer>\n</main>\n";
  page += "<script type=\"application/json\" id=\"data\">" + html::script_json(figures) + "</script>\n";
  page += "<script>" + std::string(assets::plotly_js) + "</script>\n<script>\n" + std::string(assets::figures_js) +
          "</script>\n</body>\n</html>\n";
  return page;
}

}  // namespace mv
