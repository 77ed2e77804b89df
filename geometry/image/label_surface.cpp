// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/image/label_surface.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "geometry/core/errors.h"
#include "geometry/image/distance_map.h"
#include "geometry/image/flying_edges.h"
#include "geometry/image/mask_field.h"
#include "geometry/image/mesh_smoothing.h"

namespace mv {
namespace {

constexpr int offset_steps = 4;
constexpr double clearance_of_step = 0.05;  // nodes keep this distance from the surface, in units of a grid step
constexpr double crumb_share = 0.01;       // closed parts below this share of the volume are dropped

bool is_part(std::int32_t value, Part part) { return value == static_cast<std::int32_t>(part); }
bool is_leaflet(std::int32_t value) { return is_part(value, Part::posterior) || is_part(value, Part::anterior); }

/// Box of the leaflets with a margin of background.
LabelImage leaflet_box(const LabelledParts& parts) {
  std::array<int, 3> low = parts.low, high = parts.high;
  for (std::size_t a = 0; a < 3; ++a) low[a] -= Mask::margin_voxels, high[a] += Mask::margin_voxels;
  return cropped(parts.image, low, high);
}

struct Drawn {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;
  double volume = 0, area = 0;
};

void measure(Drawn& drawn) {
  drawn.volume = drawn.area = 0;
  if (drawn.points.empty()) return;
  const Vec3 base = drawn.points.front();
  for (const auto& t : drawn.triangles) {
    const Vec3 a = drawn.points[static_cast<std::size_t>(t[0])] - base, b = drawn.points[static_cast<std::size_t>(t[1])] - base,
               c = drawn.points[static_cast<std::size_t>(t[2])] - base;
    drawn.volume += a.dot(b.cross(c)) / 6;
    drawn.area += (b - a).cross(c - a).norm() / 2;
  }
}

/// The stepped surface, in voxels.
Drawn draw(const LabelImage& box, const MaskField& field) {
  double step = 1e300;
  for (std::size_t a = 0; a < 3; ++a) step = std::min(step, box.spacing()[static_cast<Eigen::Index>(a)] / field.refined[a]);
  GridSurface grid = flying_edges(field.size, field.phi, 0, clearance_of_step * step);
  const Vec3 voxel_of_node(1.0 / field.refined[0], 1.0 / field.refined[1], 1.0 / field.refined[2]);
  Drawn drawn;
  for (const Vec3& p : grid.points) drawn.points.push_back(p.cwiseProduct(voxel_of_node));
  drawn.triangles = std::move(grid.triangles);
  return drawn;
}

void to_world(const LabelImage& box, Drawn& drawn) {
  for (Vec3& p : drawn.points) p = box.world(p);
  measure(drawn);
  if (drawn.volume >= 0) return;
  for (auto& t : drawn.triangles) std::swap(t[1], t[2]);
  drawn.volume = -drawn.volume;
}

/// Moves the points along their normals until the volume is `wanted`: dV = area * offset. Returns the offset.
double keep_volume(Drawn& drawn, double wanted) {
  double total = 0;
  for (int i = 0; i < offset_steps && drawn.area > 0; ++i) {
    const double offset = (wanted - drawn.volume) / drawn.area;
    std::vector<Vec3> normals(drawn.points.size(), Vec3::Zero());
    for (const auto& t : drawn.triangles) {
      const Vec3 n = (drawn.points[static_cast<std::size_t>(t[1])] - drawn.points[static_cast<std::size_t>(t[0])])
                         .cross(drawn.points[static_cast<std::size_t>(t[2])] - drawn.points[static_cast<std::size_t>(t[0])]);
      for (int p : t) normals[static_cast<std::size_t>(p)] += n;
    }
    for (std::size_t p = 0; p < drawn.points.size(); ++p) drawn.points[p] += offset * normals[p].normalized();
    measure(drawn);
    total += offset;
  }
  return total;
}

int find_root(std::vector<int>& parent, int i) {
  while (parent[static_cast<std::size_t>(i)] != i) {
    parent[static_cast<std::size_t>(i)] = parent[static_cast<std::size_t>(parent[static_cast<std::size_t>(i)])];
    i = parent[static_cast<std::size_t>(i)];
  }
  return i;
}

/// Splits into closed parts, drops crumbs and cavities, counts handles.
void keep_large_parts(Drawn& drawn, LabelSurface& surface) {
  std::vector<int> parent(drawn.points.size());
  std::iota(parent.begin(), parent.end(), 0);
  for (const auto& t : drawn.triangles)
    for (int i : {1, 2}) parent[static_cast<std::size_t>(find_root(parent, t[static_cast<std::size_t>(i)]))] = find_root(parent, t[0]);
  std::vector<double> volume(parent.size(), 0);
  std::vector<long> faces(parent.size(), 0), points(parent.size(), 0);
  for (const auto& t : drawn.triangles) {
    const auto root = static_cast<std::size_t>(find_root(parent, t[0]));
    const Vec3 base = drawn.points[root];
    const Vec3 a = drawn.points[static_cast<std::size_t>(t[0])] - base, b = drawn.points[static_cast<std::size_t>(t[1])] - base,
               c = drawn.points[static_cast<std::size_t>(t[2])] - base;
    volume[root] += a.dot(b.cross(c)) / 6;
    ++faces[root];
  }
  for (std::size_t p = 0; p < parent.size(); ++p) ++points[static_cast<std::size_t>(find_root(parent, static_cast<int>(p)))];
  std::vector<char> is_kept(parent.size(), 0);
  int dropped = 0;
  double dropped_volume = 0;
  for (std::size_t root = 0; root < parent.size(); ++root) {
    if (faces[root] == 0) continue;
    is_kept[root] = volume[root] > crumb_share * drawn.volume;
    if (!is_kept[root]) {
      ++dropped;
      dropped_volume += std::abs(volume[root]);
      continue;
    }
    ++surface.parts;
    surface.handles += static_cast<int>((2 - (points[root] - faces[root] / 2)) / 2);  // V - E + F with E = 3 F / 2
  }
  if (dropped == 0) return;
  surface.notes.push_back(fmt::format("{} crumbs or cavities of {:.2g} mm3 in all dropped from the smooth surface", dropped, dropped_volume));
  Drawn kept;
  std::vector<int> renamed(drawn.points.size(), -1);
  for (const auto& t : drawn.triangles) {
    if (!is_kept[static_cast<std::size_t>(find_root(parent, t[0]))]) continue;
    auto& triangle = kept.triangles.emplace_back(t);
    for (int& p : triangle) {
      int& name = renamed[static_cast<std::size_t>(p)];
      if (name < 0) {
        name = static_cast<int>(kept.points.size());
        kept.points.push_back(drawn.points[static_cast<std::size_t>(p)]);
      }
      p = name;
    }
  }
  measure(kept);
  drawn = std::move(kept);
}

/// Value of a field on voxels at a place between them.
double interpolated(const std::vector<float>& field, const LabelImage& box, const Vec3& voxel) {
  std::array<int, 3> low;
  Vec3 part;
  for (Eigen::Index a = 0; a < 3; ++a) {
    const int most = box.size[static_cast<std::size_t>(a)] - 2;
    low[static_cast<std::size_t>(a)] = std::clamp(static_cast<int>(std::floor(voxel[a])), 0, most);
    part[a] = voxel[a] - low[static_cast<std::size_t>(a)];
  }
  double sum = 0;
  for (int c = 0; c < 8; ++c) {
    double weight = 1;
    for (int a = 0; a < 3; ++a) weight *= (c >> a & 1) ? part[a] : 1 - part[a];
    sum += weight * field[box.index(low[0] + (c & 1), low[1] + (c >> 1 & 1), low[2] + (c >> 2 & 1))];
  }
  return sum;
}

std::vector<int> regions_of(const Drawn& drawn, const LabelImage& box) {
  const auto distance_to = [&](Part part) { return distance_map(box.size, box.spacing(), [&](std::size_t v) { return is_part(box.values[v], part); }); };
  const std::vector<float> posterior = distance_to(Part::posterior), anterior = distance_to(Part::anterior);
  const Mat3 to_voxel = box.axes.inverse();
  std::vector<int> region;
  for (const auto& t : drawn.triangles) {
    Vec3 middle = Vec3::Zero();
    for (int p : t) middle += drawn.points[static_cast<std::size_t>(p)] / 3;
    const Vec3 voxel = to_voxel * (middle - box.origin);
    region.push_back(interpolated(posterior, box, voxel) <= interpolated(anterior, box, voxel) ? Region::posterior : Region::anterior);
  }
  return region;
}

}  // namespace

LabelSurface label_surface(const LabelledParts& parts, const LabelSurfaceOptions& options, const std::string& name) {
  const LabelImage box = leaflet_box(parts);
  Mask mask{box.size, box.spacing(), std::vector<char>(box.values.size())};
  for (std::size_t v = 0; v < box.values.size(); ++v) mask.inside[v] = is_leaflet(box.values[v]);
  const auto voxels = std::count(mask.inside.begin(), mask.inside.end(), 1);
  LabelSurface surface;
  surface.voxel_volume = static_cast<double>(voxels) * box.voxel_volume();
  surface.joined = join_diagonals(mask);
  long filled = 0;
  if (const int holes = fill_holes(mask, options.hole_radius, &filled); holes > 0) {
    surface.notes.push_back(fmt::format("{} small holes through the leaflets filled with {} voxels (labels.hole_radius = 0 keeps them)", holes, filled));
    surface.joined += join_diagonals(mask);
  }
  const MaskField field = mask_field(mask);
  Drawn drawn = draw(box, field);
  const int refined = *std::max_element(field.refined.begin(), field.refined.end());
  surface.iterations = smooth_mesh(drawn.points, drawn.triangles, {options.smoothing * refined, options.reach});
  to_world(box, drawn);
  surface.offset = keep_volume(drawn, surface.voxel_volume);
  keep_large_parts(drawn, surface);
  if (drawn.triangles.empty()) throw InputError(name + ": no closed surface around the leaflets' voxels is found; they are scattered");
  surface.volume = drawn.volume;
  surface.area = drawn.area;
  const double drift = surface.volume / surface.voxel_volume - 1;
  if (!(std::abs(drift) <= options.volume_tolerance))
    throw GateError(fmt::format("{}: the smooth surface encloses {:.0f} mm3, the labels {:.0f} mm3 ({:+.1f} %, limit {:.0f} %); the leaflets are thin or ragged for "
                                "their voxels: resample the label map finer, or lower labels.smoothing",
                                name, surface.volume, surface.voxel_volume, 100 * drift, 100 * options.volume_tolerance));
  if (surface.handles > 1)
    surface.notes.push_back(fmt::format("the leaflets have {} handles where a ring has one: {} small holes through them, or bridges between them", surface.handles, surface.handles - 1));
  surface.region = regions_of(drawn, box);
  surface.points = std::move(drawn.points);
  surface.triangles = std::move(drawn.triangles);
  return surface;
}

}  // namespace mv
