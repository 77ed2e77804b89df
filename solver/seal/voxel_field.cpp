// SPDX-License-Identifier: BSD-3-Clause
#include "solver/seal/voxel_field.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/core/errors.h"
#include "solver/seal/polygon.h"

namespace mv::seal {

namespace {

constexpr float unknown = -std::numeric_limits<float>::max();
constexpr float far_away = std::numeric_limits<float>::max();
constexpr double max_voxels = 60e6;

std::vector<Vec3> in_tube_frame(const std::vector<Vec3>& points, const Tube& tube) {
  std::vector<Vec3> out;
  out.reserve(points.size());
  for (const Vec3& p : points) out.push_back(tube.axes * (p - tube.origin));
  return out;
}

}  // namespace

VoxelField::VoxelField(const SealInput& input, const SealOptions& options, double exact_mm)
    : origin_(input.tube.origin), axes_(input.tube.axes), leaflets_(in_tube_frame(input.points, input.tube), input.triangles) {
  lay_grid(input, options);
  mark_wall(input, options);
  const auto size = static_cast<std::size_t>(grid_.size());
  distance_.assign(size, far_away);
  peak_.assign(size, unknown);
  sampled_.assign(size, unknown);
  if (leaflets_.empty()) return;
  std::vector<int> nearest(size, -1);
  measure_near(exact_mm, nearest);
  measure_far(nearest);
  find_inside();
}

void VoxelField::lay_grid(const SealInput& input, const SealOptions& options) {
  Vec2 lo = input.tube.cross_section[0], hi = lo;
  for (const Vec2& p : input.tube.cross_section) {
    lo = lo.cwiseMin(p);
    hi = hi.cwiseMax(p);
  }
  double z_low = std::numeric_limits<double>::max(), z_high = -z_low;
  for (const Vec3& p : input.annulus) {
    const double z = axes_.row(2).dot(p - origin_);
    z_low = std::min(z_low, z);
    z_high = std::max(z_high, z);
  }
  if (!leaflets_.empty()) {
    z_low = std::min(z_low, leaflets_.lower().z());
    z_high = std::max(z_high, leaflets_.upper().z());
  }
  z_low = std::max(z_low - options.margin_mm, std::min(input.tube.z_ventricle, z_high));
  z_high = std::min(z_high + options.margin_mm, std::max(input.tube.z_atrium, z_low));
  grid_.h = options.spacing_mm;
  const Vec3 extent(hi.x() - lo.x(), hi.y() - lo.y(), z_high - z_low);
  const double count = ((extent / grid_.h).array() + 1).prod();
  if (!(count < max_voxels))
    throw InputError("seal: " + std::to_string(count / 1e6) + " million voxels of " + std::to_string(grid_.h) +
                     " mm are too many; take a wider seal spacing");
  for (int k = 0; k < 3; ++k)
    grid_.n[static_cast<std::size_t>(k)] = std::max(k == 2 ? 3 : 1, static_cast<int>(std::ceil(extent[k] / grid_.h - 1e-9)));
  for (int k = 0; k < 3; ++k) {
    const double low = k == 0 ? lo.x() : k == 1 ? lo.y() : z_low;
    grid_.lower[k] = low + 0.5 * (extent[k] - grid_.h * grid_.n[static_cast<std::size_t>(k)]);
  }
}

// The wall is everything outside the cross-section. Around the annulus curve it also fills what lies outside the curve and a
// small ring inside it: leaflets are attached there, and a slit between their rim and the wall is no hole.
void VoxelField::mark_wall(const SealInput& input, const SealOptions& options) {
  wall_.assign(static_cast<std::size_t>(grid_.size()), 0);
  const std::vector<Vec3> ring = in_tube_frame(input.annulus, input.tube);
  std::vector<Vec2> flat;
  for (const Vec3& p : ring) flat.push_back(p.head<2>());
  const auto& section = section_ = input.tube.cross_section;
  by_wall_.assign(static_cast<std::size_t>(grid_.n[0]) * static_cast<std::size_t>(grid_.n[1]), 0);
  for (int j = 0; j < grid_.n[1]; ++j)
    for (int i = 0; i < grid_.n[0]; ++i) {
      const Vec2 p = grid_.centre(i, j, 0).head<2>();
      const bool outside = !polygon_contains(section, p);
      const double to_wall = nearest_on_loop(section, p).distance;
      by_wall_[static_cast<std::size_t>(grid_.at(i, j, 0))] = to_wall < half_diagonal * grid_.h;
      bool ring_column = false;
      double ring_z = 0;
      if (!outside && !leaflets_.empty()) {
        const NearestOnLoop at = nearest_on_loop(flat, p);
        ring_z = (1 - at.along) * ring[at.edge].z() + at.along * ring[(at.edge + 1) % ring.size()].z();
        ring_column = at.distance <= options.ring_growth_mm || !polygon_contains(flat, p) || to_wall <= options.ring_growth_mm;
      }
      for (int k = 0; k < grid_.n[2]; ++k) {
        const bool in_zone = ring_column && std::abs(grid_.centre(i, j, k).z() - ring_z) <= options.ring_zone_mm;
        wall_[static_cast<std::size_t>(grid_.at(i, j, k))] = outside || in_zone;
      }
    }
}

void VoxelField::measure_near(double exact_mm, std::vector<int>& nearest) {
  const double h = grid_.h;
  for (int t = 0; t < leaflets_.size(); ++t) {
    const auto& c = leaflets_.triangle(t);
    Vec3 lo = leaflets_.points()[static_cast<std::size_t>(c[0])], hi = lo;
    for (int i : c) {
      lo = lo.cwiseMin(leaflets_.points()[static_cast<std::size_t>(i)]);
      hi = hi.cwiseMax(leaflets_.points()[static_cast<std::size_t>(i)]);
    }
    std::array<int, 3> from, to;
    for (int k = 0; k < 3; ++k) {
      const auto s = static_cast<std::size_t>(k);
      const double last = grid_.n[s];
      from[s] = static_cast<int>(std::clamp(std::ceil((lo[k] - exact_mm - grid_.lower[k]) / h - 0.5), 0.0, last));
      to[s] = static_cast<int>(std::clamp(std::floor((hi[k] + exact_mm - grid_.lower[k]) / h - 0.5), -1.0, last - 1));
    }
    for (int k = from[2]; k <= to[2]; ++k)
      for (int j = from[1]; j <= to[1]; ++j)
        for (int i = from[0]; i <= to[0]; ++i) {
          const Vec3 p = grid_.centre(i, j, k);
          const auto v = static_cast<std::size_t>(grid_.at(i, j, k));
          const double best = std::min<double>(distance_[v], exact_mm);
          if (leaflets_.is_farther(t, p, best)) continue;
          const double d2 = leaflets_.squared_distance(t, p);
          if (d2 > best * best) continue;
          distance_[v] = static_cast<float>(std::sqrt(d2));
          nearest[v] = t;
        }
  }
}

// Voxels beyond the exact band take over their neighbours' nearest triangles in the order of distance (buckets of half a voxel).
void VoxelField::measure_far(std::vector<int>& nearest) {
  const Voxel n = grid_.size();
  const double bucket = 0.5 * grid_.h;
  std::vector<std::vector<Voxel>> queue;
  const auto push = [&](Voxel v) {
    const auto b = static_cast<std::size_t>(distance_[static_cast<std::size_t>(v)] / bucket);
    if (b >= queue.size()) queue.resize(b + 1);
    queue[b].push_back(v);
  };
  std::vector<std::uint8_t> done(static_cast<std::size_t>(n), 0);
  bool any = false;
  for (Voxel v = 0; v < n; ++v)
    if (nearest[static_cast<std::size_t>(v)] >= 0) {
      any = true;
      done[static_cast<std::size_t>(v)] = 1;
      bool rim = false;
      grid_.neighbours(v, [&](Voxel w, int) { rim = rim || nearest[static_cast<std::size_t>(w)] < 0; });
      if (rim) push(v);
    }
  if (!any) {  // every leaflet is further from every voxel than the exact band: seed one layer
    for (Voxel v = 0; v < grid_.n[0] * grid_.n[1]; ++v) {
      const int t = leaflets_.nearest(grid_.centre(v));
      nearest[static_cast<std::size_t>(v)] = t;
      distance_[static_cast<std::size_t>(v)] = static_cast<float>(std::sqrt(leaflets_.squared_distance(t, grid_.centre(v))));
      done[static_cast<std::size_t>(v)] = 1;
      push(v);
    }
  }
  std::vector<std::uint8_t> spread(static_cast<std::size_t>(n), 0);
  for (std::size_t b = 0; b < queue.size(); ++b)
    for (std::size_t q = 0; q < queue[b].size(); ++q) {
      const Voxel v = queue[b][q];
      if (spread[static_cast<std::size_t>(v)]) continue;
      spread[static_cast<std::size_t>(v)] = 1;
      const int t = nearest[static_cast<std::size_t>(v)];
      grid_.neighbours(v, [&](Voxel w, int) {
        const auto s = static_cast<std::size_t>(w);
        if (done[s] || spread[s] || nearest[s] == t) return;
        const auto d = static_cast<float>(std::sqrt(leaflets_.squared_distance(t, grid_.centre(w))));
        if (d >= distance_[s]) return;
        distance_[s] = d;
        nearest[s] = t;
        const auto slot = std::max(b, static_cast<std::size_t>(d / bucket));
        if (slot >= queue.size()) queue.resize(slot + 1);
        queue[slot].push_back(w);
      });
    }
}

// Crossings of the vertical lines through the voxel centres, summed from the top down.
void VoxelField::find_inside() {
  std::vector<std::int8_t> change(static_cast<std::size_t>(grid_.size()), 0);
  for (int t = 0; t < leaflets_.size(); ++t) {
    const auto& c = leaflets_.triangle(t);
    Vec3 lo = leaflets_.points()[static_cast<std::size_t>(c[0])], hi = lo;
    for (int i : c) {
      lo = lo.cwiseMin(leaflets_.points()[static_cast<std::size_t>(i)]);
      hi = hi.cwiseMax(leaflets_.points()[static_cast<std::size_t>(i)]);
    }
    std::array<int, 2> from, to;
    for (int k = 0; k < 2; ++k) {
      const auto s = static_cast<std::size_t>(k);
      const double last = grid_.n[s];
      from[s] = static_cast<int>(std::clamp(std::floor((lo[k] - grid_.lower[k]) / grid_.h - 0.5), 0.0, last));
      to[s] = static_cast<int>(std::clamp(std::ceil((hi[k] - grid_.lower[k]) / grid_.h - 0.5), -1.0, last - 1));
    }
    for (int j = from[1]; j <= to[1]; ++j)
      for (int i = from[0]; i <= to[0]; ++i) {
        const Vec3 line = grid_.centre(i, j, 0);
        leaflets_.crossing(t, line.x(), line.y(), [&](double z, int sign) {
          const double below = std::ceil((z - grid_.lower.z()) / grid_.h - 0.5);  // centres lower than z
          if (below < 1) return;
          const int top = std::min(static_cast<int>(std::min(below, 1e9)), grid_.n[2]) - 1;
          change[static_cast<std::size_t>(grid_.at(i, j, top))] += static_cast<std::int8_t>(sign);
        });
      }
  }
  const Voxel layer = grid_.n[0] * grid_.n[1];
  for (Voxel column = 0; column < layer; ++column) {
    int winding = 0;
    for (int k = grid_.n[2] - 1; k >= 0; --k) {
      const auto v = static_cast<std::size_t>(column + k * layer);
      winding += change[v];
      if (winding > 0) distance_[v] = -distance_[v];
    }
  }
}

// ---- single voxels ----

bool VoxelField::is_wall_at(const Vec3& p) const {
  std::array<int, 3> c;
  for (int k = 0; k < 3; ++k) {
    const auto s = static_cast<std::size_t>(k);
    c[s] = static_cast<int>(std::floor((p[k] - grid_.lower[k]) / grid_.h));
    if (c[s] < 0 || c[s] >= grid_.n[s]) return true;
  }
  return is_wall(grid_.at(c[0], c[1], c[2]));
}

bool VoxelField::is_in_section(const Vec3& p) const { return polygon_contains(section_, p.head<2>()); }

// Steps along the 26 directions of a cube, halved when none helps. A step no longer than the clearance cannot end in the solid.
void VoxelField::climb(const NearTriangles& near, const Vec3& centre, double reach, double cap, bool by_wall, Best& best) const {
  for (double step = reach / 3; step > reach / 30; step *= 0.5) {
    for (bool moved = true; moved;) {
      moved = false;
      const Vec3 from = best.place;
      for (int d = 0; d < 27; ++d) {
        if (d == 13) continue;
        const Vec3 direction(d % 3 - 1, d / 3 % 3 - 1, d / 9 - 1);
        Vec3 p = from + step / direction.norm() * direction;
        p = p.cwiseMax((centre.array() - reach).matrix()).cwiseMin((centre.array() + reach).matrix());
        const double wanted = best.value + 1e-3 * step, value = leaflets_.distance_to(near, p, cap, wanted);
        if (value <= wanted) continue;
        if ((step > best.value && leaflets_.is_inside(p)) || (by_wall && !is_in_section(p))) continue;
        best = {value, p};
        moved = true;
      }
    }
  }
}

// Leaves out samples that are no further than `best` from the surface, when that is given.
template <class Visit>
void VoxelField::samples(Voxel v, NearTriangles& near, Visit&& visit, const double* best) const {
  const double h = grid_.h, d0 = distance(v), reach = half_diagonal * h;
  const Vec3 centre = grid_.centre(v);
  const double cap = std::abs(d0) + reach;
  leaflets_.within(centre, cap + reach, near);
  for (int s = 0; s < 27; ++s) {
    const Vec3 offset = h / 3 * Vec3(s % 3 - 1, s / 3 % 3 - 1, s / 9 - 1);
    const double floor = best && *best >= 0 ? *best : -1;
    double value = s == 13 ? d0 : leaflets_.distance_to(near, centre + offset, cap, floor);
    if (s != 13 && value <= floor) continue;
    if (s != 13 && (std::abs(d0) > offset.norm() ? d0 < 0 : leaflets_.is_inside(centre + offset))) value = -value;
    if (!visit(value, centre + offset)) return;
  }
}

float VoxelField::peak_bound(Voxel v) const {
  if (is_known_peak(v)) return peak_[static_cast<std::size_t>(v)];
  const float known = sampled_[static_cast<std::size_t>(v)];
  return known > unknown ? known + static_cast<float>(sample_reach * grid_.h)
                         : distance(v) + static_cast<float>(half_diagonal * grid_.h);
}

float VoxelField::sampled(Voxel v) const {
  float& known = sampled_[static_cast<std::size_t>(v)];
  if (known > unknown || leaflets_.empty()) return leaflets_.empty() ? far_away : known;
  double best = -half_diagonal * grid_.h;
  const bool by_wall = is_by_wall(v);
  samples(v, scratch_, [&](double value, const Vec3& p) {
    if (value > best && !(by_wall && !is_in_section(p))) best = value;
    return true;
  }, &best);
  return known = static_cast<float>(best);
}

float VoxelField::cheap_peak(Voxel v) const { return is_known_peak(v) ? peak_[static_cast<std::size_t>(v)] : distance(v); }

float VoxelField::peak(Voxel v) const {
  float& known = peak_[static_cast<std::size_t>(v)];
  if (is_known_peak(v)) return known;
  if (leaflets_.empty() || peak_bound(v) <= 0) return known = leaflets_.empty() ? far_away : 0.0f;
  const Vec3 centre = grid_.centre(v);
  const double cap = std::abs(distance(v)) + half_diagonal * grid_.h;
  Best best;
  const bool by_wall = is_by_wall(v);
  samples(v, scratch_, [&](double value, const Vec3& p) {
    if (value > best.value && !(by_wall && !is_in_section(p))) best = {value, p};
    return true;
  }, &best.value);
  if (best.value <= 0) {  // a gap finer than the samples: look right at the surfaces inside the voxel
    const double reach = 0.5 * grid_.h, off = 0.02 * grid_.h;
    for (const auto& [distance, t] : scratch_.items) {
      if (distance > half_diagonal * grid_.h) break;
      const Vec3 p = leaflets_.closest_point(t, centre) + off * leaflets_.normal(t);
      if (((p - centre).cwiseAbs().array() > reach).any() || (by_wall && !is_in_section(p))) continue;
      const double value = leaflets_.distance_to(scratch_, p, cap, best.value);
      if (value > best.value && !leaflets_.is_inside(p)) best = {value, p};
    }
  }
  if (best.value > 0) climb(scratch_, centre, 0.5 * grid_.h, cap, by_wall, best);
  known = static_cast<float>(best.value);
  peak_places_[v] = best.place;
  return known;
}

bool VoxelField::peak_reaches(Voxel v, double level) const {
  if (cheap_peak(v) >= level) return true;
  if (peak_bound(v) < level) return false;
  if (sampled(v) >= level) return true;
  return peak_bound(v) >= level && peak(v) >= level;
}

Vec3 VoxelField::peak_place(Voxel v) const {
  const auto found = peak_places_.find(v);
  return found != peak_places_.end() && peak_[static_cast<std::size_t>(v)] > 0 ? found->second : grid_.centre(v);
}

double VoxelField::open_fraction(Voxel v) const {
  const double reach = half_diagonal * grid_.h, d0 = distance(v);
  if (d0 >= reach) return 1;
  if (d0 <= -reach) return 0;
  double sum = 0;
  samples(v, scratch_, [&](double value, const Vec3&) {
    sum += std::clamp(0.5 + value / (grid_.h / 3), 0.0, 1.0);
    return true;
  });
  return sum / 27;
}

double VoxelField::open_face(Voxel v, int axis) const {
  const double h = grid_.h;
  Vec3 e = Vec3::Zero();
  e[axis] = 1;
  const Vec3 s = e.cross(axis == 0 ? Vec3::UnitY() : Vec3::UnitX()).cwiseAbs(), t = e.cross(s).cwiseAbs();
  const Vec3 middle = grid_.centre(v) + 0.5 * h * e;
  if (distance(v) > (0.5 + std::sqrt(0.5)) * h) return 1;
  leaflets_.within(middle, 2 * h, scratch_);
  double sum = 0;
  for (int a = -1; a <= 1; ++a)
    for (int b = -1; b <= 1; ++b) {
      const Vec3 p = middle + h / 3 * (a * s + b * t);
      const double value = leaflets_.distance_to(scratch_, p, h);
      sum += std::clamp(0.5 + (leaflets_.is_inside(p) ? -value : value) / (h / 3), 0.0, 1.0);
    }
  return sum / 9;
}

double VoxelField::clearance(const Vec3& p, double cap) const {
  leaflets_.within(p, cap, scratch_);
  const double d = leaflets_.distance_to(scratch_, p, cap);
  return leaflets_.is_inside(p) ? -d : d;
}

Vec3 VoxelField::climb(const Vec3& p, const Vec3& centre, double reach, double cap) const {
  Best best{clearance(p, cap), p};
  if (best.value <= 0) return p;
  leaflets_.within(centre, cap + 2 * reach, scratch_);
  climb(scratch_, centre, reach, cap, true, best);
  return best.place;
}

}  // namespace mv::seal
