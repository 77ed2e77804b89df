// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Small figures as inline SVG: points and lines on linear or logarithmic axes, drawn without any script.

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace mv {

enum class Marker { circle, square, diamond, triangle, cross };

struct PlotPoint {
  double x = 0, y = 0;
  std::string label;              // shown on hover
  std::string name;               // written beside the point; empty for none
  std::string colour = "#0072b2";
  Marker marker = Marker::circle;
  bool is_marked = false;         // filled and ringed; others are hollow
};

struct PlotLine {
  std::vector<std::pair<double, double>> points;
  std::string colour = "#1d2228";
  bool is_dashed = false;
  std::string name;               // written at the last point; empty for none
};

struct Plot {
  std::string title, x_label, y_label;
  bool is_log_x = true, is_log_y = true;
  std::vector<PlotPoint> points;
  std::vector<PlotLine> lines;
  std::vector<double> levels;     // horizontal dashed lines across, with their value
  int width = 360, height = 250;
  // Values below are drawn at it on a logarithmic axis.
  double smallest_y = 1e-12, smallest_x = 1e-12;
  std::optional<std::pair<double, double>> y_range, x_range;
};

/// The figure as an <svg> element with role and title for screen readers. Points and lines that are not finite are left out.
std::string svg(const Plot& plot);

/// A horizontal bar of shares for each row: (row name, shares in the order of `parts`), with a key. Shares are of the longest row.
struct StackedBars {
  std::string title, unit;
  std::vector<std::string> parts;
  std::vector<std::pair<std::string, std::vector<double>>> rows;
  int width = 760;
};
std::string svg(const StackedBars& bars);

/// Colours that colour-blind readers tell apart (Okabe and Ito), by index.
std::string series_colour(std::size_t index);

}  // namespace mv
