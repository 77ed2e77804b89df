// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/annulus/closed_curve.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "geometry/core/errors.h"

namespace mv {
namespace {

constexpr std::size_t fewest_points = 8;
/// A measured annulus never turns back on itself; a sharper turn than this is a digitising spike.
const double spike_cosine = std::cos(120.0 * std::numbers::pi / 180.0);
constexpr double most_spikes = 0.5;  // of the points; noise as large as their distance stays below
constexpr std::size_t coarse_points = 200;  // by which noisy dense points are judged

double extent(const std::vector<Vec3>& points) {
  Vec3 lower = points.front(), upper = points.front();
  for (const Vec3& p : points) {
    lower = lower.cwiseMin(p);
    upper = upper.cwiseMax(p);
  }
  return (upper - lower).norm();
}

bool is_straight(const std::vector<Vec3>& points) {
  const double size = extent(points);
  return std::all_of(points.begin(), points.end(), [&](const Vec3& p) {
    const Vec3 along = points[1] - points[0];
    return along.cross(p - points[0]).norm() <= 1e-6 * size * along.norm();
  });
}

/// Cumulative chord length; the last entry is the closed length.
std::vector<double> chord_lengths(const std::vector<Vec3>& points) {
  std::vector<double> s(points.size() + 1, 0.0);
  for (std::size_t i = 0; i < points.size(); ++i) s[i + 1] = s[i] + (points[(i + 1) % points.size()] - points[i]).norm();
  return s;
}

/// Points at equal chord length along a closed polygon.
std::vector<Vec3> uniform_polygon(const std::vector<Vec3>& points, int n) {
  const std::vector<double> s = chord_lengths(points);
  std::vector<Vec3> result;
  std::size_t k = 0;
  for (int i = 0; i < n; ++i) {
    const double target = s.back() * i / n;
    while (k + 1 < points.size() && s[k + 1] <= target) ++k;
    const double t = (target - s[k]) / (s[k + 1] - s[k]);
    result.push_back((1 - t) * points[k] + t * points[(k + 1) % points.size()]);
  }
  return result;
}

/// Catmull-Rom on four neighbours with chord-length (centripetal exponent one) knots, so uneven sampling does not overshoot.
Vec3 catmull_rom(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, double t) {
  const double h0 = (b - a).norm(), h1 = (c - b).norm(), h2 = (d - c).norm();
  const Vec3 slope_b = ((b - a) / h0 * h1 + (c - b) / h1 * h0) / (h0 + h1) * h1;
  const Vec3 slope_c = ((c - b) / h1 * h2 + (d - c) / h2 * h1) / (h1 + h2) * h1;
  const double t2 = t * t, t3 = t2 * t;
  return (2 * t3 - 3 * t2 + 1) * b + (t3 - 2 * t2 + t) * slope_b + (-2 * t3 + 3 * t2) * c + (t3 - t2) * slope_c;
}

/// Removes points where the curve turns back; returns how many.
int remove_spikes(std::vector<Vec3>& kept) {
  int removed = 0;
  for (std::size_t i = 0; i < kept.size() && kept.size() > fewest_points;) {
    const std::size_t n = kept.size();
    const Vec3 before = kept[i] - kept[(i + n - 1) % n], after = kept[(i + 1) % n] - kept[i];
    if (before.dot(after) < spike_cosine * before.norm() * after.norm()) {
      kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(i));
      ++removed;
      i = i > 0 ? i - 1 : 0;
    } else {
      ++i;
    }
  }
  return removed;
}

/// Whether the curve turns back no more often than a measured one. Dense points turn back at every step of their noise, so theirs is judged by every n-th;
/// n is odd, or of two halves in turn one would be taken for the whole.
bool is_in_order(const std::vector<Vec3>& points) {
  const std::size_t step = points.size() / coarse_points | 1;
  std::vector<Vec3> coarse;
  for (std::size_t i = 0; i < points.size(); i += step) coarse.push_back(points[i]);
  const double count = static_cast<double>(coarse.size());
  return remove_spikes(coarse) <= most_spikes * count;
}

}  // namespace

std::vector<Vec3> clean_closed_curve(const std::vector<Vec3>& points, CurveReport* report, const std::string& name) {
  CurveReport local;
  local.points_read = static_cast<int>(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!points[i].allFinite()) throw InputError(name + ": point " + std::to_string(i) + " is not finite");
  if (points.size() < fewest_points)
    throw InputError(name + ": " + std::to_string(points.size()) + " points, at least 8 are needed");
  const double tolerance = 1e-6 * extent(points);
  std::vector<Vec3> kept;
  for (const Vec3& p : points)
    if (kept.empty() || (p - kept.back()).norm() > tolerance) kept.push_back(p);
  while (kept.size() > 1 && (kept.front() - kept.back()).norm() <= tolerance) kept.pop_back();
  local.duplicates_removed = static_cast<int>(points.size() - kept.size());
  if (kept.size() >= fewest_points && is_straight(kept)) throw InputError(name + ": the points lie on a line, no plane can be fitted");
  const std::vector<Vec3> distinct = kept;
  local.spikes_removed = remove_spikes(kept);
  if (local.spikes_removed > most_spikes * local.points_read && !is_in_order(distinct))
    throw InputError(name + ": the points of the annulus are not in order: the curve turns back at " + std::to_string(local.spikes_removed) + " of " + std::to_string(local.points_read) +
                     "; list them one after the other around the annulus");
  if (kept.size() < fewest_points)
    throw InputError(name + ": only " + std::to_string(kept.size()) + " distinct points remain, at least 8 are needed");
  if (report) *report = local;
  return kept;
}

ClosedCurve::ClosedCurve(const std::vector<Vec3>& ordered, int samples) {
  if (ordered.size() < fewest_points) throw InputError("closed curve: at least 8 points are needed");
  const std::size_t n = ordered.size();
  for (std::size_t i = 0; i < n; ++i)
    if (!((ordered[(i + 1) % n] - ordered[i]).norm() > 0))
      throw InputError("closed curve: repeated or non-finite point " + std::to_string(i));
  const int per_interval = std::max(2, 2 * samples / static_cast<int>(n));
  std::vector<Vec3> dense;
  for (std::size_t i = 0; i < n; ++i)
    for (int k = 0; k < per_interval; ++k)
      dense.push_back(catmull_rom(ordered[(i + n - 1) % n], ordered[i], ordered[(i + 1) % n], ordered[(i + 2) % n],
                                  static_cast<double>(k) / per_interval));
  samples_ = uniform_polygon(dense, samples);
  length_ = chord_lengths(samples_).back();
}

Vec3 ClosedCurve::at(double u) const {
  const auto n = static_cast<long>(samples_.size());
  double x = u / length_ * static_cast<double>(n);
  const double cell = std::floor(x);
  const double t = x - cell;
  auto point = [&](long i) -> const Vec3& { return samples_[static_cast<std::size_t>(((i % n) + n) % n)]; };
  const long i = static_cast<long>(cell);
  const Vec3 &a = point(i - 1), &b = point(i), &c = point(i + 1), &d = point(i + 2);
  return 0.5 * ((2 * b) + t * ((c - a) + t * ((2 * a - 5 * b + 4 * c - d) + t * (3 * b - a - 3 * c + d))));
}

Vec3 ClosedCurve::tangent(double u) const {
  const double h = length_ / static_cast<double>(samples_.size());
  return (at(u + h) - at(u - h)) / (2 * h);
}

std::vector<Vec3> ClosedCurve::resampled(int n, double u_start) const {
  std::vector<Vec3> points;
  for (int i = 0; i < n; ++i) points.push_back(at(u_start + length_ * i / n));
  return points;
}

double ClosedCurve::closest(const Vec3& x) const {
  std::size_t best = 0;
  for (std::size_t i = 1; i < samples_.size(); ++i)
    if ((samples_[i] - x).squaredNorm() < (samples_[best] - x).squaredNorm()) best = i;
  const double h = length_ / static_cast<double>(samples_.size());
  double lower = (static_cast<double>(best) - 1) * h, upper = (static_cast<double>(best) + 1) * h;
  for (int k = 0; k < 60; ++k) {
    const double a = lower + (upper - lower) / 3, b = upper - (upper - lower) / 3;
    if ((at(a) - x).squaredNorm() < (at(b) - x).squaredNorm())
      upper = b;
    else
      lower = a;
  }
  const double u = 0.5 * (lower + upper);
  return u < 0 ? u + length_ : (u >= length_ ? u - length_ : u);
}

std::vector<Vec3> smooth_closed_curve(const std::vector<Vec3>& ordered, int harmonics, int samples, CurveReport* report) {
  constexpr int modes = 1024;
  const std::vector<Vec3> uniform = uniform_polygon(ordered, modes);
  using std::numbers::pi;
  std::vector<Vec3> cosine(static_cast<std::size_t>(harmonics) + 1, Vec3::Zero()), sine = cosine;
  for (int k = 0; k <= harmonics; ++k)
    for (int i = 0; i < modes; ++i) {
      const double angle = 2 * pi * k * i / modes;
      cosine[static_cast<std::size_t>(k)] += uniform[static_cast<std::size_t>(i)] * std::cos(angle) * ((k ? 2.0 : 1.0) / modes);
      sine[static_cast<std::size_t>(k)] += uniform[static_cast<std::size_t>(i)] * std::sin(angle) * (2.0 / modes);
    }
  auto evaluate = [&](double t) {
    Vec3 x = cosine[0];
    for (int k = 1; k <= harmonics; ++k) {
      // Lanczos factor for the upper half of the spectrum only: the shape-carrying low modes stay untouched.
      const double over = std::max(0.0, 2.0 * k / (harmonics + 1) - 1.0);
      const double damping = over > 0 ? std::sin(pi * over) / (pi * over) : 1.0;
      x += damping * (cosine[static_cast<std::size_t>(k)] * std::cos(2 * pi * k * t) +
                      sine[static_cast<std::size_t>(k)] * std::sin(2 * pi * k * t));
    }
    return x;
  };
  std::vector<Vec3> fine;
  const int dense = std::max(samples, 4096);
  for (int i = 0; i < dense; ++i) fine.push_back(evaluate(static_cast<double>(i) / dense));
  const ClosedCurve curve(fine, dense);
  if (report) {
    report->harmonics = harmonics;
    report->smoothing_rms = report->smoothing_max = 0;
    for (const Vec3& p : ordered) {
      const double d = (curve.at(curve.closest(p)) - p).norm();
      report->smoothing_rms += d * d / static_cast<double>(ordered.size());
      if (d > report->smoothing_max) {
        report->smoothing_max = d;
        report->smoothing_max_at = p;
      }
    }
    report->smoothing_rms = std::sqrt(report->smoothing_rms);
  }
  return curve.resampled(samples);
}

}  // namespace mv
