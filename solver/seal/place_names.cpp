// SPDX-License-Identifier: BSD-3-Clause
#include "solver/seal/place_names.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/core/leaflet_names.h"

namespace mv::seal {

namespace {

constexpr double commissure_share = 0.1;
/// Both leaflets are named when the farther one is at most this many times as far as the nearer one (plus 1 mm).
constexpr double both_ratio = 1.5;

}  // namespace

PlaceNames::PlaceNames(const SealInput& input) : input_(input) {
  if (input.region.empty() || input.unfolded.empty()) return;
  for (const int region : input.region) has_other_leaflets_ = has_other_leaflets_ || region > anterior;
  for (int r : {static_cast<int>(posterior), static_cast<int>(anterior)}) {
    Leaflet& leaflet = leaflet_[static_cast<std::size_t>(r)];
    leaflet.u_min = 1e300;
    leaflet.u_max = -1e300;
    for (const auto& t : input.triangles)
      for (int i : t) {
        const auto s = static_cast<std::size_t>(i);
        if (input.region[s] != r) continue;
        leaflet.present = true;
        leaflet.u_min = std::min(leaflet.u_min, input.unfolded[s].x());
        leaflet.u_max = std::max(leaflet.u_max, input.unfolded[s].x());
      }
    if (!leaflet.present || input.anterolateral.norm() == 0) continue;
    oriented_ = true;
    // The end of the leaflet whose points lie further towards the anterolateral side.
    Vec3 first = Vec3::Zero(), last = Vec3::Zero();
    int firsts = 0, lasts = 0;
    for (std::size_t s = 0; s < input.points.size(); ++s) {
      if (input.region[s] != r) continue;
      const double share = (input.unfolded[s].x() - leaflet.u_min) / std::max(1e-12, leaflet.u_max - leaflet.u_min);
      if (share < 1.0 / 3) first += input.points[s], ++firsts;
      if (share > 2.0 / 3) last += input.points[s], ++lasts;
    }
    if (firsts && lasts) leaflet.reversed = (last / lasts - first / firsts).dot(input.anterolateral) > 0;
  }
}

PlaceNames::Near PlaceNames::nearest(const Vec3& world, int region) const {
  Near best;
  for (const auto& t : input_.triangles)
    for (int i : t) {
      const auto s = static_cast<std::size_t>(i);
      if (input_.region[s] != region) continue;
      const double d = (input_.points[s] - world).norm();
      if (d < best.distance) best = {d, input_.unfolded[s].x()};
    }
  return best;
}

double PlaceNames::position(const Leaflet& leaflet, double u) const {
  const double share = (u - leaflet.u_min) / std::max(1e-12, leaflet.u_max - leaflet.u_min);
  return leaflet.reversed ? 1 - share : share;
}

PlaceName PlaceNames::by_leaflets(const Vec3& world) const {
  PlaceName out;
  double first = 1e300, second = 1e300;
  std::string name, other;
  for (const NamedRegion& leaflet : leaflet_names) {
    const Near near = nearest(world, leaflet.region);
    if (near.distance < first) {
      second = std::exchange(first, near.distance);
      other = std::exchange(name, leaflet.name);
      out.region = leaflet.region;
      out.u = near.u;
    } else if (near.distance < second) {
      second = near.distance;
      other = leaflet.name;
    }
  }
  if (name.empty()) return out;
  const bool is_between = second <= both_ratio * first + 1.0;
  if (is_between && other < name) std::swap(name, other);
  out.location = is_between ? "between " + name + " and " + other + " leaflet" : name + " leaflet";
  return out;
}

PlaceName PlaceNames::at(const Vec3& world) const {
  if (has_other_leaflets_) return by_leaflets(world);
  PlaceName out;
  std::array<Near, 3> near;
  for (int r : {static_cast<int>(posterior), static_cast<int>(anterior)})
    if (leaflet_[static_cast<std::size_t>(r)].present) near[static_cast<std::size_t>(r)] = nearest(world, r);
  const bool front = near[anterior].distance < near[posterior].distance;
  const int region = front ? anterior : posterior, other = front ? posterior : anterior;
  const auto r = static_cast<std::size_t>(region), o = static_cast<std::size_t>(other);
  if (!leaflet_[r].present) return out;
  out.region = region;
  out.u = near[r].u;
  const double share = position(leaflet_[r], near[r].u);
  if (share < commissure_share || share > 1 - commissure_share) {
    const bool first = share < commissure_share;
    out.location = oriented_ ? (first ? "anterolateral commissure" : "posteromedial commissure")
                             : (first ? "commissure at the lower end of u" : "commissure at the upper end of u");
    return out;
  }
  const auto segment = [&](int leaflet) {
    const auto s = static_cast<std::size_t>(leaflet);
    const int third = std::clamp(static_cast<int>(3 * position(leaflet_[s], near[s].u)), 0, 2);
    return std::string(1, leaflet == anterior ? 'A' : 'P') + static_cast<char>('1' + third);
  };
  const bool between = leaflet_[o].present && near[o].distance <= both_ratio * near[r].distance + 1.0;
  out.location = between ? "between " + segment(anterior) + " and " + segment(posterior) : segment(region);
  return out;
}

}  // namespace mv::seal
