// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/chordae/density_places.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "geometry/core/side_faces.h"
#include "geometry/core/unfolded.h"

namespace mv {
namespace {

constexpr double jitter = 0.25;   // of the spacing, either way
constexpr int candidates = 24;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// Whole numbers that add up to `total`, in proportion to `shares` (largest remainders).
std::vector<int> apportion(const std::vector<double>& shares, int total) {
  const double sum = std::accumulate(shares.begin(), shares.end(), 0.0);
  std::vector<int> out;
  std::vector<std::pair<double, int>> rest;
  int given = 0;
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const double exact = total * shares[i] / sum;
    out.push_back(static_cast<int>(std::floor(exact)));
    given += out.back();
    rest.emplace_back(out.back() - exact, static_cast<int>(i));
  }
  std::sort(rest.begin(), rest.end());
  for (int k = 0; given < total; ++k, ++given) ++out[at(rest[at(k)].second)];
  return out;
}

}  // namespace

std::vector<BorderSite> border_sites(const LeafletChart& chart, const DensityOptions& options, Dice& dice, DensityReport& report) {
  const auto& junctions = chart.junctions();
  const int arcs = static_cast<int>(junctions.size());
  std::vector<double> begin, length;
  for (int k = 0; k < arcs; ++k) {
    begin.push_back(chart.border()[at(junctions[at(k)].border_index)].arc);
    length.push_back((k + 1 < arcs ? chart.border()[at(junctions[at(k + 1)].border_index)].arc : chart.border_length()) - begin.back());
  }
  const int total = std::max(arcs, static_cast<int>(std::lround(options.border_density * chart.border_length())));
  std::vector<int> inner = apportion(length, total - arcs);
  const double least = options.min_distance.value_or(options.border_density > 0 ? 0.5 / options.border_density : 0.0);
  std::vector<BorderSite> sites;
  int without_room = 0;
  for (int k = 0; k < arcs; ++k) {
    const int room = least > 0 ? static_cast<int>(std::floor(length[at(k)] / least)) - 1 : inner[at(k)];
    if (room < inner[at(k)]) {
      without_room += inner[at(k)] - std::max(room, 0);
      inner[at(k)] = std::max(room, 0);
    }
    sites.push_back({begin[at(k)], true});
    const double spacing = length[at(k)] / (inner[at(k)] + 1);
    // Two neighbours may move towards each other by this share each and still keep their distance.
    const double share = std::clamp(0.5 * (spacing - least) / spacing, 0.0, jitter);
    for (int i = 1; i <= inner[at(k)]; ++i) sites.push_back({begin[at(k)] + spacing * (i + share * (2 * dice.unit() - 1)), false});
  }
  if (without_room > 0)
    report.notes.push_back(fmt::format("chordae.min_distance {:.2g} mm leaves no room for {} border ends of {}", least, without_room, total));
  return sites;
}

InnerArea::InnerArea(const LeafletMesh& mesh, const LeafletChart& chart, double from, double to) {
  double sum = 0;
  for (const SideTriangle& triangle : side_triangles(mesh, atrial)) {
    const std::array<int, 3>& t = triangle.nodes;
    std::array<Vec2, 3> uv;
    Vec2 middle = Vec2::Zero();
    for (std::size_t i = 0; i < 3; ++i) {
      uv[i] = mesh.unfolded[at(t[i])];
      uv[i].x() = nearest_image(uv[i].x(), uv[0].x(), chart.period());
      middle += uv[i] / 3;
    }
    const double share = middle.y() / std::max(chart.height(middle.x()), 1e-9);
    if (share < from || share > to) continue;
    const Vec3 &a = mesh.points[at(t[0])], &b = mesh.points[at(t[1])], &c = mesh.points[at(t[2])];
    sum += 0.5 * (b - a).cross(c - a).norm();
    triangles_.push_back(uv);
    cumulative_.push_back(sum);
  }
}

Vec2 InnerArea::random_uv(Dice& dice) const {
  const double pick = dice.unit() * area();
  const auto k = std::min(static_cast<std::size_t>(std::upper_bound(cumulative_.begin(), cumulative_.end(), pick) - cumulative_.begin()), triangles_.size() - 1);
  double a = dice.unit(), b = dice.unit();
  if (a + b > 1) {
    a = 1 - a;
    b = 1 - b;
  }
  return triangles_[k][0] + a * (triangles_[k][1] - triangles_[k][0]) + b * (triangles_[k][2] - triangles_[k][0]);
}

std::optional<Vec2> spread_place(const InnerArea& area, const LeafletChart& chart, const std::vector<Vec3>& taken, double distance, Dice& dice) {
  std::optional<Vec2> best;
  double farthest = distance;
  for (int k = 0; k < candidates; ++k) {
    const Vec2 uv = area.random_uv(dice);
    const Vec3 x = chart.at(uv).position;
    double nearest = std::numeric_limits<double>::max();
    for (const Vec3& p : taken) nearest = std::min(nearest, (p - x).norm());
    if (nearest >= farthest) {
      farthest = nearest;
      best = uv;
    }
  }
  return best;
}

}  // namespace mv
