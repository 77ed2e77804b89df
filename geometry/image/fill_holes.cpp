// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <queue>

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

/// Whether taking the middle of a 3 x 3 x 3 neighbourhood out of the object leaves its topology as it is, objects connected by 26, background by 6 neighbours
/// (Bertrand and Malandain 1994): one group of object voxels around it, and one group of background voxels, within the 18 neighbours,
/// that touches its faces.
bool is_simple(const std::array<char, 27>& around) {
  const auto place = [](int n) { return std::array<int, 3>{n % 3, n / 3 % 3, n / 9}; };
  const auto groups = [&](bool of_object) {
    std::array<char, 27> is_seen{};
    int count = 0;
    for (int first = 0; first < 27; ++first) {
      const auto f = place(first);
      const int off = (f[0] != 1) + (f[1] != 1) + (f[2] != 1);
      if (first == 13 || is_seen[static_cast<std::size_t>(first)] || (around[static_cast<std::size_t>(first)] != 0) != of_object || (!of_object && off != 1)) continue;
      ++count;
      std::array<int, 27> open{first};
      is_seen[static_cast<std::size_t>(first)] = 1;
      for (int at = 0, end = 1; at < end; ++at) {
        const auto x = place(open[static_cast<std::size_t>(at)]);
        for (int next = 0; next < 27; ++next) {
          const auto y = place(next);
          const int apart = std::abs(x[0] - y[0]) + std::abs(x[1] - y[1]) + std::abs(x[2] - y[2]);
          const bool is_near = of_object ? std::max({std::abs(x[0] - y[0]), std::abs(x[1] - y[1]), std::abs(x[2] - y[2])}) == 1 : apart == 1;
          const bool is_corner = y[0] != 1 && y[1] != 1 && y[2] != 1;
          if (!is_near || next == 13 || is_seen[static_cast<std::size_t>(next)] || (around[static_cast<std::size_t>(next)] != 0) != of_object || (!of_object && is_corner)) continue;
          is_seen[static_cast<std::size_t>(next)] = 1;
          open[static_cast<std::size_t>(end++)] = next;
        }
      }
    }
    return count;
  };
  return groups(true) == 1 && groups(false) == 1;
}

/// Place of a voxel in the order of thinning: farthest from the mask first, then fewest faces on it (a voxel in a hole of a sheet has more of them than one in a gap
/// beside the sheet), then first come.
struct Place {
  float distance;
  int faces;
  std::size_t turn, voxel;
  bool operator<(const Place& o) const {  // std::priority_queue takes the greatest first
    if (distance != o.distance) return distance < o.distance;
    if (faces != o.faces) return faces > o.faces;
    return turn > o.turn;
  }
};

/// The mask grown by `radius`, then thinned in that order, each voxel again when a neighbour went, without changing its topology and without touching the mask: what is
/// left over are patches one voxel thick across holes narrower than twice the radius (hole closing, Aktouf, Bertrand, Perroton 2002), and bridges
/// across gaps. Returns these voxels.
std::vector<char> patches(const Mask& mask, double radius) {
  const auto distance = distance_map(mask.size, Vec3::Ones(), [&](std::size_t v) { return mask.inside[v] != 0; });
  const std::size_t nx = static_cast<std::size_t>(mask.size[0]), nxy = nx * static_cast<std::size_t>(mask.size[1]);
  const auto beside = [&](std::size_t v, std::size_t n) { return v + n % 3 + n / 3 % 3 * nx + n / 9 * nxy - 1 - nx - nxy; };
  std::vector<char> grown(distance.size()), is_waiting(distance.size());
  std::priority_queue<Place> queue;
  std::size_t turn = 0;
  const auto add = [&](std::size_t v) {
    if (!grown[v] || distance[v] <= 0 || is_waiting[v]) return;
    is_waiting[v] = 1;
    int faces = 0;
    for (const std::size_t step : {std::size_t{1}, nx, nxy}) faces += (mask.inside[v - step] != 0) + (mask.inside[v + step] != 0);
    queue.push({distance[v], faces, turn++, v});
  };
  for (std::size_t v = 0; v < distance.size(); ++v) grown[v] = distance[v] <= radius;
  for (std::size_t v = 0; v < distance.size(); ++v) add(v);
  while (!queue.empty()) {
    const std::size_t v = queue.top().voxel;
    queue.pop();
    is_waiting[v] = 0;
    std::array<char, 27> around;
    for (std::size_t n = 0; n < 27; ++n) around[n] = grown[beside(v, n)];
    if (!is_simple(around)) continue;
    grown[v] = 0;
    for (std::size_t n = 0; n < 27; ++n) add(beside(v, n));
  }
  for (std::size_t v = 0; v < grown.size(); ++v) grown[v] = grown[v] != 0 && mask.inside[v] == 0;
  return grown;
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
  radius = std::min(radius, Mask::margin_voxels - 1.0);  // or the grown mask would reach the border
  std::vector<char> added = patches(mask, radius);
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
