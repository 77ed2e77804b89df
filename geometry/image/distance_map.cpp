// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/image/distance_map.h"

#include <cmath>
#include <limits>

#include "geometry/core/parallel.h"

namespace mv {
namespace {

constexpr float far_away = std::numeric_limits<float>::infinity();

struct Envelope {
  explicit Envelope(int n) : value(static_cast<std::size_t>(n)), apex(static_cast<std::size_t>(n)), from(static_cast<std::size_t>(n) + 1) {}
  std::vector<double> value;
  std::vector<int> apex;     // parabolas of the lower envelope
  std::vector<double> from;  // where each begins
};

/// Squared distances along one line of n nodes, `stride` apart: out(q) = min over p of in(p) + (h (q - p))^2.
void transform_line(float* line, int n, std::size_t stride, double h, Envelope& e) {
  const auto at = [&](int q) -> float& { return line[static_cast<std::size_t>(q) * stride]; };
  const double h2 = h * h;
  int count = 0;
  for (int q = 0; q < n; ++q) {
    const double f = at(q);
    e.value[static_cast<std::size_t>(q)] = f;
    if (f == far_away) continue;
    double start = -std::numeric_limits<double>::infinity();
    while (count > 0) {
      const int p = e.apex[static_cast<std::size_t>(count - 1)];
      start = ((f - e.value[static_cast<std::size_t>(p)]) / h2 + static_cast<double>(q) * q - static_cast<double>(p) * p) / (2.0 * (q - p));
      if (start > e.from[static_cast<std::size_t>(count - 1)]) break;
      --count;
    }
    if (count == 0) start = -std::numeric_limits<double>::infinity();
    e.apex[static_cast<std::size_t>(count)] = q;
    e.from[static_cast<std::size_t>(count)] = start;
    ++count;
  }
  if (count == 0) return;
  int k = 0;
  for (int q = 0; q < n; ++q) {
    while (k + 1 < count && e.from[static_cast<std::size_t>(k + 1)] < q) ++k;
    const int p = e.apex[static_cast<std::size_t>(k)];
    const double d = h * (q - p);
    at(q) = static_cast<float>(d * d + e.value[static_cast<std::size_t>(p)]);
  }
}

}  // namespace

std::vector<float> distance_map(const std::array<int, 3>& size, const Vec3& spacing, const std::function<bool(std::size_t)>& is_seed) {
  const auto nx = static_cast<std::size_t>(size[0]), ny = static_cast<std::size_t>(size[1]), nz = static_cast<std::size_t>(size[2]);
  std::vector<float> d(nx * ny * nz);
  for (std::size_t v = 0; v < d.size(); ++v) d[v] = is_seed(v) ? 0 : far_away;
  const std::array<std::size_t, 3> stride{1, nx, nx * ny};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t b = axis == 0 ? 1 : 0, c = axis == 2 ? 1 : 2;
    parallel_ranges(size[c], [&](std::ptrdiff_t begin, std::ptrdiff_t end, int) {
      Envelope envelope(size[axis]);
      for (std::ptrdiff_t z = begin; z < end; ++z)
        for (int y = 0; y < size[b]; ++y)
          transform_line(d.data() + static_cast<std::size_t>(z) * stride[c] + static_cast<std::size_t>(y) * stride[b], size[axis], stride[axis],
                         spacing[static_cast<Eigen::Index>(axis)], envelope);
    }, 4);
  }
  for (float& x : d) x = std::sqrt(x);
  return d;
}

}  // namespace mv
