// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/loft/curve_surface.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/core/errors.h"
#include "geometry/loft/curve_checks.h"
#include "geometry/loft/ring_parameters.h"

namespace mv {
namespace {

using std::numbers::pi;
constexpr int correction_rounds = 6;       // fits with corrected parameters in between
constexpr double annulus_weight = 2;       // of a point of the smoothed annulus against a curve point
constexpr double least_visibility = 0.05;  // of a sheet cut nearly along itself
constexpr double thickness_visibility = 0.25;
constexpr double tip_layer = 1.5;          // mm, of a muscle that counts as its tip

struct Fitted {
  SplineSurface surface;
  std::vector<CurveData> curves;
  std::vector<std::vector<double>> distances;  // of the curve points
  FitReport report;
  int folds = 0;
};

/// sin^2 of the angle between slice and sheet: how sharply the slice shows the sheet.
double visibility(const SplineSurface& surface, const SurfaceDatum& d, const Vec3& plane_normal) {
  if (plane_normal.norm() == 0) return 1;
  const double c = surface.normal(d.u, d.v).dot(plane_normal);
  return std::max(least_visibility, 1 - c * c);
}

/// Edges across which the sampled surface turns by more than 100 degrees.
int count_folds(const SplineSurface& surface) {
  constexpr int n = 120, m = 14;
  std::vector<Vec3> normals;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < m; ++j) {
      const auto x = [&](int k, int l) { return surface.at(surface.period() * k / n, static_cast<double>(l) / m); };
      normals.push_back((x(i + 1, j + 1) - x(i, j)).cross(x(i, j + 1) - x(i + 1, j)).normalized());
    }
  const double limit = std::cos(100 * pi / 180);
  int folds = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < m; ++j) {
      const Vec3& a = normals[static_cast<std::size_t>(i * m + j)];
      if (a.dot(normals[static_cast<std::size_t>((i + 1) % n * m + j)]) < limit) ++folds;
      if (j + 1 < m && a.dot(normals[static_cast<std::size_t>(i * m + j + 1)]) < limit) ++folds;
    }
  return folds;
}

std::vector<SurfaceDatum> gather(const std::vector<CurveData>& curves, const HingeAnnulus& annulus, double radius, int annulus_points) {
  std::vector<SurfaceDatum> data;
  for (int i = 0; i < annulus_points; ++i) {
    const double angle = 2 * pi * i / annulus_points;
    data.push_back({annulus.at(angle), angle * radius, 0, annulus_weight, true});
  }
  for (const auto& c : curves) data.insert(data.end(), c.data.begin(), c.data.end());
  return data;
}

/// Fit, correct the parameters to the closest points, fit again.
Fitted fit_surface(const CurveSet& set, const std::vector<CurveData>& guess, const HingeAnnulus& annulus, double radius, double height,
                   const CurveSurfaceOptions& options, const Smoothing& smoothing) {
  const int segments_u = std::clamp(static_cast<int>(std::lround(2 * pi * radius / options.knot_spacing)), 12, 48);
  const int segments_v = std::clamp(static_cast<int>(std::lround(height / options.knot_spacing)), 3, 10);
  Fitted f{SplineSurface(segments_u, segments_v, 2 * pi * radius, height), guess, {}, {}, 0};
  for (int round = 0; round < correction_rounds; ++round) {
    f.report = f.surface.fit(gather(f.curves, annulus, radius, 3 * segments_u), smoothing);
    f.distances.clear();
    for (std::size_t i = 0; i < f.curves.size(); ++i) {
      f.distances.emplace_back();
      for (SurfaceDatum& d : f.curves[i].data) {
        if (round + 1 < correction_rounds) {
          f.distances.back().push_back(f.surface.project(d));
          d.weight = visibility(f.surface, d, set.curves[i].plane_normal);
        } else {
          SurfaceDatum free = d;
          free.is_v_fixed = false;
          f.distances.back().push_back(f.surface.project(free));
        }
      }
    }
  }
  f.folds = count_folds(f.surface);
  return f;
}

Fitted fit_without_folds(const CurveSet& set, const std::vector<CurveData>& guess, const HingeAnnulus& annulus, double radius, double height,
                         const CurveSurfaceOptions& options, std::vector<std::string>& notes) {
  Fitted best = fit_surface(set, guess, annulus, radius, height, options, options.smoothing);
  const double first = best.report.lambda;
  for (int more = 1; more <= 4 && best.folds > 0; ++more) {
    Smoothing smoother = options.smoothing;
    smoother.rule = SmoothingRule::fixed;
    smoother.lambda = first * std::pow(10.0, more);
    best = fit_surface(set, guess, annulus, radius, height, options, smoother);
    if (best.folds == 0) notes.push_back(fmt::format("the leaflets were smoothed {:.0f} times more than the data ask for, because the surface folded", std::pow(10.0, more)));
  }
  if (best.folds > 0)
    throw InputError("the curves do not lie on one smooth sheet: the surface fitted to them folds; expected curves from annulus to free edge that do not pass "
                     "through each other");
  return best;
}

void measure_deviation(const CurveSet& set, const Fitted& f, CurveSurfaceReport& report) {
  std::vector<double> all;
  for (std::size_t i = 0; i < f.distances.size(); ++i)
    for (const double d : f.distances[i]) {
      all.push_back(d);
      report.deviation_mean += d;
      if (d > report.deviation_max) report.deviation_max = d, report.deviation_max_at = set.curves[i].name;
    }
  report.deviation_mean /= static_cast<double>(all.size());
  std::sort(all.begin(), all.end());
  report.deviation_95 = all[static_cast<std::size_t>(0.95 * static_cast<double>(all.size() - 1))];
}

/// Moves the two borders between the leaflets to where they misplace the fewest labelled points.
void refine_split(const std::vector<CurveData>& curves, double radius, RingSplit& split) {
  for (double RingSplit::*border : {&RingSplit::to_anterior, &RingSplit::to_posterior}) {
    const double start = split.*border;
    double best = start, last = start;
    long fewest = -1;
    for (int k = -120; k <= 120; ++k) {
      const double trial = start + k * 0.5 * pi / 180;
      RingSplit s = split;
      s.*border = trial;
      long wrong = 0;
      for (const auto& c : curves)
        for (std::size_t i = 0; i < c.data.size(); ++i)
          if (c.region[i] != 0 && is_in_anterior_sector(s, c.data[i].u / radius) != (c.region[i] == anterior)) ++wrong;
      if (fewest < 0 || wrong < fewest) fewest = wrong, best = last = trial;
      else if (wrong == fewest && trial - last < 0.51 * pi / 180) last = trial;
    }
    split.*border = 0.5 * (best + last);
  }
}

std::vector<double> thickness_on_grid(const CurveSet& set, const Fitted& f, const CurveSurfaceOptions& options, const std::vector<Vec2>& grid) {
  std::vector<SurfaceDatum> data;
  std::vector<double> values;
  for (std::size_t i = 0; i < f.curves.size(); ++i)
    for (std::size_t k = 0; k < f.curves[i].thickness.size(); ++k) {
      const double seen = visibility(f.surface, f.curves[i].data[k], set.curves[i].plane_normal);
      if (seen < thickness_visibility) continue;
      data.push_back(f.curves[i].data[k]);
      data.back().weight = seen;
      values.push_back(f.curves[i].thickness[k] * std::sqrt(seen));  // a sheet cut at a slant looks thicker
    }
  if (!options.with_thickness || values.size() < 20) return {};
  Smoothing smoothing;
  const Eigen::VectorXd field = f.surface.fit_field(data, Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())), smoothing);
  std::sort(values.begin(), values.end());
  const auto n = static_cast<double>(values.size() - 1);
  const double low = values[static_cast<std::size_t>(0.02 * n)], high = values[static_cast<std::size_t>(0.98 * n)];
  std::vector<double> thickness;
  for (const Vec2& uv : grid) thickness.push_back(std::clamp(f.surface.field(field, uv.x(), uv.y()), low, high));
  return thickness;
}

/// Triangles on a regular grid of (u, v).
void triangulate(const Fitted& f, double radius, double height, const RingSplit& split, const CurveSurfaceOptions& options, bool is_mirrored, RawLeaflets& raw,
                 std::vector<Vec2>& grid) {
  const int n = std::max(24, static_cast<int>(std::lround(f.surface.period() / options.triangle_size)));
  const int m = std::max(4, static_cast<int>(std::lround(height / options.triangle_size)));
  for (int i = 0; i < n; ++i)
    for (int j = 0; j <= m; ++j) {
      grid.emplace_back(f.surface.period() * i / n, static_cast<double>(j) / m);
      raw.points.push_back(f.surface.at(grid.back().x(), grid.back().y()));
    }
  const auto at = [&](int i, int j) { return (i % n) * (m + 1) + j; };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < m; ++j) {
      const int region = is_in_anterior_sector(split, f.surface.period() * (i + 0.5) / n / radius) ? anterior : posterior;
      const int a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
      const auto length = [&](int p, int q) { return (raw.points[static_cast<std::size_t>(p)] - raw.points[static_cast<std::size_t>(q)]).norm(); };
      std::array<std::array<int, 3>, 2> pair = length(a, c) < length(b, d) ? std::array<std::array<int, 3>, 2>{{{a, b, c}, {a, c, d}}}
                                                                           : std::array<std::array<int, 3>, 2>{{{a, b, d}, {b, c, d}}};
      for (auto t : pair) {
        if (is_mirrored) std::swap(t[1], t[2]);
        raw.triangles.push_back(t);
        raw.region.push_back(region);
      }
    }
}

void measure_areas(const RawLeaflets& raw, CurveSurfaceReport& report) {
  for (std::size_t t = 0; t < raw.triangles.size(); ++t) {
    const auto& k = raw.triangles[t];
    const Vec3 &a = raw.points[static_cast<std::size_t>(k[0])], &b = raw.points[static_cast<std::size_t>(k[1])], &c = raw.points[static_cast<std::size_t>(k[2])];
    const double area = 0.5 * (b - a).cross(c - a).norm();
    (raw.region[t] == anterior ? report.area_anterior : report.area_posterior) += area;
    report.area += area;
  }
}

/// Mean of the layer of a muscle that lies nearest to the valve.
Vec3 tip_of(const std::vector<Vec3>& cloud, const Vec3& ventricle_direction) {
  std::vector<double> depth;
  for (const Vec3& p : cloud) depth.push_back(p.dot(ventricle_direction));
  const double first = *std::min_element(depth.begin(), depth.end());
  Vec3 sum = Vec3::Zero();
  double count = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (depth[i] <= first + tip_layer) sum += cloud[i], ++count;
  return sum / count;
}

void require_enough(const CurveSet& set, CurveSurfaceReport& report) {
  for (const auto& c : set.curves) {
    if (c.end == CurveEnd::free_edge) ++(c.region == anterior ? report.curves_anterior : report.curves_posterior);
    else ++report.arches;
  }
  if (report.curves_anterior + report.curves_posterior == 0) throw InputError("no leaflet curve reaches a free edge; expected curves from annulus to free edge");
  for (const auto& [count, name, other] : {std::tuple(report.curves_anterior, "anterior", report.curves_posterior), std::tuple(report.curves_posterior, "posterior", report.curves_anterior)}) {
    if (count == 0)
      throw InputError(fmt::format("curves of one leaflet only: {} curves reach the free edge of the other leaflet, none that of the {} leaflet; expected at "
                                   "least 3 of each (check the labels or the column 'leaflet')",
                                   other, name));
    if (count < 3)
      throw InputError(fmt::format("{} curve{} of the {} leaflet from annulus to free edge, at least 3 are needed; give more slices or curves", count, count == 1 ? "" : "s", name));
  }
}

std::vector<Vec3> hinge_points(const CurveSet& set) {
  if (!set.annulus_curve.empty()) return set.annulus_curve;
  std::vector<Vec3> points = set.annulus_points;
  for (const auto& c : set.curves) {
    points.push_back(c.points.front());
    if (c.end == CurveEnd::annulus) points.push_back(c.points.back());
  }
  return points;
}

double mean_length(const CurveSet& set) {
  double sum = 0, n = 0;
  for (const auto& c : set.curves) {
    if (c.end != CurveEnd::free_edge) continue;
    for (std::size_t i = 1; i < c.points.size(); ++i) sum += (c.points[i] - c.points[i - 1]).norm();
    ++n;
  }
  return sum / n;
}

}  // namespace

RawLeaflets surface_from_curves(CurveSet set, const CurveSurfaceOptions& options, CurveSurfaceReport* report) {
  CurveSurfaceReport local;
  clean_curves(set);
  orient_curves(set, options.is_order_meant);
  assign_regions(set);
  const std::vector<std::vector<int>> regions = join_arches(set);
  require_enough(set, local);

  AnnulusOptions annulus_options;
  annulus_options.limits = set.empty_slices;
  annulus_options.limit_normal = set.stack_normal;
  const HingeAnnulus annulus(hinge_points(set), annulus_options);
  local.annulus = annulus.report();
  RingSplit split = split_ring(set, annulus);
  const double radius = annulus.length() / (2 * pi), height = mean_length(set);
  const std::vector<CurveData> guess = ring_parameters(set, regions, annulus, split, radius, options.point_spacing);
  const Fitted fitted = fit_without_folds(set, guess, annulus, radius, height, options, set.notes);
  local.fit = fitted.report;
  measure_deviation(set, fitted, local);
  refine_split(fitted.curves, radius, split);

  RawLeaflets raw;
  Vec3 depth = Vec3::Zero();
  for (const auto& c : set.curves)
    if (c.end == CurveEnd::free_edge) depth += c.points.back() - c.points.front();
  raw.ventricle_direction = (annulus.frame().normal.dot(depth) > 0 ? 1 : -1) * annulus.frame().normal;
  std::vector<Vec2> grid;
  triangulate(fitted, radius, height, split, options, annulus.frame().normal.dot(depth) > 0, raw, grid);
  raw.thickness = thickness_on_grid(set, fitted, options, grid);
  for (const double t : raw.thickness) local.thickness_mean += t / static_cast<double>(raw.thickness.size());
  measure_areas(raw, local);
  for (int i = 0; i < 720; ++i) raw.annulus_curve.push_back(fitted.surface.at(fitted.surface.period() * i / 720, 0));
  int k = 0;
  for (const double angle : {split.to_anterior, split.to_posterior}) {
    raw.commissures.push_back(fitted.surface.at(angle * radius, 0));
    for (int j = 0; j < 50; ++j)
      local.commissure_height[k] += (fitted.surface.at(angle * radius, (j + 1) / 50.0) - fitted.surface.at(angle * radius, j / 50.0)).norm();
    ++k;
  }
  raw.papillary_points = set.papillary_points;
  raw.papillary_names = set.papillary_names;
  raw.papillary_names.resize(raw.papillary_points.size());
  for (std::size_t i = 0; i < set.papillary_clouds.size(); ++i) {
    raw.papillary_points.push_back(tip_of(set.papillary_clouds[i], *raw.ventricle_direction));
    raw.papillary_names.push_back(set.papillary_cloud_names[i]);
  }
  raw.notes = set.notes;
  if (report) *report = local;
  return raw;
}

}  // namespace mv
