// SPDX-License-Identifier: BSD-3-Clause
#include "solver/coupling/film_drainage.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "geometry/core/parallel.h"

namespace mv {

double pressure_at(const FluidGrid& grid, const std::vector<double>& pressure, const Eigen::Vector3d& x) {
  int base[3];
  double weight[3];
  for (int a = 0; a < 3; ++a) {
    const double s = std::clamp((x[a] - grid.lower[a]) / grid.h - 0.5, 0.0, grid.n[static_cast<std::size_t>(a)] - 1.0 - 1e-9);
    base[a] = static_cast<int>(s);
    weight[a] = s - base[a];
  }
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    double w = 1;
    int at[3];
    for (int a = 0; a < 3; ++a) {
      const int up = (corner >> a) & 1;
      at[a] = base[a] + up;
      w *= up ? weight[a] : 1 - weight[a];
    }
    if (w > 0) sum += w * pressure[static_cast<std::size_t>(grid.index(at[0], at[1], at[2]))];
  }
  return sum;
}

FilmDrainage::FilmDrainage(const Structure& structure, const FluidGrid& grid, const FilmDrainageOptions& options)
    : structure_(&structure), grid_(grid), options_(options) {
  const ContactSurface& surface = structure.surface();
  const std::size_t leaflet_nodes = static_cast<std::size_t>(structure.leaflet_nodes());
  const std::vector<double>& rest = structure.rest_positions();
  const std::size_t count = static_cast<std::size_t>(surface.node_count());
  normals_.resize(count);
  slip_.resize(count);
  smoothed_.resize(count);
  std::vector<Eigen::Vector3d> held;
  for (std::size_t i = 0; i < leaflet_nodes; ++i)
    if (structure.is_fixed()[i]) held.push_back(Eigen::Vector3d::Map(rest.data() + 3 * i));
  hinge_fade_.assign(count, 1.0);
  parallel_for(surface.node_count(), [&](std::ptrdiff_t n) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3d& h : held) nearest = std::min(nearest, (surface.reference[static_cast<std::size_t>(n)] - h).squaredNorm());
    hinge_fade_[static_cast<std::size_t>(n)] =
        std::clamp((std::sqrt(nearest) / grid_.h - options_.hinge_free) / (options_.hinge_full - options_.hinge_free), 0.0, 1.0);
  });
  std::vector<std::vector<int>> around(count);
  for (std::size_t f = 0; f < surface.triangles.size(); ++f)
    if (surface.triangle_side[f] > 0)
      for (int a : surface.triangles[f])
        for (int b : surface.triangles[f])
          if (a != b) around[static_cast<std::size_t>(a)].push_back(b);
  neighbour_start_.push_back(0);
  for (auto& list : around) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    neighbours_.insert(neighbours_.end(), list.begin(), list.end());
    neighbour_start_.push_back(static_cast<int>(neighbours_.size()));
  }
  // Nearest atrial-face node at rest, by a hash with cells of the fluid spacing.
  std::unordered_multimap<long, int> cells;
  auto key = [&](const Eigen::Vector3d& p, int dx, int dy, int dz) {
    const auto cell = [&](int a) { return static_cast<long>(std::floor(p[a] / grid_.h)); };
    return ((cell(0) + dx) * 73856093L) ^ ((cell(1) + dy) * 19349663L) ^ ((cell(2) + dz) * 83492791L);
  };
  for (std::size_t s = 0; s < count; ++s)
    if (surface.on_atrial_face[s]) cells.emplace(key(surface.reference[s], 0, 0, 0), static_cast<int>(s));
  surface_index_.assign(leaflet_nodes, -1);
  for (std::size_t i = 0; i < leaflet_nodes; ++i) {
    if (structure.is_fixed()[i]) continue;
    const Eigen::Vector3d p = Eigen::Vector3d::Map(rest.data() + 3 * i);
    double best = std::numeric_limits<double>::infinity();
    for (int reach = 1; reach <= 4; ++reach) {
      for (int dx = -reach; dx <= reach; ++dx)
        for (int dy = -reach; dy <= reach; ++dy)
          for (int dz = -reach; dz <= reach; ++dz) {
            const auto range = cells.equal_range(key(p, dx, dy, dz));
            for (auto it = range.first; it != range.second; ++it) {
              const double d = (surface.reference[static_cast<std::size_t>(it->second)] - p).squaredNorm();
              if (d < best || (d == best && it->second < surface_index_[i])) {
                best = d;
                surface_index_[i] = it->second;
              }
            }
          }
      // Everything within `reach` cells has been seen.
      if (best <= reach * reach * grid_.h * grid_.h) break;
    }
  }
}

void FilmDrainage::find_gaps(std::span<const double> x, std::vector<double>& gaps) {
  const ContactSurface& surface = structure_->surface();
  structure_->contact()->closest_gaps(x, options_.reach_end * grid_.h, true, closest_);
  gaps.assign(static_cast<std::size_t>(structure_->leaflet_nodes()), std::numeric_limits<double>::infinity());
  for (std::size_t s = 0; s < closest_.gap.size(); ++s)
    if (surface.on_atrial_face[s] && closest_.triangle[s] >= 0 && closest_.gap[s] > -structure_->contact()->options().penetration_limit) gaps[static_cast<std::size_t>(surface.nodes[s])] = closest_.gap[s];
}

double FilmDrainage::slip(std::span<double> x, std::span<double> v, std::span<const double> gaps, const std::vector<double>& pressure,
                          double pressure_difference, std::span<const double> forces, double dt) {
  const ContactSurface& surface = structure_->surface();
  const auto contact_pressure = structure_->contact()->pressure();
  current_node_normals(surface, x, normals_);
  const double touching = structure_->contact_threshold();
  const double speed = grid_.h / (options_.drainage_time * options_.pressure_scale);
  parallel_for(surface.node_count(), [&](std::ptrdiff_t n) {
    const std::size_t s = static_cast<std::size_t>(n);
    slip_[s].setZero();
    const double gap = gaps[static_cast<std::size_t>(surface.nodes[s])];
    if (!(gap < options_.reach_end * grid_.h)) return;
    const Eigen::Vector3d here = Eigen::Vector3d::Map(x.data() + 3 * surface.nodes[s]);
    const double film = pressure_at(grid_, pressure, here + 0.5 * std::max(gap, 0.0) * normals_[s]);
    const double drive = std::min(film, pressure_difference - contact_pressure[s]);
    double fade = std::clamp((options_.reach_end - gap / grid_.h) / (options_.reach_end - options_.reach_full), 0.0, 1.0);
    if (drive > 0) {
      // Nothing is left to drain where the faces touch, and a pressure above the ventricle's is not a film's but that of crushed tissue.
      fade *= std::clamp(2.0 * gap / touching, 0.0, 1.0) * std::clamp(2.0 - film / std::max(pressure_difference, 0.01 * options_.pressure_scale), 0.0, 1.0);
    }
    slip_[s] = speed * fade * drive * normals_[s];
  });
  for (int pass = 0; pass < options_.smoothing_passes; ++pass) {
    parallel_for(surface.node_count(), [&](std::ptrdiff_t n) {
      const std::size_t s = static_cast<std::size_t>(n);
      Eigen::Vector3d sum = slip_[s];
      const int begin = neighbour_start_[s], end = neighbour_start_[s + 1];
      for (int q = begin; q < end; ++q) sum += slip_[static_cast<std::size_t>(neighbours_[static_cast<std::size_t>(q)])];
      smoothed_[s] = sum / (1.0 + end - begin);
    });
    std::swap(slip_, smoothed_);
  }
  parallel_for(surface.node_count(), [&](std::ptrdiff_t n) { slip_[static_cast<std::size_t>(n)] *= hinge_fade_[static_cast<std::size_t>(n)]; });
  double lost = 0;
  for (std::size_t i = 0; i < surface_index_.size(); ++i) {
    if (surface_index_[i] < 0) continue;
    const Eigen::Vector3d& slip = slip_[static_cast<std::size_t>(surface_index_[i])];
    if (slip.x() == 0 && slip.y() == 0 && slip.z() == 0) continue;
    Eigen::Vector3d::Map(x.data() + 3 * i) += dt * slip;
    Eigen::Vector3d::Map(v.data() + 3 * i) += slip;
    lost += dt * slip.dot(Eigen::Vector3d::Map(forces.data() + 3 * i));
  }
  return lost;
}

}  // namespace mv
