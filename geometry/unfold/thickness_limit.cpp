// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/unfold/thickness_limit.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <queue>

#include "geometry/core/errors.h"
#include "geometry/surface/self_intersection.h"
#include "geometry/volume/gates.h"
#include "geometry/volume/leaflet_tets.h"

namespace mv {
namespace {

constexpr double slope_limit = 0.5;      // change of thickness per mm
constexpr double thinning = 0.8;         // per round, where sheets meet
constexpr int most_rounds = 40;
constexpr double slender_thinning = 0.9;  // per round, where tetrahedra are slender
constexpr int rounds_without_gain = 6;
constexpr double most_left = 0.25;     // of the slender tetrahedra; thinning that leaves more is undone: it is not the thickness that makes them slender
constexpr double angle_reserve = 0.2;  // degrees above the gate's limit

std::size_t at(long i) { return static_cast<std::size_t>(i); }

std::vector<std::vector<std::pair<int, double>>> neighbours(const MidSurface& s) {
  std::vector<std::vector<std::pair<int, double>>> near(s.points.size());
  for (const auto& t : s.triangles)
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t l = 0; l < 3; ++l)
        if (k != l) near[at(t[k])].emplace_back(t[l], (s.points[at(t[k])] - s.points[at(t[l])]).norm());
  return near;
}

/// Lowers values until no two neighbours differ by more than the slope.
void level(std::vector<double>& value, const std::vector<std::vector<std::pair<int, double>>>& near) {
  using Item = std::pair<double, int>;
  std::priority_queue<Item, std::vector<Item>, std::greater<>> queue;
  for (std::size_t i = 0; i < value.size(); ++i) queue.push({value[i], static_cast<int>(i)});
  while (!queue.empty()) {
    const auto [v, i] = queue.top();
    queue.pop();
    if (v > value[at(i)]) continue;
    for (const auto& [j, d] : near[at(i)])
      if (value[at(j)] > v + slope_limit * d) {
        value[at(j)] = v + slope_limit * d;
        queue.push({value[at(j)], j});
      }
  }
}

std::vector<double> curvatures(const MidSurface& s, const std::vector<std::vector<std::pair<int, double>>>& near) {
  std::vector<double> kappa(s.points.size(), 0);
  for (std::size_t i = 0; i < near.size(); ++i)
    for (const auto& [j, d] : near[i]) {
      const Vec3 dx = s.points[at(j)] - s.points[i], dn = s.normals[at(j)] - s.normals[i];
      kappa[i] = std::max(kappa[i], std::abs(dn.dot(dx)) / dx.squaredNorm());
    }
  return kappa;
}

/// Mid-surface points below the thick shell's intersecting triangles.
std::vector<int> meeting_points(const MidSurface& s) {
  const LeafletMesh shell = thicken(s, {1.0, 1, 1});
  const BoundarySurface boundary = extract_boundary(shell);
  std::vector<int> points;
  const int n = static_cast<int>(s.points.size());
  for (const auto& [a, b] : self_intersections(shell.points, boundary.triangles))
    for (int t : {a, b})
      for (int v : boundary.triangles[at(t)]) points.push_back(v % n);
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

/// Mid-surface points of the tetrahedra with an angle below `limit`, and the smallest angle of all.
struct Slender {
  std::vector<int> points;
  long count = 0;
  double smallest = 180;
};

Slender slender_points(const MidSurface& s, int layers, double limit) {
  const LeafletMesh mesh = thicken(s, {1.0, layers, 1});
  const int n = static_cast<int>(s.points.size());
  Slender found;
  for (const auto& t : mesh.tets) {
    const auto angles = dihedral_angles(mesh.points[at(t[0])], mesh.points[at(t[1])], mesh.points[at(t[2])], mesh.points[at(t[3])]);
    const double angle = *std::min_element(angles.begin(), angles.end());
    found.smallest = std::min(found.smallest, angle);
    if (angle >= limit) continue;
    ++found.count;
    for (std::size_t k = 0; k < 4; ++k) found.points.push_back(t[k] % n);
  }
  std::sort(found.points.begin(), found.points.end());
  found.points.erase(std::unique(found.points.begin(), found.points.end()), found.points.end());
  return found;
}

/// Lowers the thickness at slender tetrahedra while that helps; keeps the best, or nothing where it helps too few.
void thin_slender(MidSurface& s, double least, int layers, double limit, const std::vector<std::vector<std::pair<int, double>>>& near) {
  std::vector<double> best;
  const std::vector<double> before = s.thickness;
  long first = 0, fewest = 0;
  int without_gain = 0;
  for (int round = 0; round < most_rounds; ++round) {
    const Slender slender = slender_points(s, layers, limit);
    if (round == 0 || slender.count < fewest) {
      best = s.thickness;
      fewest = slender.count;
      if (round == 0) first = fewest;
      without_gain = 0;
    } else if (++without_gain == rounds_without_gain) {
      break;
    }
    if (slender.count == 0) break;
    bool is_thinned = false;
    for (int i : slender.points)
      if (s.thickness[at(i)] > least) {
        s.thickness[at(i)] = std::max(least, slender_thinning * s.thickness[at(i)]);
        is_thinned = true;
      }
    if (!is_thinned) break;
    level(s.thickness, near);
  }
  s.thickness = static_cast<double>(fewest) <= most_left * static_cast<double>(first) ? best : before;
}

std::string changed(const MidSurface& s, const std::vector<double>& before, const char* why) {
  double area = 0, whole = 0, smallest = 1e300;
  for (const auto& t : s.triangles) {
    const double a = 0.5 * (s.points[at(t[1])] - s.points[at(t[0])]).cross(s.points[at(t[2])] - s.points[at(t[0])]).norm();
    whole += a;
    bool lower = false;
    for (int v : t)
      if (s.thickness[at(v)] < before[at(v)] - 1e-9) {
        lower = true;
        smallest = std::min(smallest, s.thickness[at(v)]);
      }
    if (lower) area += a;
  }
  return area > 0 ? fmt::format("thickness lowered on {:.1f} % of the leaflets, to {:.2f} mm at least, {}", 100 * area / whole, smallest, why) : "";
}

}  // namespace

std::vector<std::string> limit_thickness(MidSurface& s, double least, int layers, double dihedral_min) {
  std::vector<std::string> notes;
  const auto near = neighbours(s);
  std::vector<double> before = s.thickness;
  const std::vector<double> kappa = curvatures(s, near);
  for (std::size_t i = 0; i < kappa.size(); ++i)
    if (kappa[i] > 0) s.thickness[i] = std::min(s.thickness[i], std::max(2 * fold_share / kappa[i], std::min(least, s.thickness[i])));
  level(s.thickness, near);
  if (const std::string note = changed(s, before, "where the surface bends more tightly"); !note.empty()) notes.push_back(note);
  before = s.thickness;
  thin_slender(s, least, layers, dihedral_min + angle_reserve, near);
  if (const std::string note = changed(s, before, "where the tetrahedra would be slender"); !note.empty()) notes.push_back(note);
  before = s.thickness;
  for (int round = 0;; ++round) {
    const std::vector<int> meeting = meeting_points(s);
    if (meeting.empty()) break;
    bool thinned = false;
    for (int i : meeting)
      if (s.thickness[at(i)] > least) {
        s.thickness[at(i)] = std::max(least, thinning * s.thickness[at(i)]);
        thinned = true;
      }
    if (!thinned || round == most_rounds) {
      const Vec3& x = s.points[at(meeting.front())];
      throw GateError(fmt::format("leaflets: the sheets meet or cross near ({:.1f}, {:.1f}, {:.1f}) mm even at {:.2f} mm thickness ({} points); open the "
                                  "valve in the source, or lower patient.thickness_min or patient.smoothing",
                                  x.x(), x.y(), x.z(), least, meeting.size()));
    }
    level(s.thickness, near);
  }
  if (const std::string note = changed(s, before, "where the sheets would meet"); !note.empty()) notes.push_back(note);
  return notes;
}

}  // namespace mv
