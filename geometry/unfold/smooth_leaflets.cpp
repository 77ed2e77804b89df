// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/unfold/smooth_leaflets.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace mv {
namespace {

constexpr int columns = 720, column_pieces = 48, fits = 3;
/// The annulus correction has faded at this share of a column.
constexpr double correction_reach = 0.5;

std::size_t index(long i) { return static_cast<std::size_t>(i); }

double correction(double t) {
  const double s = t / correction_reach;
  if (s >= 1) return 0;
  if (s <= 0) return 1;
  return (1 - s) * (1 - s) * (1 + 2 * s);
}

}  // namespace

double PeriodicTable::at(double u) const {
  const long n = static_cast<long>(values_.size());
  const double x = u / period_ * static_cast<double>(n), cell = std::floor(x), t = x - cell;
  const auto value = [&](long i) { return values_[index(((i % n) + n) % n)]; };
  const long i = static_cast<long>(cell);
  const double a = value(i - 1), b = value(i), c = value(i + 1), d = value(i + 2);
  return 0.5 * (2 * b + t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * b - a - 3 * c + d))));
}

SmoothLeaflets::SmoothLeaflets(const ClosedCurve& annulus, std::vector<StripSample> samples, const PeriodicTable& height, double wavelength,
                               double cell)
    : annulus_(annulus), height_(height) {
  const double highest = *std::max_element(height.values().begin(), height.values().end());
  const int cells_u = std::max(12, static_cast<int>(std::lround(period() / cell))), cells_t = std::max(4, static_cast<int>(std::lround(highest / cell)));
  for (int fit = 0; fit < fits; ++fit) {
    spline_.assign(1, StripSpline(period(), cells_u, cells_t, samples, [&](double u) { return height_.at(u); }, wavelength));
    std::vector<double> heights;
    std::vector<std::vector<double>> tables;
    for (int i = 0; i < columns; ++i) {
      tables.push_back(column_lengths(period() * i / columns, column_pieces));
      heights.push_back(tables.back().back());
    }
    height_ = PeriodicTable(period(), heights);
    if (fit + 1 == fits) break;
    const auto share = [&](const std::vector<double>& table, double t) {
      const double x = std::clamp(t, 0.0, 1.0) * column_pieces;
      const auto k = std::min(static_cast<std::size_t>(x), table.size() - 2);
      return (table[k] + (x - static_cast<double>(k)) * (table[k + 1] - table[k])) / table.back();
    };
    for (StripSample& s : samples) {
      double x = s.u / period() * columns;
      x -= columns * std::floor(x / columns);
      const auto i = std::min(static_cast<std::size_t>(x), index(columns - 1));
      const double inside = x - static_cast<double>(i);
      s.t = (1 - inside) * share(tables[i], s.t) + inside * share(tables[(i + 1) % columns], s.t);
    }
  }
}

Vec3 SmoothLeaflets::at(double u, double t) const {
  const StripSpline& s = spline_.front();
  const Vec3 x = s.value(u, t).head<3>();
  const double b = correction(t);
  return b == 0 ? x : Vec3(x + b * (annulus_.at(u) - s.value(u, 0).head<3>()));
}

std::vector<double> SmoothLeaflets::column_lengths(double u, int pieces) const {
  std::vector<double> length{0};
  Vec3 last = at(u, 0);
  for (int k = 1; k <= pieces; ++k) {
    const Vec3 x = at(u, static_cast<double>(k) / pieces);
    length.push_back(length.back() + (x - last).norm());
    last = x;
  }
  return length;
}

Vec3 SmoothLeaflets::position(const Vec2& uv) const { return at(uv.x(), uv.y() / height_.at(uv.x())); }

Vec3 SmoothLeaflets::along_u(const Vec2& uv) const {
  const double h = 1e-4 * period();
  return (position({uv.x() + h, uv.y()}) - position({uv.x() - h, uv.y()})) / (2 * h);
}

Vec3 SmoothLeaflets::along_v(const Vec2& uv) const {
  const double height = height_.at(uv.x()), t = uv.y() / height, h = 1e-4;
  return (at(uv.x(), t + h) - at(uv.x(), t - h)) / (2 * h * height);
}

Vec3 SmoothLeaflets::normal(const Vec2& uv) const { return along_u(uv).cross(along_v(uv)).normalized(); }

double SmoothLeaflets::thickness(const Vec2& uv) const { return spline_.front().value(uv.x(), uv.y() / height_.at(uv.x()))[3]; }

std::vector<Vec2> SmoothLeaflets::free_edge(double step) const {
  std::vector<Vec2> edge;
  const int n = static_cast<int>(std::ceil(period() / step));
  for (int i = 0; i < n; ++i) {
    const double u0 = period() * i / n, u1 = period() * (i + 1) / n;
    const int parts = std::max(1, static_cast<int>(std::ceil(std::hypot(u1 - u0, height(u1) - height(u0)) / step)));
    for (int k = 0; k < parts; ++k) {
      const double u = u0 + (u1 - u0) * k / parts;
      edge.push_back({u, height(u)});
    }
  }
  return edge;
}

double SmoothLeaflets::curvature(const Vec2& uv) const {
  constexpr double step = 0.4;  // mm
  const Vec3 n = normal(uv);
  const Vec2 du(step / std::max(0.2, along_u(uv).norm()), 0), dv(0, step);
  const double height = height_.at(uv.x());
  const auto inside = [&](Vec2 p) {
    p.y() = std::clamp(p.y(), 0.0, height);
    return p;
  };
  double largest = 0;
  for (const Vec2& d : {du, dv, Vec2(du + dv), Vec2(du - dv)}) {
    const Vec2 a = inside(uv - d), b = inside(uv + d);
    const Vec3 left = position(uv) - position(a), right = position(b) - position(uv);
    const double l = left.norm(), r = right.norm();
    if (!(l > 0.2 * step) || !(r > 0.2 * step)) continue;
    largest = std::max(largest, std::abs(n.dot(right / r - left / l)) / (0.5 * (l + r)));
  }
  return largest;
}

double SmoothLeaflets::speed_error() const {
  double worst = 0;
  for (int i = 0; i < columns; i += 4) {
    const std::vector<double> table = column_lengths(period() * i / columns, column_pieces);
    for (int k = 1; k <= column_pieces; ++k)
      worst = std::max(worst, std::abs(table[index(k)] / table.back() - static_cast<double>(k) / column_pieces));
  }
  return worst;
}

}  // namespace mv
