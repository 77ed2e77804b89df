// SPDX-License-Identifier: BSD-3-Clause
#include "solver/contact/near_pairs.h"

#include <algorithm>
#include <cmath>

#include "solver/contact/node_lists.h"

namespace mv {

void NearPairs::update(const ContactSurface& surface, const CandidateSearch& search, std::span<const contact::FacetHead> heads, std::span<const double> x,
                       const SightLimits& limits, double skin, double turn) {
  using Vec3 = Eigen::Vector3d;
  const double highest = std::max(limits.depth, limits.height);
  fill_node_lists(surface.node_count(), found_, start_, triangle_, [&](int n, std::vector<int>& list) {
    const Vec3 p = Eigen::Map<const Vec3>(x.data() + 3 * static_cast<std::size_t>(surface.nodes[static_cast<std::size_t>(n)]));
    for (int f : search.triangles_of(n)) {
      const contact::FacetHead& head = heads[static_cast<std::size_t>(f)];
      const Vec3 d = p - head.centre;
      const double squared = d.squaredNorm();
      const double height = head.n.dot(d);
      // d changes by at most skin, height and lateral distance by at most skin + turn |d|, the triangle's size by at most skin.
      const double change = skin + turn * std::sqrt(squared);
      const double far = head.size + skin + limits.widening * std::min(std::abs(height) + change, highest) + change;
      if ((height < -limits.depth - change) | (height > limits.height + change) | (squared - height * height > 1.001 * far * far)) continue;
      list.push_back(f);
    }
  });
}

}  // namespace mv
