// SPDX-License-Identifier: BSD-3-Clause
#include "solver/coupling/transfer.h"

#include <algorithm>
#include <cstring>
#include <limits>
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
// Rows of cells (along y and z) whose points are spread together. Points of two blocks that are one apart touch rows up to `reach` beyond their own, and one more where a narrow
// kernel's last weight is zero.
constexpr std::ptrdiff_t spread_block = 2 * reach + 1;

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
}

int Transfer::bind(std::span<const double> positions, std::span<const int> active) {
  const std::ptrdiff_t count = static_cast<std::ptrdiff_t>(active.size());
  const int rows = grid_.n[1];
  row_of_.resize(active.size());
  row_end_.assign(static_cast<std::size_t>(grid_.n[2]) * static_cast<std::size_t>(rows) + 1, 0);
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
    if (row >= 0) ++row_end_[static_cast<std::size_t>(row) + 1];
  for (std::size_t r = 0; r + 1 < row_end_.size(); ++r) row_end_[r + 1] += row_end_[r];
  const std::size_t bound = static_cast<std::size_t>(row_end_.back());
  order_.resize(bound);
  // row_end_ holds where each row begins, and is moved on to where it ends.
  for (std::size_t q = 0; q < active.size(); ++q)
    if (row_of_[q] >= 0) order_[static_cast<std::size_t>(row_end_[static_cast<std::size_t>(row_of_[q])]++)] = active[q];
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
  if (order_.empty()) return;
  // Blocks of rows, four colours: points in two blocks of a colour share no row, so each point is spread once, without locks, in an order that knows no threads.
  const std::ptrdiff_t rows = grid_.n[1], planes = grid_.n[2], across = (rows + spread_block - 1) / spread_block, up = (planes + spread_block - 1) / spread_block;
  const auto end_of_row = [&](std::ptrdiff_t row) { return row < 0 ? 0 : row_end_[static_cast<std::size_t>(row)]; };
  const auto spread_point = [&](int q) {
    const PointWeights<K> weights(scaled_.data() + 3 * q);
    const double* force = forces.data() + 3 * order_[static_cast<std::size_t>(q)];
    for_components([&](auto component) {
      constexpr int c = component, ny = kernel_width<K>(c == 1), nz = kernel_width<K>(c == 2);
      const KernelWeights &wx = weights.of(c, 0), &wy = weights.of(c, 1), &wz = weights.of(c, 2);
      double* base = force_density.c[c].data() + grid_.index(wx.first, wy.first, wz.first);
      const double* open = open_[c].data() + (wx.first + FluidGrid::ghosts) + sy * (wy.first + FluidGrid::ghosts);
      const Quad along_x = (force[c] * per_volume) * wx.w;
      for (int j = 0; j < ny; ++j) {
        const Quad wxy = along_x * (wy.w[j] * load(open + sy * j));
        for (int k = 0; k < nz; ++k) {
          double* row = base + sy * j + sz * k;
          store(row, load(row) + wz.w[k] * wxy);
        }
      }
    });
  };
  const std::ptrdiff_t serial_below = static_cast<std::ptrdiff_t>(order_.size()) < serial_loop_limit ? std::numeric_limits<std::ptrdiff_t>::max() : 2;
  for (std::ptrdiff_t colour = 0; colour < 4; ++colour) {
    const std::ptrdiff_t j0 = colour % 2, k0 = colour / 2, columns = (across - j0 + 1) / 2, count = columns * ((up - k0 + 1) / 2);
    parallel_pieces(
        count, 1,
        [&](std::ptrdiff_t first, std::ptrdiff_t last, int) {
          for (std::ptrdiff_t b = first; b < last; ++b) {
            const std::ptrdiff_t j = spread_block * (j0 + 2 * (b % columns)), k = spread_block * (k0 + 2 * (b / columns));
            const std::ptrdiff_t j_end = std::min(j + spread_block, rows), k_end = std::min(k + spread_block, planes);
            for (std::ptrdiff_t plane = k; plane < k_end; ++plane)
              for (int q = end_of_row(j - 1 + rows * plane); q < end_of_row(j_end - 1 + rows * plane); ++q) spread_point(q);
          }
        },
        serial_below);
  }
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
