// SPDX-License-Identifier: BSD-3-Clause
#include "solver/contact/closest_gaps.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "geometry/core/errors.h"
#include "geometry/core/parallel.h"
#include "solver/contact/box_grid.h"
#include "solver/contact/contact_kernel.h"

namespace mv {
namespace {

using Vec3 = Eigen::Vector3d;

constexpr double infinity = std::numeric_limits<double>::infinity();

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
  std::vector<int> masters;
  for (int f = 0; f < triangles; ++f) {
    if (!atrial_only || s.triangle_side[f] > 0) masters.push_back(f);
  }
  if (masters.empty()) return;
  const int count = static_cast<int>(masters.size());
  std::vector<contact::FacetHead> unsorted(masters.size()), heads(masters.size());
  parallel_for(count, [&](std::ptrdiff_t m) { unsorted[m] = head_of(masters[m]); });
  std::vector<Vec3> normals(s.nodes.size());
  current_node_normals(s, x, normals);
  Vec3 lower = unsorted[0].centre, upper = lower;
  double size_max = 0, checksum = 0;
  for (const auto& head : unsorted) {
    lower = lower.cwiseMin(head.centre);
    upper = upper.cwiseMax(head.centre);
    size_max = std::max(size_max, head.size);
    checksum += head.centre.sum() + head.size;
  }
  if (!std::isfinite(checksum)) throw TrustError("contact: positions are not finite; the run has diverged");
  BoxGrid grid;
  grid.reset(lower, upper, std::max(1.5 * s.mean_edge, 0.125 * (max_distance + size_max)));
  grid.sort(count, [&](int m) { return grid.cell_index(grid.cell(unsorted[m].centre)); });
  parallel_for(count, [&](std::ptrdiff_t k) { heads[k] = unsorted[grid.item(static_cast<int>(k))]; });
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
      if (f >= 0 && f < triangles && (!atrial_only || s.triangle_side[f] > 0)) measure(f, head_of(f));
    };
    if (!guesses.empty()) try_guess(guesses[n]);
    if (last.size() == s.nodes.size()) try_guess(last[n]);
    const auto visit = [&](int k) {
      const contact::FacetHead& head = heads[k];
      const double within = best_distance + head.size;
      if ((p - head.centre).squaredNorm() <= 1.0001 * within * within) measure(masters[grid.item(k)], head);
    };
    // Shells of cells around the node's own until nothing closer can follow.
    const auto home = grid.cell(p);
    const int rings = static_cast<int>((max_distance + size_max) / grid.cell_size()) + 1;
    for (int ring = 0; ring <= rings; ++ring) {
      if (ring > 1 && (ring - 1) * grid.cell_size() > best_distance + size_max) break;
      std::array<int, 3> low, high;
      for (int k = 0; k < 3; ++k) {
        low[k] = std::max(home[k] - ring, 0);
        high[k] = std::min(home[k] + ring, grid.size()[k] - 1);
      }
      for (int k = low[2]; k <= high[2]; ++k) {
        for (int j = low[1]; j <= high[1]; ++j) {
          const bool shell = std::abs(k - home[2]) == ring || std::abs(j - home[1]) == ring;
          const auto run = [&](int from, int to) {
            if (from > to) return;
            grid.for_runs({from, j, k}, {to, j, k}, [&](int first, int end) {
              for (int q = first; q < end; ++q) visit(q);
            });
          };
          if (shell) {
            run(low[0], high[0]);
          } else {
            if (home[0] - ring >= 0) run(home[0] - ring, home[0] - ring);
            if (ring > 0 && home[0] + ring < grid.size()[0]) run(home[0] + ring, home[0] + ring);
          }
        }
      }
    }
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
