// SPDX-License-Identifier: BSD-3-Clause
#include "solver/contact/closest_gaps.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "geometry/core/errors.h"
#include "geometry/core/parallel.h"
#include "solver/contact/box_tree.h"
#include "solver/contact/contact_kernel.h"
#include "solver/contact/leaf_heads.h"

namespace mv {
namespace {

using Vec3 = Eigen::Vector3d;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr float infinity_f = std::numeric_limits<float>::infinity();

Vec3 at(std::span<const double> x, int node) { return Eigen::Map<const Vec3>(x.data() + 3 * static_cast<std::size_t>(node)); }

}  // namespace

void closest_gaps(const ContactSurface& s, const CandidateSearch& rule, std::span<const double> x, const GapQuery& query,
                  std::span<const int> guesses, ClosestGaps& out) {
  const double max_distance = query.max_distance, penetration_limit = query.penetration_limit;
  const bool atrial_only = query.atrial_only;
  const int nodes = s.node_count(), triangles = s.triangle_count();
  const std::vector<int> last = out.triangle;
  out.gap.assign(s.nodes.size(), infinity);
  out.point.assign(s.nodes.size(), Vec3::Zero());
  out.triangle.assign(s.nodes.size(), -1);
  const auto head_of = [&](int f) {
    const auto& t = s.triangles[f];
    return contact::make_head(at(x, s.nodes[t[0]]), at(x, s.nodes[t[1]]), at(x, s.nodes[t[2]]));
  };
  std::vector<contact::FacetHead> heads(s.triangles.size());
  parallel_for(triangles, [&](std::ptrdiff_t f) { heads[f] = head_of(static_cast<int>(f)); });
  std::vector<Vec3> normals(s.nodes.size());
  current_node_normals(s, x, normals);
  double largest = 0, checksum = 0;
  for (const auto& head : heads) {
    largest = std::max(largest, head.centre.cwiseAbs().maxCoeff());
    checksum += head.centre.sum() + head.size;
  }
  if (!std::isfinite(checksum)) throw TrustError("contact: positions are not finite; the run has diverged");
  const auto is_master = [&](int f) { return !atrial_only || s.triangle_side[f] > 0; };
  const float margin = static_cast<float>(2e-6 * largest);  // single precision
  BoxTree tree = rule.tree();
  tree.fit([&](int f) {
    const Eigen::Array3f c = heads[f].centre.cast<float>().array();
    const float r = is_master(f) ? static_cast<float>(heads[f].size) + margin : -infinity_f;
    return BoxTree::Box{c - r, c + r};
  });
  std::vector<LeafHeads> leaves;
  gather_leaf_heads(tree, [&](int f) { return is_master(f) ? &heads[f] : nullptr; }, leaves);
  const auto find = [&](std::ptrdiff_t n) {
    if (atrial_only && !s.on_atrial_face[n]) return;
    const Vec3 p = at(x, s.nodes[n]);
    const Vec3 node_normal = normals[n];
    double best = max_distance * max_distance, best_distance = max_distance;
    int best_triangle = -1;
    Vec3 best_point = Vec3::Zero();
    double best_height = 0;
    const auto measure = [&](int f, const contact::FacetHead& head) {
      if (!(head.n.dot(node_normal) < facing_cosine)) return;
      const auto& t = s.triangles[f];
      const contact::Facet facet =
          contact::make_facet(at(x, s.nodes[t[0]]), at(x, s.nodes[t[1]]), at(x, s.nodes[t[2]]), head.area2);
      const Vec3 d = p - facet.a;
      const double height = head.n.dot(d);
      if (!(height > -penetration_limit)) return;
      const auto q = contact::project(facet, d);
      const double squared = q.lateral_squared + height * height;
      if (squared > best || (squared == best && best_triangle >= 0 && f > best_triangle)) return;
      if (rule.is_excluded(static_cast<int>(n), f)) return;
      best = squared;
      best_distance = std::sqrt(best);
      best_triangle = f;
      best_point = facet.a + q.b1 * facet.e1 + q.b2 * facet.e2;
      best_height = height;
    };
    const auto try_guess = [&](int f) {
      if (f >= 0 && f < triangles && is_master(f)) measure(f, heads[f]);
    };
    if (!guesses.empty()) try_guess(guesses[n]);
    if (last.size() == s.nodes.size()) try_guess(last[n]);
    const Eigen::Vector3f pf = p.cast<float>(), nf = node_normal.cast<float>();
    const float deepest = -static_cast<float>(penetration_limit) - margin;
    const auto look = [&](int leaf) {
      const LeafHeads& l = leaves[static_cast<std::size_t>(leaf)];
      const auto eight = [](const std::array<float, BoxTree::width>& a) { return load_floats(a.data()); };
      const Floats dx = pf[0] - eight(l.centre[0]), dy = pf[1] - eight(l.centre[1]), dz = pf[2] - eight(l.centre[2]);
      const Floats nx = eight(l.normal[0]), ny = eight(l.normal[1]), nz = eight(l.normal[2]);
      const Floats within = eight(l.size) + (static_cast<float>(1.0001 * best_distance) + margin);
      unsigned seen = bits((within > 0) & (dx * dx + dy * dy + dz * dz <= within * within) &
                           (nx * nf[0] + ny * nf[1] + nz * nf[2] < static_cast<float>(facing_cosine) + 1e-5F) & (nx * dx + ny * dy + nz * dz > deepest));
      for (; seen != 0; seen &= seen - 1) {
        const int f = tree.item(leaf * BoxTree::width + __builtin_ctz(seen));
        measure(f, heads[f]);
      }
    };
    const float reach = static_cast<float>(1.0001 * best_distance) + margin;
    tree.for_leaves({pf.array() - reach, pf.array() + reach}, 0, look);
    if (best_triangle < 0) return;
    out.triangle[n] = best_triangle;
    out.point[n] = best_point;
    out.gap[n] = best_height < 0 ? -best_distance : best_distance;
  };
  parallel_pieces(nodes, 64, [&](std::ptrdiff_t begin, std::ptrdiff_t end, int) {
    for (std::ptrdiff_t n = begin; n < end; ++n) find(n);
  });
}

}  // namespace mv
