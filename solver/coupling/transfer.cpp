// SPDX-License-Identifier: BSD-3-Clause
#include "solver/coupling/transfer.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <type_traits>

#include "geometry/core/parallel.h"

namespace mv {

Kernel kernel_from_name(const std::string& name) {
  if (name == "ib3") return Kernel::ib3;
  if (name == "ib4") return Kernel::ib4;
  if (name == "cbs32") return Kernel::cbs32;
  throw std::invalid_argument("unknown kernel '" + name + "': expected ib3, ib4 or cbs32");
}

namespace {

// A kernel reaches at most this many cells below and above the cell of its point.
constexpr int reach = 2;

// Narrower kernels have zero weights at the end: the values read there lie in the ghost layers or the next row.
inline Quad load(const double* p) {
  Quad q;
  std::memcpy(&q, p, sizeof q);
  return q;
}
inline void store(double* p, Quad q) { std::memcpy(p, &q, sizeof q); }

// Weights of one point (in cells) along the three axes, on the faces and in the middle between them.
template <Kernel K>
struct PointWeights {
  KernelWeights face[3], centre[3];
  explicit PointWeights(const double* s) {
    for (int a = 0; a < 3; ++a) {
      face[a] = kernel_weights<K>(s[a], true);
      centre[a] = kernel_weights<K>(s[a] - 0.5, false);
    }
  }
  const KernelWeights& of(int component, int axis) const { return component == axis ? face[axis] : centre[axis]; }
};

/// Calls body(component) with the component as a constant.
template <class Body>
inline void for_components(Body&& body) {
  body(std::integral_constant<int, 0>());
  body(std::integral_constant<int, 1>());
  body(std::integral_constant<int, 2>());
}

}  // namespace

Transfer::Transfer(const FluidGrid& grid, const TubeWall& wall, Kernel kernel) : grid_(grid), has_wall_(wall.is_present), kernel_(kernel) {
  for (std::size_t c = 0; c < 3; ++c) open_[c] = wall.stencil[c].open;
  slab_start_.assign(static_cast<std::size_t>(grid.n[2]) + 1, 0);
}

int Transfer::bind(std::span<const double> positions, std::span<const int> active) {
  const std::ptrdiff_t count = static_cast<std::ptrdiff_t>(active.size());
  const int rows = grid_.n[1];
  row_of_.resize(active.size());
  row_start_.assign(static_cast<std::size_t>(grid_.n[2]) * static_cast<std::size_t>(rows) + 1, 0);
  const double inverse_h = 1.0 / grid_.h;
  parallel_for(count, [&](std::ptrdiff_t q) {
    const double* x = positions.data() + 3 * active[static_cast<std::size_t>(q)];
    double s[3];
    bool is_inside = true;
    for (int a = 0; a < 3; ++a) {
      s[a] = (x[a] - grid_.lower[a]) * inverse_h;
      // Written so that NaN counts as outside.
      if (!(s[a] >= 0 && s[a] < grid_.n[static_cast<std::size_t>(a)])) is_inside = false;
    }
    row_of_[static_cast<std::size_t>(q)] = is_inside ? static_cast<int>(s[1]) + rows * static_cast<int>(s[2]) : -1;
  });
  for (int row : row_of_)
    if (row >= 0) ++row_start_[static_cast<std::size_t>(row) + 1];
  for (std::size_t r = 0; r + 1 < row_start_.size(); ++r) row_start_[r + 1] += row_start_[r];
  const std::size_t bound = static_cast<std::size_t>(row_start_.back());
  order_.resize(bound);
  for (std::size_t k = 0; k < slab_start_.size(); ++k) slab_start_[k] = row_start_[k * static_cast<std::size_t>(rows)];
  for (std::size_t q = 0; q < active.size(); ++q)
    if (row_of_[q] >= 0) order_[static_cast<std::size_t>(row_start_[static_cast<std::size_t>(row_of_[q])]++)] = active[q];
  scaled_.resize(3 * bound);
  parallel_for(static_cast<std::ptrdiff_t>(bound), [&](std::ptrdiff_t at) {
    const double* x = positions.data() + 3 * order_[static_cast<std::size_t>(at)];
    for (std::ptrdiff_t a = 0; a < 3; ++a) scaled_[static_cast<std::size_t>(3 * at + a)] = (x[a] - grid_.lower[a]) * inverse_h;
  });
  return static_cast<int>(active.size() - bound);
}

int Transfer::move_bound(std::span<const double> positions) {
  const double inverse_h = 1.0 / grid_.h;
  const double left = parallel_sum(static_cast<std::ptrdiff_t>(order_.size()), [&](std::ptrdiff_t at) {
    const double* x = positions.data() + 3 * order_[static_cast<std::size_t>(at)];
    double s[3];
    bool is_inside = true;
    for (int a = 0; a < 3; ++a) {
      s[a] = (x[a] - grid_.lower[a]) * inverse_h;
      if (!(s[a] >= 0 && s[a] < grid_.n[static_cast<std::size_t>(a)])) is_inside = false;
    }
    if (!is_inside) return 1.0;
    std::copy_n(s, 3, scaled_.data() + 3 * at);
    return 0.0;
  });
  return static_cast<int>(left);
}

template <Kernel K>
void Transfer::interpolate_with(const FaceField& velocity, std::span<double> velocities) const {
  const std::ptrdiff_t sy = grid_.stride_y(), sz = grid_.stride_z();
  parallel_for(static_cast<std::ptrdiff_t>(order_.size()), [&](std::ptrdiff_t q) {
    const PointWeights<K> weights(scaled_.data() + 3 * q);
    double* out = velocities.data() + 3 * order_[static_cast<std::size_t>(q)];
    for_components([&](auto component) {
      constexpr int c = component, ny = kernel_width<K>(c == 1), nz = kernel_width<K>(c == 2);
      const KernelWeights &wx = weights.of(c, 0), &wy = weights.of(c, 1), &wz = weights.of(c, 2);
      const double* base = velocity.c[c].data() + grid_.index(wx.first, wy.first, wz.first);
      const double* open = open_[c].data() + (wx.first + FluidGrid::ghosts) + sy * (wy.first + FluidGrid::ghosts);
      Quad sum{};
      for (int j = 0; j < ny; ++j) {
        Quad column{};
        for (int k = 0; k < nz; ++k) column += wz.w[k] * load(base + sy * j + sz * k);
        sum += (wy.w[j] * load(open + sy * j)) * column;
      }
      sum *= wx.w;
      out[c] = (sum[0] + sum[1]) + (sum[2] + sum[3]);
    });
  });
}

template <Kernel K>
void Transfer::spread_with(std::span<const double> forces, FaceField& force_density) const {
  const std::ptrdiff_t sy = grid_.stride_y(), sz = grid_.stride_z();
  const double per_volume = 1.0 / (grid_.h * grid_.h * grid_.h);
  // A thread owns a range of planes and takes only the share of each point that falls there. Cut where the points are, not the planes.
  const std::ptrdiff_t planes = grid_.n[2] + 1;
  const std::ptrdiff_t points = static_cast<std::ptrdiff_t>(order_.size());
  auto plane_of_share = [&](std::ptrdiff_t share, std::ptrdiff_t teams) -> std::ptrdiff_t {
    if (share == 0) return -FluidGrid::ghosts;
    if (share == teams) return planes + FluidGrid::ghosts;
    const int wanted = static_cast<int>(points * share / teams);
    const auto it = std::lower_bound(slab_start_.begin(), slab_start_.end(), wanted);
    const bool is_earlier_nearer = it != slab_start_.begin() && wanted - *(it - 1) < *it - wanted;
    return it - slab_start_.begin() - is_earlier_nearer;
  };
  const std::ptrdiff_t teams = points < serial_loop_limit ? 1 : thread_count();
  parallel_for(
      teams,
      [&](std::ptrdiff_t t) {
        const std::ptrdiff_t k_begin = plane_of_share(t, teams), k_end = plane_of_share(t + 1, teams);
        const auto slab = [&](std::ptrdiff_t k) { return slab_start_[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(k, 0, grid_.n[2]))]; };
        for (int q = slab(k_begin - reach); q < slab(k_end + reach); ++q) {
          const PointWeights<K> weights(scaled_.data() + 3 * q);
          const double* force = forces.data() + 3 * order_[static_cast<std::size_t>(q)];
          for_components([&](auto component) {
            constexpr int c = component, ny = kernel_width<K>(c == 1), nz = kernel_width<K>(c == 2);
            const KernelWeights &wx = weights.of(c, 0), &wy = weights.of(c, 1), &wz = weights.of(c, 2);
            double* base = force_density.c[c].data() + grid_.index(wx.first, wy.first, wz.first);
            const double* open = open_[c].data() + (wx.first + FluidGrid::ghosts) + sy * (wy.first + FluidGrid::ghosts);
            const Quad along_x = (force[c] * per_volume) * wx.w;
            const int k0 = std::max<int>(0, static_cast<int>(k_begin) - wz.first);
            const int k1 = std::min<int>(nz, static_cast<int>(k_end) - wz.first);
            const auto add = [&](int first, int last) {
              for (int j = 0; j < ny; ++j) {
                const Quad wxy = along_x * (wy.w[j] * load(open + sy * j));
                for (int k = first; k < last; ++k) {
                  double* row = base + sy * j + sz * k;
                  store(row, load(row) + wz.w[k] * wxy);
                }
              }
            };
            if (k0 == 0 && k1 == nz) add(0, nz);  // unrolled
            else add(k0, k1);
          });
        }
      },
      2);
}

double Transfer::kernel_reach() const {
  switch (kernel_) {
    case Kernel::ib3: return 0.5 * kernel_width<Kernel::ib3>(true);
    case Kernel::ib4: return 0.5 * kernel_width<Kernel::ib4>(true);
    case Kernel::cbs32: return 0.5 * kernel_width<Kernel::cbs32>(true);
  }
  return reach;
}

template <Kernel K>
double Transfer::smeared_ramp_with(double s) {
  constexpr int offsets = 32;
  double sum = 0;
  for (int o = 0; o < offsets; ++o) {
    const double offset = (o + 0.5) / offsets;   // of the clamp from a grid point
    for (const bool is_own_axis : {true, false}) {
      const KernelWeights weights = kernel_weights<K>(s + offset, is_own_axis);
      for (int k = 0; k < weights.width; ++k) sum += 0.5 / offsets * weights.w[k] * std::max(0.0, weights.first + k - offset);
    }
  }
  return sum;
}

double Transfer::smeared_ramp(double s) const {
  switch (kernel_) {
    case Kernel::ib3: return smeared_ramp_with<Kernel::ib3>(s);
    case Kernel::ib4: return smeared_ramp_with<Kernel::ib4>(s);
    case Kernel::cbs32: return smeared_ramp_with<Kernel::cbs32>(s);
  }
  return s;
}

void Transfer::interpolate(const FaceField& velocity, std::span<double> velocities) const {
  switch (kernel_) {
    case Kernel::ib3: return interpolate_with<Kernel::ib3>(velocity, velocities);
    case Kernel::ib4: return interpolate_with<Kernel::ib4>(velocity, velocities);
    case Kernel::cbs32: return interpolate_with<Kernel::cbs32>(velocity, velocities);
  }
}

void Transfer::spread(std::span<const double> forces, FaceField& force_density) const {
  switch (kernel_) {
    case Kernel::ib3: return spread_with<Kernel::ib3>(forces, force_density);
    case Kernel::ib4: return spread_with<Kernel::ib4>(forces, force_density);
    case Kernel::cbs32: return spread_with<Kernel::cbs32>(forces, force_density);
  }
}

}  // namespace mv
