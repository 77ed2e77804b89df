// SPDX-License-Identifier: BSD-3-Clause
#include "solver/contact/near_pairs.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/core/parallel.h"

namespace mv {

void NearPairs::update(const ContactSurface& surface, const CandidateSearch& search, std::span<const contact::FacetHead> heads, std::span<const double> x,
                       const SightLimits& limits, double skin, double turn) {
  using Vec3 = Eigen::Vector3d;
  found_.resize(std::max(found_.size(), static_cast<std::size_t>(thread_count())));
  for (auto& list : found_) list.clear();
  start_.resize(surface.nodes.size() + 1);
  start_[0] = 0;
  const double highest = std::max(limits.depth, limits.height);
  parallel_ranges(surface.node_count(), [&](std::ptrdiff_t begin, std::ptrdiff_t end, int thread) {
    // Moved here and back: threads would share the cache line of neighbouring vectors.
    std::vector<int> list = std::move(found_[static_cast<std::size_t>(thread)]);
    for (std::ptrdiff_t n = begin; n < end; ++n) {
      const std::size_t before = list.size();
      const Vec3 p = Eigen::Map<const Vec3>(x.data() + 3 * static_cast<std::size_t>(surface.nodes[static_cast<std::size_t>(n)]));
      for (int f : search.triangles_of(static_cast<int>(n))) {
        const contact::FacetHead& head = heads[static_cast<std::size_t>(f)];
        const Vec3 d = p - head.centre;
        const double squared = d.squaredNorm();
        const double height = head.n.dot(d);
        // d changes by at most skin, height and lateral distance by at most skin + turn |d|, the triangle's size by at most skin.
        const double change = skin + turn * std::sqrt(squared);
        if (height < -limits.depth - change || height > limits.height + change) continue;
        const double far = head.size + skin + limits.widening * std::min(std::abs(height) + change, highest) + change;
        if (squared - height * height > 1.001 * far * far) continue;
        list.push_back(f);
      }
      start_[static_cast<std::size_t>(n) + 1] = static_cast<int>(list.size() - before);
    }
    found_[static_cast<std::size_t>(thread)] = std::move(list);
  });
  for (std::size_t n = 0; n < surface.nodes.size(); ++n) start_[n + 1] += start_[n];
  triangle_.resize(static_cast<std::size_t>(start_.back()));
  auto out = triangle_.begin();
  for (const auto& list : found_) out = std::copy(list.begin(), list.end(), out);
}

}  // namespace mv
