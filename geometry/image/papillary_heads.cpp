// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/image/papillary_heads.h"

#include <algorithm>
#include <numeric>

namespace mv {
namespace {

constexpr double small_group_share = 0.1;  // of the largest group of a muscle's voxels

struct Cloud {
  std::vector<Vec3> points;
  std::vector<std::vector<int>> neighbours;  // 26
};

Cloud voxels_of(const LabelImage& image, Part part) {
  Cloud cloud;
  std::vector<int> number(image.values.size(), -1);
  std::vector<std::array<int, 3>> places;
  for (int k = 0; k < image.size[2]; ++k)
    for (int j = 0; j < image.size[1]; ++j)
      for (int i = 0; i < image.size[0]; ++i) {
        if (image.at(i, j, k) != static_cast<std::int32_t>(part)) continue;
        number[image.index(i, j, k)] = static_cast<int>(places.size());
        places.push_back({i, j, k});
        cloud.points.push_back(image.world(i, j, k));
      }
  cloud.neighbours.resize(places.size());
  for (std::size_t p = 0; p < places.size(); ++p)
    for (int n = 0; n < 27; ++n) {
      const int i = places[p][0] + n % 3 - 1, j = places[p][1] + n / 3 % 3 - 1, k = places[p][2] + n / 9 - 1;
      if (n == 13 || i < 0 || j < 0 || k < 0 || i >= image.size[0] || j >= image.size[1] || k >= image.size[2]) continue;
      if (const int q = number[image.index(i, j, k)]; q >= 0) cloud.neighbours[p].push_back(q);
    }
  return cloud;
}

std::vector<std::vector<int>> groups_of(const Cloud& cloud) {
  std::vector<std::vector<int>> groups;
  std::vector<char> is_seen(cloud.points.size(), 0);
  std::size_t largest = 0;
  for (std::size_t p = 0; p < cloud.points.size(); ++p) {
    if (is_seen[p]) continue;
    std::vector<int> group{static_cast<int>(p)};
    is_seen[p] = 1;
    for (std::size_t n = 0; n < group.size(); ++n)
      for (const int q : cloud.neighbours[static_cast<std::size_t>(group[n])])
        if (!is_seen[static_cast<std::size_t>(q)]) {
          is_seen[static_cast<std::size_t>(q)] = 1;
          group.push_back(q);
        }
    largest = std::max(largest, group.size());
    groups.push_back(std::move(group));
  }
  std::erase_if(groups, [&](const auto& g) { return static_cast<double>(g.size()) < small_group_share * static_cast<double>(largest); });
  return groups;
}

int find_top(std::vector<int>& parent, int i) {
  while (parent[static_cast<std::size_t>(i)] != i) i = parent[static_cast<std::size_t>(i)] = parent[static_cast<std::size_t>(parent[static_cast<std::size_t>(i)])];
  return i;
}

/// Floods the group from the top; each basin carries the number of its highest voxel.
void add_heads(const Cloud& cloud, std::vector<int> group, const Vec3& valve, double prominence, double cap, std::vector<PapillaryHead>& heads) {
  Vec3 middle = Vec3::Zero();
  for (const int p : group) middle += cloud.points[static_cast<std::size_t>(p)] / static_cast<double>(group.size());
  const Vec3 up = (valve - middle).normalized();
  std::vector<double> height(cloud.points.size(), 0);
  for (const int p : group) height[static_cast<std::size_t>(p)] = cloud.points[static_cast<std::size_t>(p)].dot(up);
  std::sort(group.begin(), group.end(), [&](int a, int b) {
    return height[static_cast<std::size_t>(a)] != height[static_cast<std::size_t>(b)] ? height[static_cast<std::size_t>(a)] > height[static_cast<std::size_t>(b)] : a < b;
  });
  std::vector<int> parent(cloud.points.size());
  std::iota(parent.begin(), parent.end(), 0);
  std::vector<char> is_flooded(cloud.points.size(), 0);
  const auto is_higher = [&](int a, int b) { return height[static_cast<std::size_t>(a)] > height[static_cast<std::size_t>(b)] || (height[static_cast<std::size_t>(a)] == height[static_cast<std::size_t>(b)] && a < b); };
  std::vector<std::pair<int, double>> tops;  // with prominence
  for (const int p : group) {
    is_flooded[static_cast<std::size_t>(p)] = 1;
    for (const int q : cloud.neighbours[static_cast<std::size_t>(p)]) {
      if (!is_flooded[static_cast<std::size_t>(q)]) continue;
      int high = find_top(parent, p), low = find_top(parent, q);
      if (high == low) continue;
      if (is_higher(low, high)) std::swap(high, low);
      if (const double rise = height[static_cast<std::size_t>(low)] - height[static_cast<std::size_t>(p)]; rise >= prominence) tops.emplace_back(low, rise);
      parent[static_cast<std::size_t>(low)] = high;
    }
  }
  tops.insert(tops.begin(), {group.front(), height[static_cast<std::size_t>(group.front())] - height[static_cast<std::size_t>(group.back())]});
  for (const auto& [top, rise] : tops) {  // the cap: connected voxels around the top that are high enough
    PapillaryHead head{Vec3::Zero(), rise};
    std::vector<int> near{top};
    std::vector<char> is_near(cloud.points.size(), 0);
    is_near[static_cast<std::size_t>(top)] = 1;
    for (std::size_t n = 0; n < near.size(); ++n)
      for (const int q : cloud.neighbours[static_cast<std::size_t>(near[n])])
        if (!is_near[static_cast<std::size_t>(q)] && height[static_cast<std::size_t>(q)] >= height[static_cast<std::size_t>(top)] - cap) {
          is_near[static_cast<std::size_t>(q)] = 1;
          near.push_back(q);
        }
    for (const int p : near) head.tip += cloud.points[static_cast<std::size_t>(p)] / static_cast<double>(near.size());
    heads.push_back(head);
  }
}

}  // namespace

std::vector<PapillaryHead> papillary_heads(const LabelImage& image, Part part, const Vec3& valve, double prominence, double cap) {
  const Cloud cloud = voxels_of(image, part);
  std::vector<PapillaryHead> heads;
  for (const auto& group : groups_of(cloud)) add_heads(cloud, group, valve, prominence, cap, heads);
  return heads;
}

}  // namespace mv
