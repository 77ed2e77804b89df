// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "geometry/image/distance_map.h"
#include "geometry/image/mask_field.h"

namespace mv {
namespace {

struct Box {
  std::array<int, 3> low{1 << 30, 1 << 30, 1 << 30}, high{-1, -1, -1};
  void add(const std::array<int, 3>& x) {
    for (std::size_t a = 0; a < 3; ++a) low[a] = std::min(low[a], x[a]), high[a] = std::max(high[a], x[a]);
  }
};

std::size_t index(const Mask& mask, int i, int j, int k) {
  return (static_cast<std::size_t>(k) * static_cast<std::size_t>(mask.size[1]) + static_cast<std::size_t>(j)) * static_cast<std::size_t>(mask.size[0]) + static_cast<std::size_t>(i);
}

/// Corners - edges + faces - cubes of the voxels as closed cubes, counted over the lattice points of the box and one beyond it. Every lattice point stands for
/// a corner and the edges, faces and the cube that begin there.
long euler_characteristic(const Mask& mask, const Box& box) {
  long sum = 0;
  for (int k = box.low[2]; k <= box.high[2] + 1; ++k)
    for (int j = box.low[1]; j <= box.high[1] + 1; ++j)
      for (int i = box.low[0]; i <= box.high[0] + 1; ++i)
        for (int cell = 0; cell < 8; ++cell) {  // bit a: the cell extends along axis a
          bool is_there = false;
          for (int n = 0; n < 8 && !is_there; ++n) {
            if ((n & cell) != 0) continue;  // voxels on both sides only across axes along which the cell does not extend
            is_there = mask.inside[index(mask, i - (n & 1), j - (n >> 1 & 1), k - (n >> 2 & 1))] != 0;
          }
          if (is_there) sum += (((cell & 1) + (cell >> 1 & 1) + (cell >> 2 & 1)) % 2 == 0) ? 1 : -1;
        }
  return sum;
}

/// Voxels that dilation and erosion by a ball add.
std::vector<char> closing(const Mask& mask, double radius) {
  const Vec3 voxels = Vec3::Ones();
  const auto to_mask = distance_map(mask.size, voxels, [&](std::size_t v) { return mask.inside[v] != 0; });
  const auto to_rest = distance_map(mask.size, voxels, [&](std::size_t v) { return to_mask[v] > radius; });
  std::vector<char> added(mask.inside.size());
  for (std::size_t v = 0; v < added.size(); ++v) added[v] = mask.inside[v] == 0 && to_rest[v] > radius;
  return added;
}

bool is_interior(const Mask& mask, const std::array<int, 3>& x) {
  for (std::size_t a = 0; a < 3; ++a)
    if (x[a] < 2 || x[a] + 2 >= mask.size[a]) return false;
  return true;
}

}  // namespace

int fill_holes(Mask& mask, double radius, long* set) {
  if (set != nullptr) *set = 0;
  if (radius <= 0) return 0;
  std::vector<char> added = closing(mask, radius);
  int holes = 0;
  for (int k = 2; k + 2 < mask.size[2]; ++k)
    for (int j = 2; j + 2 < mask.size[1]; ++j)
      for (int i = 2; i + 2 < mask.size[0]; ++i) {
        if (!added[index(mask, i, j, k)]) continue;
        std::vector<std::array<int, 3>> group{{i, j, k}};
        Box box;
        added[index(mask, i, j, k)] = 0;
        for (std::size_t g = 0; g < group.size(); ++g) {
          box.add(group[g]);
          for (int n = 0; n < 27; ++n) {
            const std::array<int, 3> x{group[g][0] + n % 3 - 1, group[g][1] + n / 3 % 3 - 1, group[g][2] + n / 9 - 1};
            if (!is_interior(mask, x) || !added[index(mask, x[0], x[1], x[2])]) continue;
            added[index(mask, x[0], x[1], x[2])] = 0;
            group.push_back(x);
          }
        }
        const long before = euler_characteristic(mask, box);
        for (const auto& x : group) mask.inside[index(mask, x[0], x[1], x[2])] = 1;
        const long gained = euler_characteristic(mask, box) - before;
        if (gained > 0) {
          holes += static_cast<int>(gained);
          if (set != nullptr) *set += static_cast<long>(group.size());
        } else {
          for (const auto& x : group) mask.inside[index(mask, x[0], x[1], x[2])] = 0;
        }
      }
  return holes;
}

}  // namespace mv
