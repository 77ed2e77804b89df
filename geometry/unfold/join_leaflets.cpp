// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/core/errors.h"
#include "geometry/unfold/ring.h"

namespace mv {
namespace {

/// The bridge at a commissure reaches this share of the border's length down from the annulus, if the edges stay close, and at least the smaller one:
/// commissural tissue is 3 to 8 mm high on an annulus of 107 mm.
constexpr double bridge_share = 0.035, least_bridge_share = 0.015;
/// Weight of the bridge in the fit: it is a guess that should only not tear.
constexpr double bridge_weight = 0.2;
constexpr double most_candidates = 160;  // border points tried as ends of the annulus, each leaflet

std::size_t at(long i) { return static_cast<std::size_t>(i); }
std::string place(const Vec3& x) { return fmt::format("({:.1f}, {:.1f}, {:.1f}) mm", x.x(), x.y(), x.z()); }

double distance_to(const std::vector<Vec3>& curve, const Vec3& p) {
  double nearest = 1e300;
  for (std::size_t i = 0; i < curve.size(); ++i) {
    const Vec3 &a = curve[i], d = curve[(i + 1) % curve.size()] - a;
    const double t = d.squaredNorm() > 0 ? std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0) : 0;
    nearest = std::min(nearest, (a + t * d - p).norm());
  }
  return nearest;
}

struct Border {
  std::vector<int> loop;
  std::vector<double> arc;    // from the first point
  std::vector<double> depth;  // mm below the atrial-most point, or from the annulus curve
  double length = 0;
};

Border border_of(const RawMesh& mesh, const RawLeaflets& raw, const Vec3& down, double highest) {
  Border border;
  border.loop = border_loops(mesh).front();
  for (std::size_t i = 0; i < border.loop.size(); ++i) {
    const Vec3& x = mesh.points[at(border.loop[i])];
    border.arc.push_back(border.length);
    border.length += (mesh.points[at(border.loop[(i + 1) % border.loop.size()])] - x).norm();
    border.depth.push_back(raw.annulus_curve.empty() ? x.dot(down) - highest : distance_to(raw.annulus_curve, x));
  }
  return border;
}

double forward(const Border& b, int from, int to) {
  const double d = b.arc[at(to)] - b.arc[at(from)];
  return d >= 0 ? d : d + b.length;
}

/// Mean depth of the border from one index forwards to another.
double mean_depth(const Border& b, int from, int to) {
  double sum = 0;
  int count = 0;
  const int n = static_cast<int>(b.loop.size());
  for (int i = from;; i = (i + 1) % n) {
    sum += b.depth[at(i)];
    ++count;
    if (i == to) return sum / count;
  }
}

struct Meeting {
  int a, b;
  double score;
};

/// The best pairs of places in which the borders meet, near to each other and near the annulus.
std::vector<Meeting> meetings(const RawMesh& ma, const Border& a, const RawMesh& mb, const Border& b) {
  std::vector<Meeting> all;
  const auto stride = [](const Border& x) { return std::max(1, static_cast<int>(static_cast<double>(x.loop.size()) / most_candidates)); };
  for (int i = 0; i < static_cast<int>(a.loop.size()); i += stride(a))
    for (int j = 0; j < static_cast<int>(b.loop.size()); j += stride(b))
      all.push_back({i, j, (ma.points[at(a.loop[at(i)])] - mb.points[at(b.loop[at(j)])]).norm() + 0.5 * (a.depth[at(i)] + b.depth[at(j)])});
  std::stable_sort(all.begin(), all.end(), [](const Meeting& x, const Meeting& y) { return x.score < y.score; });
  return all;
}

}  // namespace

RawMesh join_leaflets(RawMesh ma, RawMesh mb, const RawLeaflets& raw, double largest_gap, std::vector<std::string>& notes) {
  RawMesh both = ma;
  for (const Vec3& p : mb.points) both.points.push_back(p);
  const auto known = downward(both, raw);
  if (!known && raw.annulus_curve.empty())
    notes.push_back("two separate leaflets without papillary points, annulus curve or direction to the ventricle: the atrium is taken to lie at +z");
  const Vec3 down = known.value_or(-Vec3::UnitZ());
  double highest = 1e300;
  for (const Vec3& p : both.points) highest = std::min(highest, p.dot(down));
  const Border a = border_of(ma, raw, down, highest), b = border_of(mb, raw, down, highest);

  // Two meetings that leave each leaflet at least a fifth of its border as annulus and as free edge.
  const std::vector<Meeting> all = meetings(ma, a, mb, b);
  const auto far_enough = [](const Border& x, int i, int j) {
    const double f = forward(x, i, j) / x.length;
    return f > 0.2 && f < 0.8;
  };
  Meeting first{}, second{};
  double best = 1e300;
  for (std::size_t i = 0; i < all.size() && 2 * all[i].score < best; ++i)
    for (std::size_t j = i + 1; j < all.size() && all[i].score + all[j].score < best; ++j)
      if (far_enough(a, all[i].a, all[j].a) && far_enough(b, all[i].b, all[j].b)) {
        best = all[i].score + all[j].score;
        first = all[i];
        second = all[j];
      }
  if (!(best < 1e300)) throw InputError("leaflets: the two sheets do not meet at two commissures");
  for (const Meeting& m : {first, second}) {
    const Vec3 &x = ma.points[at(a.loop[at(m.a)])], &y = mb.points[at(b.loop[at(m.b)])];
    const double gap = (x - y).norm();
    if (gap > largest_gap)
      throw InputError(fmt::format("leaflets: the annulus ends of the two leaflets are {:.1f} mm apart at the commissure near {}; expected at most {:.1f} "
                                   "mm (patient.commissure_gap). Complete the commissure in the source, or raise the key",
                                   gap, place(0.5 * (x + y)), largest_gap));
    notes.push_back(fmt::format("the leaflets were joined over a gap of {:.1f} mm at the commissure near {}", gap, place(0.5 * (x + y))));
  }

  // The annulus part is the arc that lies nearer to the annulus; each leaflet's runs from `from` forwards to `to`.
  const auto annulus_arc = [](const Border& x, int i, int j) {
    return mean_depth(x, i, j) < mean_depth(x, j, i) ? std::pair<int, int>{i, j} : std::pair<int, int>{j, i};
  };
  const auto arc_a = annulus_arc(a, first.a, second.a);
  auto arc_b = annulus_arc(b, first.b, second.b);
  Border turned = b;
  // In the ring the annulus of b leads back from where that of a ends.
  const bool ends_at_second = arc_a.second == second.a;
  if (arc_b.first != (ends_at_second ? second.b : first.b)) {
    for (auto& t : mb.triangles) std::swap(t[1], t[2]);
    std::reverse(turned.loop.begin(), turned.loop.end());
    std::reverse(turned.depth.begin(), turned.depth.end());
    const int n = static_cast<int>(turned.loop.size());
    const auto mirrored = [&](int i) { return n - 1 - i; };
    arc_b = {mirrored(arc_b.second), mirrored(arc_b.first)};
    turned.arc.clear();
    for (int i = 0; i < n; ++i) turned.arc.push_back(b.arc.back() - b.arc[at(n - 1 - i)]);
  }

  RawMesh out = ma;
  const int shift = static_cast<int>(ma.points.size());
  for (std::size_t i = 0; i < mb.points.size(); ++i) out.add_point(mb.points[i], mb.thickness.empty() ? -1 : mb.thickness[i]);
  for (std::size_t t = 0; t < mb.triangles.size(); ++t) {
    auto tri = mb.triangles[t];
    for (int& v : tri) v += shift;
    out.add_triangle(tri, mb.region[t], mb.weight[t]);
  }
  // A bridge runs down the free edges of both leaflets: forwards on one, backwards on the other.
  const double deepest = bridge_share * (a.length + b.length), least = least_bridge_share * (a.length + b.length);
  const auto bridge = [&](const Border& p, int p_start, int p_offset, const Border& q, int q_start, int q_offset) {
    const int np = static_cast<int>(p.loop.size()), nq = static_cast<int>(q.loop.size());
    const auto pv = [&](int k) { return p.loop[at((p_start + k) % np)] + p_offset; };
    const auto qv = [&](int k) { return q.loop[at(((q_start - k) % nq + nq) % nq)] + q_offset; };
    double sp = 0, sq = 0;
    int i = 0, j = 0;
    while (true) {
      const Vec3 &x = out.points[at(pv(i))], &y = out.points[at(qv(j))], &xn = out.points[at(pv(i + 1))], &yn = out.points[at(qv(j + 1))];
      const double depth = std::min(sp, sq), across = (x - y).norm();
      if (depth >= deepest || (depth >= least && across > largest_gap)) break;
      const bool advance_p = sp <= sq;
      if (advance_p) {
        out.add_triangle({pv(i + 1), pv(i), qv(j)}, 0, bridge_weight);
        sp += (xn - x).norm();
        ++i;
      } else {
        out.add_triangle({pv(i), qv(j), qv(j + 1)}, 0, bridge_weight);
        sq += (yn - y).norm();
        ++j;
      }
    }
  };
  // At the end of a's annulus its free edge starts forwards, where b's annulus starts and its free edge ends.
  bridge(a, arc_a.second, 0, turned, arc_b.first, shift);
  bridge(turned, arc_b.second, shift, a, arc_a.first, 0);
  return out;
}

}  // namespace mv
