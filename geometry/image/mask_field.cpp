// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/image/mask_field.h"

#include <algorithm>
#include <cmath>

#include "geometry/image/distance_map.h"

namespace mv {
namespace {

constexpr int most_refined = 8;
constexpr int most_rounds = 20;

class Voxels {
 public:
  explicit Voxels(Mask& mask) : mask_(mask), stride_{1, mask.size[0], static_cast<std::ptrdiff_t>(mask.size[0]) * mask.size[1]} {}
  bool is_inside(std::ptrdiff_t v) const { return mask_.inside[static_cast<std::size_t>(v)] != 0; }
  std::ptrdiff_t stride(std::size_t a) const { return stride_[a]; }
  int neighbours(std::ptrdiff_t v) const {
    int count = 0;
    for (int n = 0; n < 27; ++n) count += is_inside(v + (n % 3 - 1) * stride_[0] + (n / 3 % 3 - 1) * stride_[1] + (n / 9 - 1) * stride_[2]);
    return count;
  }
  void set(std::ptrdiff_t v) { mask_.inside[static_cast<std::size_t>(v)] = 1; }
  /// Of the voxels the one with most neighbours inside; the first of equals.
  std::ptrdiff_t best(std::initializer_list<std::ptrdiff_t> candidates) const {
    std::ptrdiff_t best = *candidates.begin();
    for (const auto c : candidates)
      if (neighbours(c) > neighbours(best)) best = c;
    return best;
  }

 private:
  Mask& mask_;
  std::array<std::ptrdiff_t, 3> stride_;
};

/// Two voxels across the edge of a 2 x 2 square.
long join_square(Voxels& x, std::ptrdiff_t v, std::ptrdiff_t a, std::ptrdiff_t b) {
  const bool first = x.is_inside(v) && x.is_inside(v + a + b) && !x.is_inside(v + a) && !x.is_inside(v + b);
  const bool second = !x.is_inside(v) && !x.is_inside(v + a + b) && x.is_inside(v + a) && x.is_inside(v + b);
  if (first) x.set(x.best({v + a, v + b}));
  if (second) x.set(x.best({v, v + a + b}));
  return first || second;
}

/// Two voxels across the corner of a 2 x 2 x 2 block whose other six are outside: one that shares a face with the first, so that the square
/// rule joins it to the second.
long join_block(Voxels& x, std::ptrdiff_t v) {
  const std::ptrdiff_t a = x.stride(0), b = x.stride(1), c = x.stride(2);
  std::array<std::ptrdiff_t, 8> at{v, v + a, v + b, v + a + b, v + c, v + a + c, v + b + c, v + a + b + c};
  std::size_t pattern = 0;
  for (std::size_t n = 0; n < 8; ++n) pattern |= static_cast<std::size_t>(x.is_inside(at[n])) << n;
  for (std::size_t n = 0; n < 4; ++n)
    if (pattern == (std::size_t{1} << n | std::size_t{1} << (7 - n))) {
      x.set(x.best({at[n ^ 1], at[n ^ 2], at[n ^ 4]}));
      return 1;
    }
  return 0;
}

}  // namespace

long join_diagonals(Mask& mask) {
  Voxels x(mask);
  long total = 0;
  for (int round = 0; round < most_rounds; ++round) {
    long set = 0;
    for (int k = 1; k + 2 < mask.size[2]; ++k)
      for (int j = 1; j + 2 < mask.size[1]; ++j)
        for (int i = 1; i + 2 < mask.size[0]; ++i) {
          const std::ptrdiff_t v = i + j * x.stride(1) + k * x.stride(2);
          set += join_square(x, v, x.stride(0), x.stride(1));
          set += join_square(x, v, x.stride(1), x.stride(2));
          set += join_square(x, v, x.stride(0), x.stride(2));
          set += join_block(x, v);
        }
    total += set;
    if (set == 0) break;
  }
  return total;
}

MaskField mask_field(const Mask& mask) {
  MaskField field;
  Vec3 step;
  const double shortest = mask.spacing.minCoeff();
  for (std::size_t a = 0; a < 3; ++a) {
    const double h = mask.spacing[static_cast<Eigen::Index>(a)];
    field.refined[a] = std::clamp(static_cast<int>(std::lround(h / shortest)), 1, most_refined);
    field.size[a] = (mask.size[a] - 1) * field.refined[a] + 1;
    step[static_cast<Eigen::Index>(a)] = h / field.refined[a];
  }
  const auto nx = static_cast<std::size_t>(field.size[0]), ny = static_cast<std::size_t>(field.size[1]), nz = static_cast<std::size_t>(field.size[2]);
  std::vector<char> kind(nx * ny * nz, 0);  // 1: a centre outside, 2: a centre inside
  std::size_t voxel = 0;
  for (int k = 0; k < mask.size[2]; ++k)
    for (int j = 0; j < mask.size[1]; ++j)
      for (int i = 0; i < mask.size[0]; ++i, ++voxel)
        kind[(static_cast<std::size_t>(k * field.refined[2]) * ny + static_cast<std::size_t>(j * field.refined[1])) * nx + static_cast<std::size_t>(i * field.refined[0])] =
            mask.inside[voxel] != 0 ? 2 : 1;
  const std::vector<float> d_in = distance_map(field.size, step, [&](std::size_t v) { return kind[v] == 2; });
  field.phi = distance_map(field.size, step, [&](std::size_t v) { return kind[v] == 1; });
  for (std::size_t v = 0; v < kind.size(); ++v) field.phi[v] = 0.5f * (field.phi[v] - d_in[v]);
  return field;
}

}  // namespace mv
