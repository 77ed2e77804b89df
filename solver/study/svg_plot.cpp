// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/svg_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "solver/report/html.h"

namespace mv {
namespace {

constexpr const char* ink = "#1d2228";
constexpr const char* muted = "#59626d";
constexpr const char* grid_colour = "#dde2e8";

/// One axis: data to pixels.
struct Axis {
  bool is_log = true;
  double low = 0, high = 1;       // data
  double from = 0, to = 1;        // pixels
  double smallest = 1e-12;

  double at(double value) const {
    if (is_log) value = std::max(value, smallest);
    const double share = is_log ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
    return from + share * (to - from);
  }

  std::vector<double> ticks() const {
    std::vector<double> out;
    if (is_log) {
      const double decades = std::log10(high / low);
      const std::vector<double> steps = decades > 4 ? std::vector<double>{1} : decades > 1.7 ? std::vector<double>{1, 3} : decades > 0.7 ? std::vector<double>{1, 2, 5} : std::vector<double>{1, 1.5, 2, 3, 4, 5, 6, 8};
      for (int e = static_cast<int>(std::floor(std::log10(low))); e <= static_cast<int>(std::ceil(std::log10(high))); ++e)
        for (double s : steps)
          if (const double t = s * std::pow(10.0, e); t >= low * 0.999 && t <= high * 1.001) out.push_back(t);
    } else {
      const double raw = (high - low) / 4, size = std::pow(10.0, std::floor(std::log10(raw)));
      const double step = size * (raw / size < 1.5 ? 1 : raw / size < 3.5 ? 2 : raw / size < 7.5 ? 5 : 10);
      for (double t = std::ceil(low / step) * step; t <= high + 1e-9 * step; t += step) out.push_back(std::abs(t) < 1e-9 * step ? 0 : t);
    }
    return out;
  }
};

Axis fit_axis(bool is_log, double smallest, std::vector<double> values, const std::optional<std::pair<double, double>>& range) {
  Axis axis;
  axis.is_log = is_log;
  axis.smallest = smallest;
  if (is_log)
    for (double& v : values) v = std::max(v, smallest);
  double low = 1, high = 10;
  if (!values.empty()) {
    const auto [a, b] = std::minmax_element(values.begin(), values.end());
    low = *a;
    high = *b;
  }
  if (range) {
    low = range->first;
    high = range->second;
  } else if (is_log) {
    const double margin = std::max(1.25, std::pow(high / low, 0.06));
    low /= margin;
    high *= margin;
  } else {
    low = std::min(low, 0.0);
    high = high > low ? high + 0.08 * (high - low) : low + 1;
  }
  axis.low = low;
  axis.high = high;
  return axis;
}

std::string marker_path(Marker marker, double x, double y, double r) {
  switch (marker) {
    case Marker::square: return fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"", x - 0.9 * r, y - 0.9 * r, 1.8 * r, 1.8 * r);
    case Marker::diamond: return fmt::format("<path d=\"M{:.1f} {:.1f}l{r:.1f} {r:.1f}l-{r:.1f} {r:.1f}l-{r:.1f} -{r:.1f}z\"", x, y - 1.2 * r, fmt::arg("r", 1.2 * r));
    case Marker::triangle: return fmt::format("<path d=\"M{:.1f} {:.1f}l{:.1f} {:.1f}h-{:.1f}z\"", x, y - 1.2 * r, 1.1 * r, 2.1 * r, 2.2 * r);
    case Marker::cross: return fmt::format("<path d=\"M{:.1f} {:.1f}l{r:.1f} {r:.1f}m0 -{r:.1f}l-{r:.1f} {r:.1f}\"", x - r, y - r, fmt::arg("r", 2 * r));
    case Marker::circle: break;
  }
  return fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\"", x, y, r);
}

std::string text(double x, double y, const std::string& content, const char* anchor, const char* colour = muted, int size = 11) {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\" fill=\"{}\" font-size=\"{}\">{}</text>\n", x, y, anchor, colour, size, html::escape(content));
}

std::string frame_of(const Plot& plot, const Axis& x, const Axis& y) {
  std::string out;
  for (double t : x.ticks()) {
    out += fmt::format("<line x1=\"{0:.1f}\" y1=\"{1:.1f}\" x2=\"{0:.1f}\" y2=\"{2:.1f}\" stroke=\"{3}\"/>\n", x.at(t), y.from, y.to, grid_colour);
    out += text(x.at(t), y.from + 14, html::number(t), "middle");
  }
  for (double t : y.ticks()) {
    out += fmt::format("<line x1=\"{1:.1f}\" y1=\"{0:.1f}\" x2=\"{2:.1f}\" y2=\"{0:.1f}\" stroke=\"{3}\"/>\n", y.at(t), x.from, x.to, grid_colour);
    out += text(x.from - 5, y.at(t) + 4, html::number(t), "end");
  }
  out += fmt::format("<path d=\"M{0:.1f} {2:.1f}V{3:.1f}H{1:.1f}\" fill=\"none\" stroke=\"{4}\"/>\n", x.from, x.to, y.to, y.from, muted);
  out += text(0.5 * (x.from + x.to), y.from + 30, plot.x_label, "middle", muted, 12);
  out += fmt::format("<text transform=\"translate({:.1f} {:.1f}) rotate(-90)\" text-anchor=\"middle\" fill=\"{}\" font-size=\"12\">{}</text>\n", 12.0,
                     0.5 * (y.from + y.to), muted, html::escape(plot.y_label));
  out += text(x.from, 14, plot.title, "start", ink, 13);
  return out;
}

std::string lines_of(const Plot& plot, const Axis& x, const Axis& y) {
  std::string out;
  for (double level : plot.levels) {
    if (level < y.low || level > y.high) continue;
    out += fmt::format("<line x1=\"{1:.1f}\" y1=\"{0:.1f}\" x2=\"{2:.1f}\" y2=\"{0:.1f}\" stroke=\"{3}\" stroke-dasharray=\"2 3\"/>\n", y.at(level), x.from, x.to, muted);
  }
  for (const PlotLine& line : plot.lines) {
    std::string path;
    double last_x = 0, last_y = 0;
    for (const auto& [a, b] : line.points) {
      if (!std::isfinite(a) || !std::isfinite(b)) continue;
      last_x = x.at(a);
      last_y = y.at(b);
      path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", last_x, last_y);
    }
    if (path.empty()) continue;
    out += fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.6\"{}/>\n", path, line.colour, line.is_dashed ? " stroke-dasharray=\"5 4\"" : "");
    if (!line.name.empty()) out += text(std::min(last_x + 5, x.to - 2), last_y - 6, line.name, last_x > x.to - 40 ? "end" : "start", line.colour.c_str());
  }
  return out;
}

std::string points_of(const Plot& plot, const Axis& x, const Axis& y) {
  std::string out;
  // Marked points come last, on top.
  for (const bool is_marked : {false, true})
    for (const PlotPoint& p : plot.points) {
      if (p.is_marked != is_marked || !std::isfinite(p.x) || !std::isfinite(p.y)) continue;
      const double px = x.at(p.x), py = std::clamp(y.at(p.y), std::min(y.from, y.to), std::max(y.from, y.to));
      const bool is_cross = p.marker == Marker::cross;
      out += marker_path(p.marker, px, py, is_marked ? 5.2 : 4.0) +
             fmt::format(" fill=\"{}\" stroke=\"{}\" stroke-width=\"{}\"><title>{}</title></{}>\n", is_cross ? "none" : is_marked ? p.colour : "#ffffff",
                         is_marked && !is_cross ? ink : p.colour.c_str(), is_marked ? 1.4 : 1.6, html::escape(p.label),
                         p.marker == Marker::circle ? "circle" : p.marker == Marker::square ? "rect" : "path");
      if (!p.name.empty()) out += text(px > x.to - 70 ? px - 7 : px + 7, py - 6, p.name, px > x.to - 70 ? "end" : "start", ink, 10);
    }
  return out;
}

}  // namespace

std::string series_colour(std::size_t index) {
  static const std::array<const char*, 7> colours{"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#59626d"};
  return colours[index % colours.size()];
}

std::string svg(const Plot& plot) {
  std::vector<double> xs, ys;
  auto take = [&](double a, double b) {
    if (!std::isfinite(a) || !std::isfinite(b)) return;
    xs.push_back(a);
    ys.push_back(b);
  };
  for (const PlotPoint& p : plot.points) take(p.x, p.y);
  for (const PlotLine& line : plot.lines)
    for (const auto& [a, b] : line.points) take(a, b);
  Axis x = fit_axis(plot.is_log_x, plot.smallest_x, xs, plot.x_range), y = fit_axis(plot.is_log_y, plot.smallest_y, ys, plot.y_range);
  x.from = 52;
  x.to = plot.width - 12;
  y.from = plot.height - 38;
  y.to = 24;
  std::string out = fmt::format("<svg viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" role=\"img\" aria-label=\"{2}\" xmlns=\"http://www.w3.org/2000/svg\">\n",
                                plot.width, plot.height, html::escape(plot.title));
  out += frame_of(plot, x, y) + lines_of(plot, x, y) + points_of(plot, x, y);
  return out + "</svg>\n";
}

std::string svg(const StackedBars& bars) {
  constexpr int name_width = 230, value_width = 90, bar = 18, gap = 8, head = 44;
  double longest = 0;
  for (const auto& [name, shares] : bars.rows) {
    double sum = 0;
    for (double s : shares) sum += std::isfinite(s) ? s : 0;
    longest = std::max(longest, sum);
  }
  const int height = head + static_cast<int>(bars.rows.size()) * (bar + gap);
  std::string out = fmt::format("<svg viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" role=\"img\" aria-label=\"{2}\" xmlns=\"http://www.w3.org/2000/svg\">\n", bars.width,
                                height, html::escape(bars.title));
  out += text(0, 14, bars.title, "start", ink, 13);
  double key = 0;
  for (std::size_t p = 0; p < bars.parts.size(); ++p) {
    out += fmt::format("<rect x=\"{:.1f}\" y=\"22\" width=\"12\" height=\"12\" fill=\"{}\"/>\n", key, series_colour(p));
    out += text(key + 16, 32, bars.parts[p], "start");
    key += 30 + 6.6 * static_cast<double>(bars.parts[p].size());
  }
  const double scale = longest > 0 ? (bars.width - name_width - value_width) / longest : 0;
  int y = head;
  for (const auto& [name, shares] : bars.rows) {
    out += text(name_width - 8, y + 13, name, "end", ink, 12);
    double x = name_width, sum = 0;
    for (std::size_t p = 0; p < shares.size(); ++p) {
      if (!std::isfinite(shares[p])) continue;
      const std::string part = p < bars.parts.size() ? bars.parts[p] : "";
      out += fmt::format("<rect x=\"{:.1f}\" y=\"{}\" width=\"{:.1f}\" height=\"{}\" fill=\"{}\"><title>{}: {} {}</title></rect>\n", x, y, scale * shares[p], bar,
                         series_colour(p), html::escape(part), html::number(shares[p]), html::escape(bars.unit));
      x += scale * shares[p];
      sum += shares[p];
    }
    out += text(x + 6, y + 13, html::number(sum) + " " + bars.unit, "start", ink, 12);
    y += bar + gap;
  }
  return out + "</svg>\n";
}

}  // namespace mv
