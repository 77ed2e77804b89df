// SPDX-License-Identifier: BSD-3-Clause
#include "solver/time/stress_areas.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/core/unfolded.h"

namespace mv {
namespace {

constexpr double belly_half_width = 1.0 / 6.0, belly_from = 0.25, belly_to = 0.6;
constexpr double trigone_from_end = 0.05, trigone_to_end = 0.20, trigone_from = 0.08, trigone_to = 0.30;

/// Centre of an element on the flat pattern; points beyond the pattern's seam shifted to the others.
Vec2 pattern_centre(const LeafletMesh& mesh, const std::array<int, 10>& tet, double period) {
  const double first = mesh.unfolded[static_cast<std::size_t>(tet[0])].x();
  Vec2 centre = Vec2::Zero();
  for (std::size_t n = 0; n < 4; ++n) {
    Vec2 uv = mesh.unfolded[static_cast<std::size_t>(tet[n])];
    if (period > 0) uv.x() -= period * std::round((uv.x() - first) / period);
    centre += 0.25 * uv;
  }
  return centre;
}

Vec3 rest_centre(const LeafletMesh& mesh, const std::vector<int>& elements) {
  Vec3 centre = Vec3::Zero();
  for (int e : elements) centre += mesh.points[static_cast<std::size_t>(mesh.tets[static_cast<std::size_t>(e)][0])];
  return centre / static_cast<double>(std::max<std::size_t>(elements.size(), 1));
}

}  // namespace

StressAreas find_stress_areas(const LeafletMesh& rest, const std::vector<Vec3>& tips) {
  StressAreas areas;
  std::vector<int> elements;
  std::vector<Vec2> centres;
  const double period = unfolded_period(rest);
  for (std::size_t e = 0; e < rest.tets.size(); ++e) {
    if (rest.region[e] != anterior) continue;
    elements.push_back(static_cast<int>(e));
    centres.push_back(pattern_centre(rest, rest.tets[e], period));
  }
  if (elements.empty()) return areas;
  // The leaflet may lie across the pattern's seam: everything is counted from its tallest point, which is far from both its ends.
  const double tallest = std::max_element(centres.begin(), centres.end(), [](const Vec2& a, const Vec2& b) { return a.y() < b.y(); })->x();
  double low = 1e300, high = -1e300, height = 0;
  for (Vec2& c : centres) {
    if (period > 0) c.x() -= period * std::round((c.x() - tallest) / period);
    low = std::min(low, c.x());
    high = std::max(high, c.x());
    height = std::max(height, c.y());
  }
  const double width = high - low;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const double u = (centres[i].x() - low) / width, v = centres[i].y() / height;
    if (std::abs(u - 0.5) < belly_half_width && v > belly_from && v < belly_to) areas.belly.push_back(elements[i]);
    const double from_end = std::min(u, 1 - u);
    if (from_end > trigone_from_end && from_end < trigone_to_end && v > trigone_from && v < trigone_to) areas.trigone[u < 0.5 ? 0 : 1].push_back(elements[i]);
  }
  if (tips.size() == 2) {
    const Vec3 along = tips[0] - tips[1];
    if (rest_centre(rest, areas.trigone[0]).dot(along) < rest_centre(rest, areas.trigone[1]).dot(along)) std::swap(areas.trigone[0], areas.trigone[1]);
  }
  return areas;
}

double mean_over(const LeafletMesh& rest, const std::vector<int>& elements, std::span<const double> element_values) {
  double sum = 0, volume = 0;
  for (int e : elements) {
    const auto& tet = rest.tets[static_cast<std::size_t>(e)];
    auto at = [&](std::size_t n) { return rest.points[static_cast<std::size_t>(tet[n])]; };
    const double v = std::abs((at(1) - at(0)).cross(at(2) - at(0)).dot(at(3) - at(0))) / 6.0;
    sum += v * element_values[static_cast<std::size_t>(e)];
    volume += v;
  }
  return volume > 0 ? sum / volume : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace mv
