// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/loft/ring_parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/core/errors.h"

namespace mv {
namespace {

using std::numbers::pi;
constexpr double misplaced_allowed = 0.2;

double wrapped(double angle) {
  angle = std::fmod(angle, 2 * pi);
  return angle < 0 ? angle + 2 * pi : angle;
}

struct Hinge {
  double angle;
  int region;
};

std::vector<Hinge> hinges_of(const CurveSet& set, const HingeAnnulus& annulus) {
  std::vector<Hinge> hinges;
  for (const LeafletCurve& c : set.curves)
    if (c.end != CurveEnd::annulus) hinges.push_back({annulus.frame().angle(c.points.front()), c.region});
  std::sort(hinges.begin(), hinges.end(), [](const Hinge& a, const Hinge& b) { return a.angle < b.angle; });
  return hinges;
}

/// Points at equal distances, with the values that go with them.
struct Resampled {
  std::vector<Vec3> points;
  std::vector<double> thickness, share;  // share of the length
  std::vector<int> region;
  double length = 0;
};

Resampled resample(const LeafletCurve& curve, const std::vector<int>& region, double spacing) {
  std::vector<double> s = {0};
  for (std::size_t i = 1; i < curve.points.size(); ++i) s.push_back(s.back() + (curve.points[i] - curve.points[i - 1]).norm());
  Resampled r;
  r.length = s.back();
  const int n = std::max(3, static_cast<int>(std::lround(r.length / spacing)));
  std::size_t k = 0;
  for (int i = 0; i <= n; ++i) {
    const double target = r.length * i / n;
    while (k + 2 < s.size() && s[k + 1] < target) ++k;
    const double t = std::clamp((target - s[k]) / std::max(s[k + 1] - s[k], 1e-12), 0.0, 1.0);
    r.points.push_back((1 - t) * curve.points[k] + t * curve.points[k + 1]);
    if (!curve.thickness.empty()) r.thickness.push_back((1 - t) * curve.thickness[k] + t * curve.thickness[k + 1]);
    r.region.push_back(t < 0.5 ? region[k] : region[k + 1]);
    r.share.push_back(static_cast<double>(i) / n);
  }
  return r;
}

/// Angle of each curve's end: the ends of one leaflet, in the order of their hinges, spread between the commissures by length along the free
/// edge; the gap to the other leaflet's nearest end counts half to each.
std::vector<double> end_angles(const CurveSet& set, const HingeAnnulus& annulus, const RingSplit& split) {
  struct End {
    double along;  // hinge angle from the commissure where the leaflet starts
    std::size_t curve;
  };
  std::vector<double> angles(set.curves.size(), 0.0);
  std::vector<End> ends[2];
  const double starts[2] = {split.to_posterior, split.to_anterior};
  const double spans[2] = {wrapped(split.to_anterior - split.to_posterior), wrapped(split.to_posterior - split.to_anterior)};
  for (std::size_t i = 0; i < set.curves.size(); ++i) {
    const LeafletCurve& c = set.curves[i];
    if (c.end != CurveEnd::free_edge) continue;
    const int k = c.region == anterior ? 1 : 0;
    double along = wrapped(annulus.frame().angle(c.points.front()) - starts[k]);
    // A hinge point just outside of its sector counts as on its border.
    if (along > spans[k]) along = along - spans[k] < 2 * pi - along ? spans[k] : 0.0;
    ends[k].push_back({along, i});
  }
  for (auto& list : ends) std::stable_sort(list.begin(), list.end(), [](const End& a, const End& b) { return a.along < b.along; });
  const auto end_point = [&](const End& e) { return set.curves[e.curve].points.back(); };
  const double gap_at_start[2] = {(end_point(ends[0].front()) - end_point(ends[1].back())).norm(), (end_point(ends[1].front()) - end_point(ends[0].back())).norm()};
  for (int k = 0; k < 2; ++k) {
    std::vector<double> s = {0.5 * gap_at_start[k]};
    for (std::size_t i = 1; i < ends[k].size(); ++i) s.push_back(s.back() + (end_point(ends[k][i]) - end_point(ends[k][i - 1])).norm());
    const double total = s.back() + 0.5 * gap_at_start[1 - k];
    for (std::size_t i = 0; i < s.size(); ++i) angles[ends[k][i].curve] = starts[k] + spans[k] * s[i] / total;
  }
  return angles;
}

/// Difference b - a brought next to `near`.
double turn_to(double from, double to, double span_hint) {
  double d = wrapped(to - from);
  if (std::abs(d - 2 * pi - span_hint) < std::abs(d - span_hint)) d -= 2 * pi;
  return d;
}

}  // namespace

bool is_in_anterior_sector(const RingSplit& split, double angle) {
  return wrapped(angle - split.to_anterior) < wrapped(split.to_posterior - split.to_anterior);
}

RingSplit split_ring(const CurveSet& set, const HingeAnnulus& annulus) {
  const std::vector<Hinge> hinges = hinges_of(set, annulus);
  const auto n = hinges.size();
  const auto of_anterior = static_cast<std::size_t>(std::count_if(hinges.begin(), hinges.end(), [](const Hinge& h) { return h.region == anterior; }));
  if (of_anterior == 0 || of_anterior == n)
    throw InputError(fmt::format("curves of one leaflet only: {} of the {} leaflet; expected curves of both leaflets", n,
                                 of_anterior == 0 ? "posterior" : "anterior"));
  RingSplit best;
  std::size_t fewest = n + 1;
  double widest = -1;
  const auto border = [&](std::size_t i) {  // middle between hinge i-1 and i
    const double a = hinges[(i + n - 1) % n].angle, step = wrapped(hinges[i % n].angle - a);
    return std::pair(wrapped(a + 0.5 * step), step);
  };
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) {
      if (i == j) continue;
      std::size_t wrong = 0;  // anterior: hinges i .. j-1
      for (std::size_t k = 0; k < n; ++k) {
        const bool inside = (k + n - i) % n < (j + n - i) % n;
        if (inside != (hinges[k].region == anterior)) ++wrong;
      }
      const auto [to_anterior, gap_a] = border(i);
      const auto [to_posterior, gap_p] = border(j);
      if (wrong < fewest || (wrong == fewest && gap_a + gap_p > widest)) {
        fewest = wrong;
        widest = gap_a + gap_p;
        best = {to_anterior, to_posterior, 0};
      }
    }
  best.misplaced = static_cast<double>(fewest) / static_cast<double>(n);
  if (best.misplaced > misplaced_allowed)
    throw InputError(fmt::format("the leaflets interleave around the annulus: {} of {} hinge points lie among those of the other leaflet; are anterior and "
                                 "posterior swapped in some curves, or do curves start at the free edge?",
                                 fewest, n));
  return best;
}

std::vector<CurveData> ring_parameters(const CurveSet& set, const std::vector<std::vector<int>>& regions, const HingeAnnulus& annulus,
                                       const RingSplit& split, double radius, double spacing) {
  const std::vector<double> ends = end_angles(set, annulus, split);
  std::vector<CurveData> result;
  for (std::size_t i = 0; i < set.curves.size(); ++i) {
    const LeafletCurve& c = set.curves[i];
    const Resampled r = resample(c, regions[i], spacing);
    const double start = annulus.frame().angle(c.points.front());
    CurveData curve;
    curve.thickness = r.thickness;
    curve.region = r.region;
    double turn = 0;
    if (c.end == CurveEnd::free_edge) turn = turn_to(start, ends[i], 0);
    if (c.end == CurveEnd::annulus) {
      // Across the commissure that the arch's middle is nearest to.
      const double middle = annulus.frame().angle(r.points[r.points.size() / 2]);
      turn = turn_to(start, annulus.frame().angle(c.points.back()), 2 * turn_to(start, middle, 0));
    }
    // Height of the leaflet where an arch or half of one passes: from the free ends closest to its middle.
    double height = 0;
    if (c.end != CurveEnd::free_edge) {
      const Vec3 x = r.points[c.end == CurveEnd::joined ? r.points.size() - 1 : r.points.size() / 2];
      std::vector<std::pair<double, double>> near;
      for (const auto& other : set.curves)
        if (other.end == CurveEnd::free_edge) near.emplace_back((other.points.back() - x).norm(), annulus.distance(other.points.back()));
      std::sort(near.begin(), near.end());
      height = near.size() > 1 ? 0.5 * (near[0].second + near[1].second) : near.empty() ? 0 : near[0].second;
    }
    for (std::size_t k = 0; k < r.points.size(); ++k) {
      SurfaceDatum datum;
      datum.x = r.points[k];
      const double share = r.share[k];
      double angle = start + turn * share;
      datum.v = share;
      if (c.end != CurveEnd::free_edge) {
        datum.v = std::min(0.95, annulus.distance(datum.x) / std::max(height, 1e-6));
        if (c.end == CurveEnd::joined) angle = annulus.frame().angle(datum.x);
      }
      datum.is_v_fixed = k == 0 || (k + 1 == r.points.size() && c.end != CurveEnd::joined);
      if (k == 0) datum.v = 0;
      if (k + 1 == r.points.size() && c.end != CurveEnd::joined) datum.v = c.end == CurveEnd::annulus ? 0 : 1;
      datum.u = wrapped(angle) * radius;
      curve.data.push_back(datum);
    }
    result.push_back(curve);
  }
  return result;
}

}  // namespace mv
