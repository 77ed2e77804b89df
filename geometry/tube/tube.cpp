// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/tube/tube.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/core/errors.h"
#include "geometry/core/tube_ends.h"
#include "geometry/tube/outline.h"

namespace mv {
namespace {

using std::numbers::pi;

constexpr int outline_samples = 360;
/// Size of the O-grid's central block relative to the outline, and how far its sides bulge from straight towards the outline's
/// shape.
constexpr double core_share = 0.55, core_bulge = 0.45;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

Vec3 to_tube(const Tube& tube, const Vec3& x) { return tube.axes * (x - tube.origin); }

/// One quadrilateral layer of the O-grid in (e1, e2).
struct QuadGrid {
  std::vector<Vec2> points;
  std::vector<std::array<int, 4>> quads;  // counter-clockwise
};

QuadGrid o_grid(const PolarOutline& outline, double size) {
  double perimeter = 0, half_width = 0, half_height = 0;
  for (int i = 0; i < outline_samples; ++i) {
    const Vec2 a = point_at(outline, 2 * pi * i / outline_samples), b = point_at(outline, 2 * pi * (i + 1) / outline_samples);
    perimeter += (b - a).norm();
    half_width = std::max(half_width, std::abs(a.x()));
    half_height = std::max(half_height, std::abs(a.y()));
  }
  const int n = std::max(2, static_cast<int>(std::lround(perimeter / 4 / size)));
  const int rings = std::max(2, static_cast<int>(std::lround((1 - core_share) * 0.5 * (half_width + half_height) / size)));
  // Corners of the block lie at 45 degrees of the ellipse with the outline's widths, so that all four sides have similar lengths.
  auto angle_of = [&](double quarter) {  // quarter in [0, 4): 0 at the corner at -45 degrees
    const double phi = -pi / 4 + quarter * pi / 2;
    return std::atan2(half_height * std::sin(phi), half_width * std::cos(phi));
  };
  auto rim = [&](double quarter) { return point_at(outline, angle_of(quarter)); };
  auto core_rim = [&](int side, double t) -> Vec2 {
    const Vec2 straight = (1 - t) * core_share * rim(side) + t * core_share * rim(side + 1);
    return (1 - core_bulge) * straight + core_bulge * core_share * rim(side + t);
  };
  QuadGrid g;
  // Central block by transfinite interpolation; i runs along side 0 (right side, upwards), j from right to left.
  auto core = [&](int i, int j) { return i * (n + 1) + j; };
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) {
      const double s = static_cast<double>(i) / n, t = static_cast<double>(j) / n;
      const Vec2 right = core_rim(0, s), top = core_rim(1, t), left = core_rim(2, 1 - s), bottom = core_rim(3, 1 - t);
      const Vec2 corners = (1 - s) * (1 - t) * core_rim(0, 0) + s * (1 - t) * core_rim(1, 0) + s * t * core_rim(2, 0) +
                           (1 - s) * t * core_rim(3, 0);
      g.points.push_back((1 - t) * right + t * left + (1 - s) * bottom + s * top - corners);
    }
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) g.quads.push_back({core(i, j), core(i + 1, j), core(i + 1, j + 1), core(i, j + 1)});
  auto core_rim_index = [&](int k) {
    k %= 4 * n;
    const int side = k / n, t = k % n;
    return side == 0 ? core(t, 0) : side == 1 ? core(n, t) : side == 2 ? core(n - t, n) : core(0, n - t);
  };
  const int first_ring = static_cast<int>(g.points.size());
  auto ring_index = [&](int ring, int k) {
    return ring == 0 ? core_rim_index(k) : first_ring + (ring - 1) * 4 * n + k % (4 * n);
  };
  for (int ring = 1; ring <= rings; ++ring)
    for (int k = 0; k < 4 * n; ++k) {
      const double t = static_cast<double>(ring) / rings;
      g.points.push_back((1 - t) * g.points[at(core_rim_index(k))] + t * rim(static_cast<double>(k) / n));
    }
  for (int ring = 0; ring < rings; ++ring)
    for (int k = 0; k < 4 * n; ++k)
      g.quads.push_back({ring_index(ring, k), ring_index(ring + 1, k), ring_index(ring + 1, k + 1), ring_index(ring, k + 1)});
  return g;
}

void fill_hexahedra(Tube& tube, const PolarOutline& outline, double size) {
  const QuadGrid layer = o_grid(outline, size);
  const int levels = std::max(1, static_cast<int>(std::lround((tube.z_atrium - tube.z_ventricle) / size)));
  const int n = static_cast<int>(layer.points.size());
  for (int l = 0; l <= levels; ++l)
    for (const Vec2& p : layer.points) {
      const double z = tube.z_ventricle + (tube.z_atrium - tube.z_ventricle) * l / levels;
      tube.points.push_back(tube.origin + tube.axes.transpose() * Vec3(p.x(), p.y(), z));
    }
  for (int l = 0; l < levels; ++l)
    for (const auto& q : layer.quads) {
      std::array<int, 8> hex{};
      for (std::size_t k = 0; k < 4; ++k) {
        hex[k] = l * n + q[k];
        hex[k + 4] = (l + 1) * n + q[k];
      }
      tube.hexes.push_back(hex);
    }
}

void fill_grid(Tube& tube, const TubeOptions& options) {
  const double h = options.spacing;
  Vec2 lower(1e300, 1e300), upper(-1e300, -1e300);
  for (const Vec2& p : tube.cross_section) {
    lower = lower.cwiseMin(p);
    upper = upper.cwiseMax(p);
  }
  tube.grid_spacing = h;
  for (std::size_t k = 0; k < 2; ++k) {
    const auto e = static_cast<Eigen::Index>(k);
    tube.grid_cells[k] = static_cast<int>(std::ceil((upper[e] - lower[e]) / h)) + 2 * options.margin_cells;
    tube.grid_lower[e] = 0.5 * (lower[e] + upper[e]) - 0.5 * tube.grid_cells[k] * h;
  }
  tube.grid_cells[2] = static_cast<int>(std::lround((tube.z_atrium - tube.z_ventricle) / h));
  tube.grid_lower[2] = tube.z_ventricle;
}

/// Jacobian of the corner and its three neighbours, right-handed, VTK ordering.
constexpr std::array<std::array<std::size_t, 4>, 8> hex_corners{
    {{0, 1, 3, 4}, {1, 2, 0, 5}, {2, 3, 1, 6}, {3, 0, 2, 7}, {4, 7, 5, 0}, {5, 4, 6, 1}, {6, 5, 7, 2}, {7, 6, 4, 3}}};

}  // namespace

Tube build_tube(const Annulus& annulus, const TubeOptions& options, TubeReport* report) {
  const double h = options.spacing;
  if (!(h > 0)) throw ConfigError("tube.spacing must be positive");
  if (!(options.length_ventricle > h) || !(options.length_atrium > h))
    throw ConfigError("tube.length_ventricle and tube.length_atrium must be longer than one fluid cell (tube.spacing)");
  if (options.margin_cells < 1) throw ConfigError("tube.margin_cells must be at least 1");
  TubeReport local;
  Tube tube;
  tube.origin = annulus.origin;
  const Vec3 e3 = -annulus.normal.normalized();
  const Vec3 e1 = (annulus.axis_major - annulus.axis_major.dot(e3) * e3).normalized();
  tube.axes.row(0) = e1.transpose();
  tube.axes.row(1) = e3.cross(e1).transpose();
  tube.axes.row(2) = e3.transpose();

  auto flat = [&](const Vec3& x) -> Vec2 { return to_tube(tube, x).head<2>(); };
  std::vector<Vec2> rim, inside;
  for (const Vec3& p : annulus.points) rim.push_back(flat(p));
  PolarOutline outline = smooth_polar_outline(rim, options.harmonics, outline_samples, &local.smoothing_max);
  inside = rim;
  double lowest = 0, highest = 0;
  for (const Vec3& p : annulus.points) {
    lowest = std::min(lowest, to_tube(tube, p).z());
    highest = std::max(highest, to_tube(tube, p).z());
  }
  for (const Vec3& p : options.contained) {
    inside.push_back(flat(p));
    lowest = std::min(lowest, to_tube(tube, p).z());
    highest = std::max(highest, to_tube(tube, p).z());
  }
  local.widened = widen_to_contain(outline, inside, options.clearance);
  std::vector<Vec2> tips;
  for (const Vec3& p : options.tips) {
    tips.push_back(flat(p));
    lowest = std::min(lowest, to_tube(tube, p).z());
  }
  if (options.widen_for_tips) {
    const double shift = widen_to_contain(outline, tips, options.clearance);
    local.widened += shift;
    if (shift > 0)
      local.notes.push_back(fmt::format(
          "tube widened by up to {:.2f} mm so that the papillary tips lie inside; blood can pass between wall and annulus there",
          shift));
  }
  for (const Vec2& p : tips)
    local.tips_outside = std::max(local.tips_outside, p.norm() - radius_at(outline, std::atan2(p.y(), p.x())));
  if (local.tips_outside > 0)
    local.notes.push_back(fmt::format(
        "a papillary tip lies {:.2f} mm outside the tube's wall; the wall follows the annulus and does not act on chordae",
        local.tips_outside));
  for (int i = 0; i < outline_samples; ++i) tube.cross_section.push_back(point_at(outline, 2 * pi * i / outline_samples));
  local.gap_min = 1e300;
  for (const Vec2& p : rim) {
    const double gap = radius_at(outline, std::atan2(p.y(), p.x())) - p.norm();
    local.gap_min = std::min(local.gap_min, gap);
    local.gap_max = std::max(local.gap_max, gap);
  }

  const double needed_ventricle = std::max(options.length_ventricle, -lowest + tube_end_cells * h);
  const double needed_atrium = std::max(options.length_atrium, highest + tube_end_cells * h);
  tube.z_ventricle = -h * std::ceil(needed_ventricle / h - 1e-9);
  tube.z_atrium = h * std::ceil(needed_atrium / h - 1e-9);
  local.lengthened_ventricle = -tube.z_ventricle - options.length_ventricle;
  if (needed_ventricle > options.length_ventricle)
    local.notes.push_back(
        fmt::format("ventricular side lengthened from {:.1f} to {:.1f} mm: the lowest papillary tip or leaflet point lies {:.1f} "
                    "mm below the annulus plane",
                    options.length_ventricle, -tube.z_ventricle, -lowest));
  if (needed_atrium > options.length_atrium)
    local.notes.push_back(
        fmt::format("atrial side lengthened from {:.1f} to {:.1f} mm: the annulus reaches {:.1f} mm above its plane",
                    options.length_atrium, tube.z_atrium, highest));
  fill_grid(tube, options);
  fill_hexahedra(tube, outline, options.hex_size > 0 ? options.hex_size : 2 * h);
  local.jacobian_min = smallest_scaled_jacobian(tube);
  if (!(local.jacobian_min > 0))
    throw GateError(
        fmt::format("tube: a hexahedron of the cross-section is inverted (scaled Jacobian {:.3f}); lower tube harmonics or "
                    "smooth the annulus",
                    local.jacobian_min));
  if (report) *report = local;
  return tube;
}

double smallest_scaled_jacobian(const Tube& tube) {
  double smallest = 1e300;
  for (const auto& hex : tube.hexes)
    for (const auto& c : hex_corners) {
      const Vec3 o = tube.points[at(hex[c[0]])];
      Mat3 edges;
      for (Eigen::Index k = 0; k < 3; ++k)
        edges.col(k) = (tube.points[at(hex[c[static_cast<std::size_t>(k) + 1]])] - o).normalized();
      smallest = std::min(smallest, edges.determinant());
    }
  return smallest;
}

double hex_volume(const Tube& tube) {
  // Two-point Gauss rule in each direction: exact for trilinear hexahedra.
  const double g = 1 / std::sqrt(3.0);
  constexpr std::array<std::array<int, 3>, 8> corner{
      {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}}};
  double volume = 0;
  for (const auto& hex : tube.hexes)
    for (const auto& q : corner) {
      const std::array<double, 3> x{g * q[0], g * q[1], g * q[2]};
      Mat3 J = Mat3::Zero();
      for (std::size_t i = 0; i < 8; ++i) {
        const std::array<double, 3> f{1 + corner[i][0] * x[0], 1 + corner[i][1] * x[1], 1 + corner[i][2] * x[2]};
        const Vec3 gradient(corner[i][0] * f[1] * f[2], f[0] * corner[i][1] * f[2], f[0] * f[1] * corner[i][2]);
        J += tube.points[at(hex[i])] * gradient.transpose() / 8;
      }
      volume += J.determinant();
    }
  return volume;
}

bool inside_outline(const std::vector<Vec2>& outline, const Vec2& p) {
  bool inside = false;
  for (std::size_t i = 0, j = outline.size() - 1; i < outline.size(); j = i++) {
    const Vec2 &a = outline[i], &b = outline[j];
    if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < a.x() + (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()))
      inside = !inside;
  }
  return inside;
}

std::vector<Gate> check_tube(const Tube& tube, const Annulus& annulus, const std::vector<Vec3>& tips) {
  Gate jacobian{"tube.jacobian_min", false, smallest_scaled_jacobian(tube), 0.1, ">=", "", -1, ""};
  jacobian.passed = !tube.hexes.empty() && jacobian.value >= jacobian.limit;
  jacobian.message = fmt::format("{} hexahedra, {:.1f} mm3, smallest scaled Jacobian {:.3f}", tube.hexes.size(), hex_volume(tube),
                                 jacobian.value);
  auto count_outside = [](const std::vector<Vec3>& points, const char* name, const std::string& what, auto&& is_inside) {
    Gate gate{name, false, 0, 0, "==", "points", -1, ""};
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (is_inside(points[i])) continue;
      if (gate.value == 0) gate.worst_element = static_cast<long>(i);
      ++gate.value;
    }
    gate.passed = gate.value == 0;
    gate.message = gate.passed ? fmt::format("none of {} {}", points.size(), what)
                               : fmt::format("{} of {} {}, first number {}", gate.value, points.size(), what, gate.worst_element);
    return gate;
  };
  auto in_wall = [&](const Vec3& p) {
    const Vec3 x = to_tube(tube, p);
    return inside_outline(tube.cross_section, x.head<2>()) && x.z() > tube.z_ventricle && x.z() < tube.z_atrium;
  };
  auto in_box = [&](const Vec3& p) {
    const Vec3 x = to_tube(tube, p) - tube.grid_lower;
    for (Eigen::Index k = 0; k < 3; ++k)
      if (!(x[k] > 0 && x[k] < tube.grid_cells[static_cast<std::size_t>(k)] * tube.grid_spacing)) return false;
    return true;
  };
  return {jacobian, count_outside(annulus.points, "tube.annulus_outside", "annulus points lies outside the wall", in_wall),
          count_outside(tips, "tube.tips_outside", "papillary tips lies outside the fluid grid", in_box)};
}

}  // namespace mv
