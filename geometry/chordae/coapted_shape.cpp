// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/chordae/coapted_shape.h"

#include <algorithm>
#include <cmath>

#include "geometry/core/unfolded.h"

namespace mv {
namespace {

constexpr int samples = 64;         // meridians from commissure to commissure
constexpr int notch_window = 5;     // samples either side within which the longest meridian counts: a notch does not raise the belt
constexpr int smoothing_window = 4;
constexpr double depth_step = 0.25; // mm
constexpr double worthwhile = 0.3;  // mm of overlap won per mm of depth given up
constexpr double length_step = 1.0; // mm

template <class F>
std::vector<double> over_window(const std::vector<double>& values, int half, F combine) {
  std::vector<double> out;
  const int n = static_cast<int>(values.size());
  for (int i = 0; i < n; ++i) {
    const auto first = values.begin() + std::max(0, i - half), last = values.begin() + std::min(n, i + half + 1);
    out.push_back(combine(first, last));
  }
  return out;
}

}  // namespace

CoaptedShape::CoaptedShape(const LeafletChart& chart, const Annulus& annulus, double coaptation_depth) : chart_(&chart), normal_(annulus.normal.normalized()) {
  for (const auto& j : chart.junctions())
    if (j.is_commissure) (j.border_index == 0 ? u_first_ : u_second_) = chart.border()[static_cast<std::size_t>(j.border_index)].uv.x();
  std::vector<Vec3> start[2];
  std::vector<double> length[2];
  for (int i = 0; i <= samples; ++i)
    for (int leaflet : {0, 1}) {
      const double u = u_at(leaflet == 0, static_cast<double>(i) / samples);
      start[leaflet].push_back(chart.at({u, 0}).position);
      length[leaflet].push_back(along({u, chart.height(u)}));
    }
  const auto largest = [](auto first, auto last) { return *std::max_element(first, last); };
  const auto mean = [](auto first, auto last) {
    double sum = 0;
    for (auto k = first; k != last; ++k) sum += *k;
    return sum / static_cast<double>(last - first);
  };
  const double longest_a = *std::max_element(length[0].begin(), length[0].end()), longest_p = *std::max_element(length[1].begin(), length[1].end());
  const double share = longest_a / (longest_a + longest_p);
  const std::vector<double> reach_a = over_window(length[0], notch_window, largest), reach_p = over_window(length[1], notch_window, largest);
  const auto top = [&](std::size_t i, double depth) {
    const Vec3 c = start[0][i] + share * (start[1][i] - start[0][i]);
    return Vec3(c + (depth + std::max(0.0, normal_.dot(annulus.origin - c))) * normal_);
  };
  std::vector<double> depth;
  for (std::size_t i = 0; i <= samples; ++i) {
    double d = coaptation_depth;
    const auto overlap = [&](double asked) {
      const Vec3 t = top(i, asked);
      return std::min(reach_a[i] - (t - start[0][i]).norm(), reach_p[i] - (t - start[1][i]).norm());
    };
    while (d > depth_least) {
      const double now = overlap(d);
      if (now >= belt_wanted || (now > 0 && overlap(d - depth_step) - now < worthwhile * depth_step)) break;
      d -= depth_step;
    }
    depth.push_back(std::min(coaptation_depth, std::max(d, depth_least)));
  }
  depth = over_window(depth, smoothing_window, mean);
  for (std::size_t i = 0; i <= samples; ++i) {
    tops_.push_back(top(i, depth[i]));
    meridians_.push_back({static_cast<double>(i) / samples, depth[i], length[0][i] - (tops_[i] - start[0][i]).norm(), length[1][i] - (tops_[i] - start[1][i]).norm()});
  }
}

bool CoaptedShape::is_anterior(double u) const {
  const double beyond = u - u_first_ - chart_->period() * std::floor((u - u_first_) / chart_->period());
  return beyond <= u_second_ - u_first_;
}

double CoaptedShape::fraction(double u) const {
  const double width = u_second_ - u_first_;
  const double beyond = u - u_first_ - chart_->period() * std::floor((u - u_first_) / chart_->period());
  return beyond <= width ? beyond / width : (chart_->period() - beyond) / (chart_->period() - width);
}

double CoaptedShape::u_at(bool on_anterior, double s) const {
  const double width = u_second_ - u_first_;
  return on_anterior ? u_first_ + s * width : u_first_ + chart_->period() - s * (chart_->period() - width);
}

double CoaptedShape::along(const Vec2& uv) const {
  const int steps = std::max(1, static_cast<int>(std::ceil(uv.y() / length_step)));
  double length = 0;
  Vec3 before = chart_->at({uv.x(), 0}).position;
  for (int k = 1; k <= steps; ++k) {
    const Vec3 next = chart_->at({uv.x(), uv.y() * k / steps}).position;
    length += (next - before).norm();
    before = next;
  }
  return length;
}

Vec3 CoaptedShape::top_at(double s) const {
  const double x = std::clamp(s, 0.0, 1.0) * samples;
  const auto i = std::min(static_cast<std::size_t>(x), static_cast<std::size_t>(samples - 1));
  return tops_[i] + (x - static_cast<double>(i)) * (tops_[i + 1] - tops_[i]);
}

Vec3 CoaptedShape::at(const Vec2& uv) const {
  const Vec3 start = chart_->at({uv.x(), 0}).position, top = top_at(fraction(uv.x()));
  const double roof = (top - start).norm(), length = along(uv);
  if (length <= roof) return start + (top - start) * (length / roof);
  return top + (length - roof) * normal_;
}

}  // namespace mv
