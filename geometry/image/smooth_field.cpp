// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/image/smooth_field.h"

#include <algorithm>
#include <cmath>

#include "geometry/core/parallel.h"
#include "geometry/image/distance_map.h"

namespace mv {
namespace {

constexpr int most_iterations = 3000;
constexpr double stop_at = 2e-5;     // largest change of an iteration, in units of the smallest voxel step
constexpr double band_voxels = 3;    // half width of the band in which phi is free
constexpr int most_refined = 8;

struct Stencil {
  std::array<std::ptrdiff_t, 3> stride;
  std::array<double, 3> weight;
  double apply(const double* x) const {
    double sum = 0;
    for (std::size_t a = 0; a < 3; ++a) sum += weight[a] * (x[stride[a]] + x[-stride[a]] - 2 * x[0]);
    return sum;
  }
  double largest_eigenvalue() const { return 4 * (weight[0] + weight[1] + weight[2]); }
};

/// Nodes in which phi is free, and with their neighbours those in which L phi counts.
struct Band {
  std::vector<std::ptrdiff_t> free, around;
};

bool is_interior(std::size_t v, const std::array<int, 3>& size, int margin) {
  const auto nx = static_cast<std::size_t>(size[0]), ny = static_cast<std::size_t>(size[1]);
  const std::array<int, 3> x{static_cast<int>(v % nx), static_cast<int>(v / nx % ny), static_cast<int>(v / nx / ny)};
  for (std::size_t a = 0; a < 3; ++a)
    if (x[a] < margin || x[a] >= size[a] - margin) return false;
  return true;
}

Band make_band(const std::vector<double>& phi, const std::array<int, 3>& size, const Stencil& stencil, double width) {
  Band band;
  std::vector<char> kind(phi.size(), 0);
  for (std::size_t v = 0; v < phi.size(); ++v)
    if (std::abs(phi[v]) <= width && is_interior(v, size, 2)) {
      kind[v] = 2;
      band.free.push_back(static_cast<std::ptrdiff_t>(v));
    }
  for (const auto v : band.free)
    for (std::size_t a = 0; a < 3; ++a)
      for (const auto n : {v + stencil.stride[a], v - stencil.stride[a]})
        if (kind[static_cast<std::size_t>(n)] == 0) kind[static_cast<std::size_t>(n)] = 1;
  for (std::size_t v = 0; v < kind.size(); ++v)
    if (kind[v] != 0) band.around.push_back(static_cast<std::ptrdiff_t>(v));
  return band;
}

}  // namespace

SmoothField smooth_field(const Mask& mask, double lambda, int refine) {
  SmoothField field;
  Vec3 step;
  const double shortest = mask.spacing.minCoeff();
  for (std::size_t a = 0; a < 3; ++a) {
    const double h = mask.spacing[static_cast<Eigen::Index>(a)];
    field.refined[a] = std::clamp(static_cast<int>(std::lround(h / shortest)) * refine, 1, most_refined);
    field.size[a] = (mask.size[a] - 1) * field.refined[a] + 1;
    step[static_cast<Eigen::Index>(a)] = h / field.refined[a];
  }
  const auto nx = static_cast<std::size_t>(field.size[0]), ny = static_cast<std::size_t>(field.size[1]);
  const auto& r = field.refined;
  const auto is_centre = [&](std::size_t v, bool wanted) {
    const std::size_t i = v % nx, j = v / nx % ny, k = v / nx / ny;
    if (i % static_cast<std::size_t>(r[0]) != 0 || j % static_cast<std::size_t>(r[1]) != 0 || k % static_cast<std::size_t>(r[2]) != 0) return false;
    const std::size_t voxel = (k / static_cast<std::size_t>(r[2]) * static_cast<std::size_t>(mask.size[1]) + j / static_cast<std::size_t>(r[1])) *
                                  static_cast<std::size_t>(mask.size[0]) + i / static_cast<std::size_t>(r[0]);
    return (mask.inside[voxel] != 0) == wanted;
  };
  const std::vector<float> d_in = distance_map(field.size, step, [&](std::size_t v) { return is_centre(v, true); });
  const std::vector<float> d_out = distance_map(field.size, step, [&](std::size_t v) { return is_centre(v, false); });
  const std::size_t nodes = d_in.size();
  std::vector<double> middle(nodes);
  for (std::size_t v = 0; v < nodes; ++v) middle[v] = 0.5 * (static_cast<double>(d_out[v]) - d_in[v]);

  std::vector<double> x = middle;
  if (lambda > 0) {
    const Stencil stencil{{1, static_cast<std::ptrdiff_t>(nx), static_cast<std::ptrdiff_t>(nx * ny)},
                          {static_cast<double>(r[0] * r[0]), static_cast<double>(r[1] * r[1]), static_cast<double>(r[2] * r[2])}};
    const Band band = make_band(middle, field.size, stencil, band_voxels * mask.spacing.maxCoeff());
    const double hold = std::pow(lambda, -4), size = 1 / (stencil.largest_eigenvalue() * stencil.largest_eigenvalue() + hold);
    // Accelerated projected gradient (Beck and Teboulle 2009) with restart (O'Donoghue and Candes 2015).
    std::vector<double> y = x, laplacian(nodes, 0.0), next = x;
    const auto count = static_cast<std::ptrdiff_t>(band.free.size()), count_around = static_cast<std::ptrdiff_t>(band.around.size());
    double t = 1;
    for (field.iterations = 0; field.iterations < most_iterations;) {
      ++field.iterations;
      parallel_for(count_around, [&](std::ptrdiff_t n) {
        const auto v = band.around[static_cast<std::size_t>(n)];
        laplacian[static_cast<std::size_t>(v)] = stencil.apply(y.data() + v);
      });
      parallel_for(count, [&](std::ptrdiff_t n) {
        const auto v = band.free[static_cast<std::size_t>(n)];
        const auto u = static_cast<std::size_t>(v);
        const double slope = stencil.apply(laplacian.data() + v) + hold * (y[u] - middle[u]);
        next[u] = std::clamp(y[u] - size * slope, -static_cast<double>(d_in[u]), static_cast<double>(d_out[u]));
      });
      const double uphill = parallel_sum(count, [&](std::ptrdiff_t n) {
        const auto u = static_cast<std::size_t>(band.free[static_cast<std::size_t>(n)]);
        return (y[u] - next[u]) * (next[u] - x[u]);
      });
      if (uphill > 0) t = 1;
      const double t_next = 0.5 * (1 + std::sqrt(1 + 4 * t * t)), push = (t - 1) / t_next;
      t = t_next;
      field.last_change = 0;
      for (const auto v : band.free) {
        const auto u = static_cast<std::size_t>(v);
        const double change = next[u] - x[u];
        field.last_change = std::max(field.last_change, std::abs(change));
        y[u] = next[u] + push * change;
        x[u] = next[u];
      }
      if (field.last_change < stop_at * shortest) break;
    }
  }
  field.phi.assign(x.begin(), x.end());
  return field;
}

}  // namespace mv
