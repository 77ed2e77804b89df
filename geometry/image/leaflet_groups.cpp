// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/image/leaflet_groups.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>

namespace mv {
namespace {

constexpr double smallest_share = 0.15;  // of the largest group, without contact to a wall

cv::Mat matrix_of(const Slice& slice, const PixelMask& mask) {
  cv::Mat m = cv::Mat::zeros(slice.height, slice.width, CV_8U);
  for (int j = 0; j < slice.height; ++j)
    for (int i = 0; i < slice.width; ++i) m.at<std::uint8_t>(j, i) = mask[static_cast<std::size_t>(j * slice.width + i)] ? 255 : 0;
  return m;
}


/// Pixels per component of an 8-connected labelling.
std::vector<std::vector<int>> components_of(const cv::Mat& m) {
  cv::Mat labels;
  const int n = cv::connectedComponents(m, labels, 8, CV_32S);
  std::vector<std::vector<int>> components(static_cast<std::size_t>(std::max(0, n - 1)));
  for (int j = 0; j < m.rows; ++j)
    for (int i = 0; i < m.cols; ++i)
      if (labels.at<int>(j, i) > 0) components[static_cast<std::size_t>(labels.at<int>(j, i) - 1)].push_back(j * m.cols + i);
  return components;
}

/// Closest pair of pixels of two components, and its distance in mm.
struct Bridge {
  double gap = HUGE_VAL;
  std::size_t a = 0, b = 0;
  int from = 0, to = 0;
};

Bridge closest(const Slice& slice, const std::vector<int>& a, const std::vector<int>& b) {
  Bridge best;
  const double sx = slice.step_x.norm(), sy = slice.step_y.norm();
  for (const int p : a)
    for (const int q : b) {
      const double dx = sx * (p % slice.width - q % slice.width), dy = sy * (p / slice.width - q / slice.width);
      const double gap = std::hypot(dx, dy);
      if (gap < best.gap) best.gap = gap, best.from = p, best.to = q;
    }
  return best;
}

/// Only pixels with a neighbour outside: distances between components need no others.
std::vector<int> rim_of(const std::vector<int>& component, const cv::Mat& m) {
  std::vector<int> rim;
  for (const int p : component) {
    const int i = p % m.cols, j = p / m.cols;
    const auto is_out = [&](int k, int l) { return k < 0 || l < 0 || k >= m.cols || l >= m.rows || m.at<std::uint8_t>(l, k) == 0; };
    if (is_out(i - 1, j) || is_out(i + 1, j) || is_out(i, j - 1) || is_out(i, j + 1)) rim.push_back(p);
  }
  return rim;
}

void fill_bubbles(cv::Mat& m, double largest_pixels) {
  cv::Mat outside = m == 0, labels, stats, centers;
  const int n = cv::connectedComponentsWithStats(outside, labels, stats, centers, 4, CV_32S);
  for (int k = 1; k < n; ++k) {
    const int x = stats.at<int>(k, cv::CC_STAT_LEFT), y = stats.at<int>(k, cv::CC_STAT_TOP);
    const bool at_border = x == 0 || y == 0 || x + stats.at<int>(k, cv::CC_STAT_WIDTH) == m.cols || y + stats.at<int>(k, cv::CC_STAT_HEIGHT) == m.rows;
    if (!at_border && stats.at<int>(k, cv::CC_STAT_AREA) <= largest_pixels) m.setTo(255, labels == k);
  }
}

std::size_t root_of(std::vector<std::size_t>& parent, std::size_t k) {
  while (parent[k] != k) k = parent[k] = parent[parent[k]];
  return k;
}

}  // namespace

PixelMask mask_of(const Slice& slice, SlicePart part) {
  PixelMask mask;
  for (const std::uint8_t p : slice.parts) mask.push_back(static_cast<SlicePart>(p) == part ? 1 : 0);
  return mask;
}

std::vector<float> distance_to_mask(const Slice& slice, const PixelMask& mask) {
  std::vector<float> result(mask.size(), 1e6F);
  if (std::none_of(mask.begin(), mask.end(), [](std::uint8_t x) { return x != 0; })) return result;
  const cv::Mat outside = matrix_of(slice, mask) == 0;
  cv::Mat distance;
  cv::distanceTransform(outside, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  for (int j = 0; j < slice.height; ++j)
    for (int i = 0; i < slice.width; ++i) result[static_cast<std::size_t>(j * slice.width + i)] = distance.at<float>(j, i);
  return result;
}

std::vector<PixelMask> leaflet_groups(const Slice& slice, const PixelMask& mask, const PixelMask& is_contact, const SliceCurveOptions& options,
                                      const std::string& name, std::vector<std::string>& notes) {
  cv::Mat m = matrix_of(slice, mask);
  const auto parts = components_of(m);
  if (parts.empty()) return {};
  std::vector<std::vector<int>> rims;
  std::vector<char> has_contact;
  for (const auto& part : parts) {
    rims.push_back(rim_of(part, m));
    has_contact.push_back(std::any_of(part.begin(), part.end(), [&](int p) { return is_contact[static_cast<std::size_t>(p)] != 0; }));
  }
  std::vector<Bridge> bridges;
  for (std::size_t a = 0; a < parts.size(); ++a)
    for (std::size_t b = a + 1; b < parts.size(); ++b) {
      Bridge bridge = closest(slice, rims[a], rims[b]);
      bridge.a = a, bridge.b = b;
      if (bridge.gap <= options.bridge_gap + slice.step_x.norm()) bridges.push_back(bridge);  // distance of centres of pixels that touch: one pixel
    }
  std::sort(bridges.begin(), bridges.end(), [](const Bridge& x, const Bridge& y) { return x.gap < y.gap; });
  std::vector<std::size_t> parent(parts.size());
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  int bridged = 0;
  for (const Bridge& bridge : bridges) {
    const std::size_t a = root_of(parent, bridge.a), b = root_of(parent, bridge.b);
    if (a == b || (has_contact[a] && has_contact[b])) continue;
    parent[b] = a;
    has_contact[a] = static_cast<char>(has_contact[a] || has_contact[b]);
    cv::line(m, {bridge.from % slice.width, bridge.from / slice.width}, {bridge.to % slice.width, bridge.to / slice.width}, 255, 1);
    ++bridged;
  }
  const double pixel = slice.step_x.norm() * slice.step_y.norm();
  fill_bubbles(m, options.bridge_gap * options.bridge_gap / pixel);
  auto groups = components_of(m);
  std::sort(groups.begin(), groups.end(), [](const auto& x, const auto& y) { return x.size() > y.size(); });
  std::vector<PixelMask> result;
  std::size_t islands = 0, island_pixels = 0;
  for (const auto& group : groups) {
    const bool touches = std::any_of(group.begin(), group.end(), [&](int p) { return is_contact[static_cast<std::size_t>(p)] != 0; });
    const bool is_small = static_cast<double>(group.size()) * pixel < options.island_area ||
                          (!touches && static_cast<double>(group.size()) < smallest_share * static_cast<double>(groups.front().size()));
    if (is_small) {
      ++islands, island_pixels += group.size();
      continue;
    }
    PixelMask one(mask.size(), 0);
    for (const int p : group) one[static_cast<std::size_t>(p)] = 1;
    result.push_back(one);
  }
  if (bridged > 0) notes.push_back(fmt::format("{}: {} gap{} closed", name, bridged, bridged > 1 ? "s" : ""));
  if (islands > 0) notes.push_back(fmt::format("{}: {} island{} of {} pixels left out", name, islands, islands > 1 ? "s" : "", island_pixels));
  return result;
}

std::vector<std::vector<int>> contact_clusters(const Slice& slice, const PixelMask& contact) {
  cv::Mat wide;
  cv::dilate(matrix_of(slice, contact), wide, cv::Mat::ones(3, 3, CV_8U));
  auto clusters = components_of(wide);
  for (auto& cluster : clusters) std::erase_if(cluster, [&](int p) { return contact[static_cast<std::size_t>(p)] == 0; });
  std::sort(clusters.begin(), clusters.end(), [](const auto& x, const auto& y) { return x.size() > y.size(); });
  return clusters;
}

}  // namespace mv
