// SPDX-License-Identifier: BSD-3-Clause
#include "solver/coupling/film_drainage.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "geometry/core/parallel.h"

namespace mv {

namespace {
// Faces closer than this share of the contact threshold drain more slowly, and not at all when they touch.
constexpr double touching_share = 0.25;
// The pressure outside is read this many cells behind the leaflet, beyond the kernel's reach from its middle.
constexpr double outside_cells = 1.5;
// Averages over neighbours before the film's pressure is limited to what is possible.
constexpr int film_smoothing_passes = 4;
// What an element out of balance can drive at most, in p_scale: three times the pressure is more than any fold needs.
constexpr double largest_drive = 3.0;
constexpr double largest_slip = 0.1;  // cells in a step
}  // namespace

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

FilmDrainage::FilmDrainage(const ContactSurface& surface, const SelfContact& contact, std::span<const double> rest, std::span<const char> is_fixed,
                           const FluidGrid& grid, const FilmDrainageOptions& options)
    : surface_(&surface), contact_(&contact), grid_(grid), options_(options) {
  const std::size_t leaflet_nodes = rest.size() / 3;
  const std::size_t count = static_cast<std::size_t>(surface.node_count());
  normals_.resize(count);
  slip_.resize(count);
  smoothed_.resize(count);
  hinge_fade_ = rest_distances_to(surface, is_fixed);
  for (double& d : hinge_fade_) d = std::clamp((d / grid_.h - options_.hinge_free) / (options_.hinge_full - options_.hinge_free), 0.0, 1.0);
  border_fade_.assign(count, 1.0);
  if (const double thickness = contact.options().thickness; thickness > 0) {
    std::vector<char> is_rim(static_cast<std::size_t>(surface.solid_nodes), 0);
    for (std::size_t f = 0; f < surface.triangles.size(); ++f)
      if (surface.triangle_side[f] == 0)
        for (int n : surface.triangles[f]) {
          const std::size_t node = static_cast<std::size_t>(surface.nodes[static_cast<std::size_t>(n)]);
          is_rim[node] = !is_fixed[node];  // the rim at the annulus is the hinge
        }
    border_fade_ = rest_distances_to(surface, is_rim);
    for (double& d : border_fade_) d = std::clamp(d / thickness, 0.0, 1.0);
  }
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
    if (is_fixed[i]) continue;
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
  std::vector<std::vector<int>> columns(count);
  for (std::size_t i = 0; i < leaflet_nodes; ++i)
    if (surface_index_[i] >= 0) columns[static_cast<std::size_t>(surface_index_[i])].push_back(static_cast<int>(i));
  column_start_.push_back(0);
  for (const auto& column : columns) {
    column_.insert(column_.end(), column.begin(), column.end());
    column_start_.push_back(static_cast<int>(column_.size()));
  }
  areas_.assign(count, 0.0);
  for (auto* array : {&fade_, &unbalanced_, &film_, &film_smoothed_}) array->assign(count, 0.0);
}

void FilmDrainage::find_gaps(std::span<const double> x, std::vector<double>& gaps) {
  const ContactSurface& surface = *surface_;
  contact_->closest_gaps(x, options_.reach_end * grid_.h, true, closest_);
  gaps.assign(surface_index_.size(), std::numeric_limits<double>::infinity());
  for (std::size_t s = 0; s < closest_.gap.size(); ++s)
    if (surface.on_atrial_face[s] && closest_.triangle[s] >= 0 && closest_.gap[s] > -contact_->options().penetration_limit)
      gaps[static_cast<std::size_t>(surface.nodes[s])] = closest_.gap[s];
}

void FilmDrainage::find_reached(std::span<const double> gaps) {
  if (std::equal(gaps.begin(), gaps.end(), known_gaps_.begin(), known_gaps_.end())) return;
  known_gaps_.assign(gaps.begin(), gaps.end());
  const ContactSurface& surface = *surface_;
  is_reached_.assign(surface.nodes.size(), 0);
  reached_.clear();
  for (int s = 0; s < surface.node_count(); ++s)
    if (gaps[static_cast<std::size_t>(surface.nodes[static_cast<std::size_t>(s)])] < options_.reach_end * grid_.h) {
      is_reached_[static_cast<std::size_t>(s)] = 1;
      reached_.push_back(s);
    }
  std::size_t begin = 0;
  for (int pass = 0; pass < options_.smoothing_passes; ++pass) {
    const std::size_t end = reached_.size();
    for (std::size_t k = begin; k < end; ++k) {
      const std::size_t s = static_cast<std::size_t>(reached_[k]);
      for (int q = neighbour_start_[s]; q < neighbour_start_[s + 1]; ++q) {
        const int other = neighbours_[static_cast<std::size_t>(q)];
        if (is_reached_[static_cast<std::size_t>(other)]) continue;
        is_reached_[static_cast<std::size_t>(other)] = 1;
        reached_.push_back(other);
      }
    }
    begin = end;
  }
  std::sort(reached_.begin(), reached_.end());
  leaflet_reached_.clear();
  for (std::size_t i = 0; i < surface_index_.size(); ++i)
    if (surface_index_[i] >= 0 && is_reached_[static_cast<std::size_t>(surface_index_[i])]) leaflet_reached_.push_back(static_cast<int>(i));
  for (std::size_t s = 0; s < slip_.size(); ++s) {
    slip_[s].setZero();
    smoothed_[s].setZero();
  }
}

void FilmDrainage::press(std::span<const double> x, std::span<const double> gaps, const std::vector<double>& pressure, double pressure_difference,
                         std::span<const double> forces, std::span<double> unseen) {
  const ContactSurface& surface = *surface_;
  find_reached(gaps);
  if (reached_.empty()) return;
  const std::ptrdiff_t reached = static_cast<std::ptrdiff_t>(reached_.size());
  const auto contact_gap = contact_->gap();
  const auto visibility = contact_->visibility();
  const auto contact_force = contact_->nodal_force();
  const double threshold = contact_->options().threshold, behind = contact_->options().thickness + outside_cells * grid_.h;
  const double lowest = std::min(pressure_difference, 0.0), highest = std::max(pressure_difference, 0.0);
  current_faces_at(surface, x, reached_, normals_, areas_);
  parallel_for(reached, [&](std::ptrdiff_t n) {
    const std::size_t s = static_cast<std::size_t>(reached_[static_cast<std::size_t>(n)]);
    fade_[s] = unbalanced_[s] = film_[s] = 0;
    if (!(areas_[s] > 0) || column_start_[s] == column_start_[s + 1]) return;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int k = column_start_[s]; k < column_start_[s + 1]; ++k) sum += Eigen::Vector3d::Map(forces.data() + 3 * column_[static_cast<std::size_t>(k)]);
    const Eigen::Vector3d here = Eigen::Vector3d::Map(x.data() + 3 * surface.nodes[s]);
    const double searched = gaps[static_cast<std::size_t>(surface.nodes[s])];
    // The contact knows close gaps of this very instant.
    const double gap = std::min(searched, contact_gap[s]);
    double outside = pressure_at(grid_, pressure, here - behind * normals_[s]);
    if (searched < options_.reach_end * grid_.h) {
      outside = std::max(outside, pressure_at(grid_, pressure, here + 0.5 * std::max(gap, 0.0) * normals_[s]));
      fade_[s] = hinge_fade_[s] * std::clamp((options_.reach_end - gap / grid_.h) / (options_.reach_end - options_.reach_full), 0.0, 1.0);
      // Beside the facing leaflet's border there is no film, only blood. Contact sees nothing beyond its range: there every face counts.
      const double in_range = std::clamp(2.0 - 2.0 * gap / threshold, 0.0, 1.0);
      fade_[s] *= 1.0 - in_range + in_range * visibility[s];
    }
    unbalanced_[s] = sum.dot(normals_[s]) / areas_[s] + std::clamp(outside, lowest, highest);
    film_[s] = unbalanced_[s] - contact_force[s].dot(normals_[s]) / areas_[s];
  });
  for (int pass = 0; pass < film_smoothing_passes; ++pass) {
    parallel_for(reached, [&](std::ptrdiff_t n) {
      const std::size_t s = static_cast<std::size_t>(reached_[static_cast<std::size_t>(n)]);
      double sum = film_[s], count = 1;
      for (int q = neighbour_start_[s]; q < neighbour_start_[s + 1]; ++q) {
        const std::size_t other = static_cast<std::size_t>(neighbours_[static_cast<std::size_t>(q)]);
        if (!is_reached_[other]) continue;
        sum += film_[other];
        count += 1;
      }
      film_smoothed_[s] = sum / count;
    });
    std::swap(film_, film_smoothed_);
  }
  parallel_for(reached, [&](std::ptrdiff_t n) {
    const std::size_t s = static_cast<std::size_t>(reached_[static_cast<std::size_t>(n)]);
    if (!(fade_[s] > 0)) return;
    Eigen::Vector3d::Map(unseen.data() + 3 * surface.nodes[s]) += border_fade_[s] * fade_[s] * std::clamp(film_[s], lowest, highest) * areas_[s] * normals_[s];
  });
}

void FilmDrainage::slip(std::span<double> x, std::span<const double> gaps, double dt) {
  if (reached_.empty()) return;
  const ContactSurface& surface = *surface_;
  const std::ptrdiff_t reached = static_cast<std::ptrdiff_t>(reached_.size());
  const auto contact_gap = contact_->gap();
  const double touching = contact_->options().threshold;
  const double mobility = grid_.h / (options_.drainage_time * options_.pressure_scale);
  parallel_for(reached, [&](std::ptrdiff_t n) {
    const std::size_t s = static_cast<std::size_t>(reached_[static_cast<std::size_t>(n)]);
    const double drive = std::clamp(unbalanced_[s], -largest_drive * options_.pressure_scale, largest_drive * options_.pressure_scale);
    slip_[s] = mobility * fade_[s] * (drive > 0 ? border_fade_[s] * drive : drive) * normals_[s];
  });
  for (int pass = 0; pass < options_.smoothing_passes; ++pass) {
    parallel_for(reached, [&](std::ptrdiff_t n) {
      const std::size_t s = static_cast<std::size_t>(reached_[static_cast<std::size_t>(n)]);
      Eigen::Vector3d sum = slip_[s];
      const int begin = neighbour_start_[s], end = neighbour_start_[s + 1];
      for (int q = begin; q < end; ++q) sum += slip_[static_cast<std::size_t>(neighbours_[static_cast<std::size_t>(q)])];
      smoothed_[s] = sum / (1.0 + end - begin);
    });
    std::swap(slip_, smoothed_);
  }
  parallel_for(reached, [&](std::ptrdiff_t n) {
    const std::size_t s = static_cast<std::size_t>(reached_[static_cast<std::size_t>(n)]);
    slip_[s] *= hinge_fade_[s];  // again: smoothing carries slip into the hinge
    // Nothing is left to drain where the faces touch: smoothing must not push them through each other.
    const double gap = std::min(gaps[static_cast<std::size_t>(surface.nodes[s])], contact_gap[s]);
    if (slip_[s].dot(normals_[s]) > 0) slip_[s] *= border_fade_[s] * std::clamp(gap / (touching_share * touching), 0.0, 1.0);
    const double length = dt * slip_[s].norm();
    if (length > largest_slip * grid_.h) slip_[s] *= largest_slip * grid_.h / length;
  });
  parallel_for(static_cast<std::ptrdiff_t>(leaflet_reached_.size()), [&](std::ptrdiff_t q) {
    const std::size_t i = static_cast<std::size_t>(leaflet_reached_[static_cast<std::size_t>(q)]);
    Eigen::Vector3d::Map(x.data() + 3 * i) += dt * slip_[static_cast<std::size_t>(surface_index_[i])];
  });
}

}  // namespace mv
