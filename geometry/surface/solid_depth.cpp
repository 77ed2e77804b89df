// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/surface/solid_depth.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "geometry/core/errors.h"
#include "geometry/core/parallel.h"

namespace mv {
namespace {

std::size_t at(long i) { return static_cast<std::size_t>(i); }
constexpr double smallest_fraction = 1e-3;  // of a voxel, so that a node on the surface does not divide by zero
constexpr double rim_from = 0.05, rim_to = 0.95;  // depth on the surface between which it is rim
constexpr double residual_reduction = 1e-8;

/// Twice the signed area of (a, b, p) in the plane, the same number whichever triangle asks; zero counts as positive.
double edge_side(const std::vector<Vec3>& x, int a, int b, int u, int v, double pu, double pv) {
  const bool swapped = a > b;
  if (swapped) std::swap(a, b);
  const Vec3 &p = x[at(a)], &q = x[at(b)];
  double side = (q[u] - p[u]) * (pv - p[v]) - (q[v] - p[v]) * (pu - p[u]);
  if (side == 0) side = 1e-300;
  return swapped ? -side : side;
}

}  // namespace

SolidDepth::SolidDepth(const SolidFaces& faces, double volume, double voxel, long max_voxels) {
  h_ = std::max(voxel, std::cbrt(volume / static_cast<double>(max_voxels)));
  Eigen::AlignedBox3d box;
  for (const Vec3& p : faces.points) box.extend(p);
  constexpr int margin = 4;
  // The shift keeps grid lines off the corners of surfaces made on round numbers.
  lower_ = box.min() - (margin + 0.3819660113) * Vec3::Constant(h_) + h_ * Vec3(0.0137, 0.0071, 0.0193);
  for (int a = 0; a < 3; ++a) {
    cells_[at(a)] = static_cast<int>(std::ceil(box.sizes()[a] / h_)) + 2 * margin + 2;
    blocks_[at(a)] = (cells_[at(a)] + 7) / 8;
  }
  block_.assign(at(blocks_[0]) * at(blocks_[1]) * at(blocks_[2]), -1);
  collect_crossings(faces);
  mark_inside();
  if (inside_count_ == 0) throw InputError("surface: thinner than the depth grid everywhere; expected leaflets with a thickness");
  link_nodes();
  solve();
  extrapolate();
  for (auto& axis : lines_) axis.clear();
}

int SolidDepth::node_at(const Index& i) const {
  for (std::size_t a = 0; a < 3; ++a)
    if (i[a] < 0 || i[a] >= cells_[a]) return -1;
  const int block = block_[(at(i[2] / 8) * at(blocks_[1]) + at(i[1] / 8)) * at(blocks_[0]) + at(i[0] / 8)];
  return block < 0 ? -1 : slots_[at(block)][at(((i[2] % 8) * 8 + i[1] % 8) * 8 + i[0] % 8)];
}

int SolidDepth::add_node(const Index& i) {
  int& block = block_[(at(i[2] / 8) * at(blocks_[1]) + at(i[1] / 8)) * at(blocks_[0]) + at(i[0] / 8)];
  if (block < 0) {
    block = static_cast<int>(slots_.size());
    slots_.emplace_back().fill(-1);
  }
  int& slot = slots_[at(block)][at(((i[2] % 8) * 8 + i[1] % 8) * 8 + i[0] % 8)];
  if (slot < 0) slot = static_cast<int>(nodes_.size()), nodes_.push_back(i);
  return slot;
}

void SolidDepth::collect_crossings(const SolidFaces& f) {
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    auto& lines = lines_[at(axis)];
    lines.assign(at(cells_[at(u)]) * at(cells_[at(v)]), {});
    for (const auto& t : f.triangles) {
      const Vec3 &a = f.points[at(t[0])], &b = f.points[at(t[1])], &c = f.points[at(t[2])];
      const auto range = [&](int k) {
        const double low = std::min({a[k], b[k], c[k]}), high = std::max({a[k], b[k], c[k]});
        return std::pair(static_cast<int>(std::ceil((low - lower_[k]) / h_)), static_cast<int>(std::floor((high - lower_[k]) / h_)));
      };
      const auto [u0, u1] = range(u);
      const auto [v0, v1] = range(v);
      for (int j = v0; j <= v1; ++j)
        for (int i = u0; i <= u1; ++i) {
          const double pu = lower_[u] + h_ * i, pv = lower_[v] + h_ * j;
          const double wa = edge_side(f.points, t[1], t[2], u, v, pu, pv), wb = edge_side(f.points, t[2], t[0], u, v, pu, pv),
                       wc = edge_side(f.points, t[0], t[1], u, v, pu, pv);
          if (!((wa > 0) == (wb > 0) && (wb > 0) == (wc > 0))) continue;
          const double sum = wa + wb + wc;
          const double s = (wa * f.colour[at(t[0])] + wb * f.colour[at(t[1])] + wc * f.colour[at(t[2])]) / sum;
          const double where = (wa * a[axis] + wb * b[axis] + wc * c[axis]) / sum;
          // An outward normal against the axis means that the line enters.
          lines[at(j) * at(cells_[at(u)]) + at(i)].push_back({(where - lower_[axis]) / h_, 0.5 * (1 + s), sum > 0 ? -1 : 1});
        }
    }
    for (auto& line : lines)
      std::sort(line.begin(), line.end(), [](const Crossing& p, const Crossing& q) { return p.position < q.position; });
  }
}

void SolidDepth::mark_inside() {
  for (int k = 0; k < cells_[2]; ++k)
    for (int j = 0; j < cells_[1]; ++j) {
      const auto& line = lines_[0][at(k) * at(cells_[1]) + at(j)];
      int winding = 0;
      for (std::size_t c = 0; c + 1 < line.size(); ++c) {
        winding += line[c].step;
        if (winding <= 0) continue;
        for (int i = static_cast<int>(std::floor(line[c].position)) + 1; i <= line[c + 1].position; ++i) add_node({i, j, k});
      }
    }
  inside_count_ = static_cast<int>(nodes_.size());
}

void SolidDepth::link_nodes() {
  links_.resize(at(inside_count_));
  parallel_for(inside_count_, [&](std::ptrdiff_t n) {
    const Index& i = nodes_[at(n)];
    for (int axis = 0; axis < 3; ++axis) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      const auto& line = lines_[at(axis)][at(i[at(v)]) * at(cells_[at(u)]) + at(i[at(u)])];
      const double here = i[at(axis)];
      const auto above = std::upper_bound(line.begin(), line.end(), here,
                                          [](double p, const Crossing& c) { return p < c.position; });
      for (int side = 0; side < 2; ++side) {
        Link& link = links_[at(n)][at(2 * axis + side)];
        const Crossing* next = nullptr;
        if (side == 1 && above != line.end()) next = &*above;
        if (side == 0 && above != line.begin()) next = &*(above - 1);
        const double fraction = next ? std::abs(next->position - here) : 2;
        if (fraction < 1) {
          link.fraction = static_cast<float>(std::max(fraction, smallest_fraction));
          link.is_free = next->value > rim_from && next->value < rim_to;
          link.value = next->value < 0.5 ? 0 : 1;
          continue;
        }
        Index j = i;
        j[at(axis)] += side == 1 ? 1 : -1;
        const int neighbour = node_at(j);
        if (neighbour < inside_count_) link.node = neighbour;
        link.is_free = link.node < 0;  // overlapping sheets
      }
    }
  });
}

void SolidDepth::solve() {
  const std::ptrdiff_t n = inside_count_;
  std::vector<double> diagonal(at(n), 0.0), r(at(n), 0.0), z(at(n)), p(at(n)), q(at(n));
  depth_.assign(at(n), 0.5);
  parallel_for(n, [&](std::ptrdiff_t i) {
    double d = 0, b = 0;
    for (const Link& link : links_[at(i)]) {
      if (link.is_free) continue;
      d += link.node >= 0 ? 1.0 : 1.0 / link.fraction;
      if (link.node < 0) b += link.value / link.fraction;
    }
    diagonal[at(i)] = d > 0 ? d : 1;
    r[at(i)] = b;
  });
  const auto apply = [&](const std::vector<double>& x, std::vector<double>& y) {
    parallel_for(n, [&](std::ptrdiff_t i) {
      double sum = diagonal[at(i)] * x[at(i)];
      for (const Link& link : links_[at(i)])
        if (link.node >= 0) sum -= x[at(link.node)];
      y[at(i)] = sum;
    });
  };
  const auto dot = [&](const std::vector<double>& x, const std::vector<double>& y) {
    return parallel_sum(n, [&](std::ptrdiff_t i) { return x[at(i)] * y[at(i)]; });
  };
  apply(depth_, q);
  parallel_for(n, [&](std::ptrdiff_t i) { r[at(i)] -= q[at(i)], z[at(i)] = r[at(i)] / diagonal[at(i)], p[at(i)] = z[at(i)]; });
  double rz = dot(r, z);
  const double goal = rz * residual_reduction * residual_reduction;
  for (iterations_ = 0; iterations_ < 2000 && rz > goal; ++iterations_) {
    apply(p, q);
    const double alpha = rz / dot(p, q);
    parallel_for(n, [&](std::ptrdiff_t i) {
      depth_[at(i)] += alpha * p[at(i)];
      r[at(i)] -= alpha * q[at(i)];
      z[at(i)] = r[at(i)] / diagonal[at(i)];
    });
    const double next = dot(r, z), beta = next / rz;
    rz = next;
    parallel_for(n, [&](std::ptrdiff_t i) { p[at(i)] = z[at(i)] + beta * p[at(i)]; });
  }
}

void SolidDepth::extrapolate() {
  // First ring: straight through the value on the surface. Distances from the crossings of up to three axes, as of a plane.
  outside_.assign(at(inside_count_), -h_);
  std::vector<double> sum, count;
  std::vector<std::array<double, 3>> fractions;
  for (int n = 0; n < inside_count_; ++n) {
    double inverse = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double nearest = 2;
      for (std::size_t side = 0; side < 2; ++side) {
        const Link& link = links_[at(n)][2 * axis + side];
        if (link.node >= 0 || link.fraction > 1) continue;
        nearest = std::min(nearest, static_cast<double>(link.fraction));
        Index j = nodes_[at(n)];
        j[axis] += side == 1 ? 1 : -1;
        const int ghost = add_node(j);
        if (ghost < inside_count_) continue;  // a cleft thinner than a voxel
        const std::size_t g = at(ghost - inside_count_);
        if (g >= sum.size()) sum.push_back(0), count.push_back(0), fractions.push_back({2, 2, 2});
        const Link& back = links_[at(n)][2 * axis + 1 - side];
        const double theta = link.fraction, here = depth_[at(n)];
        double value;
        if (link.is_free)
          value = back.node < 0 ? here : 2 * here - depth_[at(back.node)];
        else if (theta >= 0.5 || back.node < 0)
          value = here + (link.value - here) / std::max(theta, 0.25);
        else
          value = depth_[at(back.node)] + (link.value - depth_[at(back.node)]) * 2 / (1 + theta);
        sum[g] += value, count[g] += 1;
        fractions[g][axis] = std::min(fractions[g][axis], std::max(1 - theta, smallest_fraction));
      }
      if (nearest < 2) inverse += 1 / (nearest * nearest);
    }
    if (inverse > 0) outside_[at(n)] = -h_ / std::sqrt(inverse);
  }
  for (std::size_t g = 0; g < sum.size(); ++g) {
    depth_.push_back(std::clamp(sum[g] / count[g], -0.5, 1.5));
    double inverse = 0;
    for (double f : fractions[g])
      if (f < 2) inverse += 1 / (f * f);
    outside_.push_back(h_ / std::sqrt(inverse));
  }
  // Two more rings: continued along the axes, else the mean of the neighbours.
  for (int ring = 0; ring < 2; ++ring) {
    const int known = static_cast<int>(nodes_.size());
    for (int n = 0; n < known; ++n)
      for (int k = 0; k < 27; ++k) {
        const Index j{nodes_[at(n)][0] + k % 3 - 1, nodes_[at(n)][1] + k / 3 % 3 - 1, nodes_[at(n)][2] + k / 9 - 1};
        if (node_at(j) < 0) add_node(j);
      }
    depth_.resize(nodes_.size(), 0.5);
    outside_.resize(nodes_.size(), h_ * (ring + 1));
    for (int n = known; n < static_cast<int>(nodes_.size()); ++n) {
      double straight = 0, around = 0;
      int lines = 0, near = 0;
      for (int k = 0; k < 27; ++k) {
        const Index d{k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
        const Index &i = nodes_[at(n)], j{i[0] + d[0], i[1] + d[1], i[2] + d[2]};
        const int first = node_at(j);
        if (first < 0 || first >= known) continue;
        around += depth_[at(first)], ++near;
        const int second = node_at({i[0] + 2 * d[0], i[1] + 2 * d[1], i[2] + 2 * d[2]});
        if (second >= 0 && second < known) straight += 2 * depth_[at(first)] - depth_[at(second)], ++lines;
      }
      depth_[at(n)] = std::clamp(lines > 0 ? straight / lines : around / std::max(near, 1), -0.5, 1.5);
    }
  }
}

std::optional<double> SolidDepth::sample(const std::vector<double>& values, const Vec3& x) const {
  const Vec3 g = (x - lower_) / h_;
  Index i;
  Vec3 w;
  for (int a = 0; a < 3; ++a) {
    if (!(g[a] >= 0 && g[a] < cells_[at(a)] - 1)) return std::nullopt;
    i[at(a)] = static_cast<int>(g[a]);
    w[a] = g[a] - i[at(a)];
  }
  double value = 0;
  for (int k = 0; k < 8; ++k) {
    const int node = node_at({i[0] + (k & 1), i[1] + (k >> 1 & 1), i[2] + (k >> 2)});
    if (node < 0) return std::nullopt;
    value += ((k & 1) ? w[0] : 1 - w[0]) * ((k & 2) ? w[1] : 1 - w[1]) * ((k & 4) ? w[2] : 1 - w[2]) * values[at(node)];
  }
  return value;
}

Vec3 SolidDepth::gradient(const Vec3& x) const {
  Vec3 g = Vec3::Zero();
  const double step = 0.5 * h_;
  for (int a = 0; a < 3; ++a) {
    const Vec3 d = step * Vec3::Unit(a);
    const auto up = depth(x + d), down = depth(x - d);
    if (!up || !down) return Vec3::Zero();
    g[a] = (*up - *down) / (2 * step);
  }
  return g;
}

Vec3 SolidDepth::to_level(const Vec3& start, double value) const {
  Vec3 x = start;
  for (int iteration = 0; iteration < 20; ++iteration) {
    const auto here = depth(x);
    const Vec3 g = gradient(x);
    if (!here || !(g.norm() > 1e-6 / h_)) return start;
    const double miss = value - *here;
    if (std::abs(miss) < 1e-6) return x;
    Vec3 move = miss * g / g.squaredNorm();
    if (move.norm() > h_) move *= h_ / move.norm();
    x += move;
  }
  return x;
}

std::optional<Vec3> SolidDepth::walk(Vec3 x, double direction, double target, double length_limit, double& length) const {
  const double step = 0.2 * h_;
  auto here = depth(x);
  length = 0;
  while (here && length < length_limit) {
    const Vec3 g = gradient(x);
    if (!(g.norm() > 1e-9)) return std::nullopt;
    const Vec3 g2 = gradient(x + 0.5 * step * direction * g.normalized());
    const Vec3 d = direction * (g2.norm() > 1e-9 ? g2 : g).normalized();
    const auto next = depth(x + step * d);
    if (!next) return std::nullopt;
    const double gain = (*next - *here) * direction, missing = (target - *here) * direction;
    if (missing <= gain) {
      const double share = gain > 0 ? std::clamp(missing / gain, 0.0, 1.0) : 0;
      length += share * step;
      return x + share * step * d;
    }
    x += step * d;
    length += step;
    here = next;
    const auto out = outside(x);
    if (!out || *out > 0.5 * h_) return std::nullopt;  // left through a rim
  }
  return std::nullopt;
}

FieldLine SolidDepth::field_line(const Vec3& x) const {
  FieldLine line;
  const double limit = 2000 * h_;
  const auto lower = walk(x, -1, 0, limit, line.to_lower), upper = walk(x, 1, 1, limit, line.to_upper);
  line.ends_on_faces = lower && upper;
  line.lower = lower.value_or(x), line.upper = upper.value_or(x);
  return line;
}

Vec3 SolidDepth::along_line(const Vec3& x, double length) const {
  double walked = 0;
  Vec3 p = x;
  const double direction = length < 0 ? -1 : 1;
  while (walked < std::abs(length)) {
    const double step = std::min(0.2 * h_, std::abs(length) - walked);
    const Vec3 g = gradient(p);
    if (!(g.norm() > 1e-9)) break;
    p += step * direction * g.normalized();
    walked += step + 1e-12 * h_;
  }
  return p;
}

LevelSurface SolidDepth::level(double value) const {
  // Marching tetrahedra on the six tetrahedra around the diagonal of each cube, cut by "outside = 0".
  static constexpr int tets[6][4] = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};
  LevelSurface raw;
  std::vector<double> out;
  std::unordered_map<std::uint64_t, int> vertex;
  const auto on_edge = [&](int a, int b) {
    if (a > b) std::swap(a, b);
    const auto [entry, added] = vertex.try_emplace((static_cast<std::uint64_t>(a) << 32) | static_cast<std::uint32_t>(b),
                                                   static_cast<int>(raw.points.size()));
    if (added) {
      const double w = std::clamp((value - depth_[at(a)]) / (depth_[at(b)] - depth_[at(a)]), 1e-3, 1 - 1e-3);
      raw.points.push_back((1 - w) * position(nodes_[at(a)]) + w * position(nodes_[at(b)]));
      out.push_back((1 - w) * outside_[at(a)] + w * outside_[at(b)]);
    }
    return entry->second;
  };
  const auto add = [&](int a, int b, int c, const Vec3& up) {
    const Vec3 n = (raw.points[at(b)] - raw.points[at(a)]).cross(raw.points[at(c)] - raw.points[at(a)]);
    if (n.dot(up) < 0) std::swap(b, c);
    raw.triangles.push_back({a, b, c});
  };
  for (const Index& i : nodes_) {
    std::array<int, 8> corner;
    bool complete = true, has_inside = false;
    for (int k = 0; k < 8 && complete; ++k) {
      corner[at(k)] = node_at({i[0] + (k & 1), i[1] + (k >> 1 & 1), i[2] + (k >> 2)});
      complete = corner[at(k)] >= 0;
      has_inside = has_inside || (complete && corner[at(k)] < inside_count_);
    }
    if (!complete || !has_inside) continue;
    for (const auto& tet : tets) {
      std::array<int, 4> above, below;
      std::size_t up = 0, down = 0;
      Vec3 direction = Vec3::Zero();
      for (int k : tet) {
        const int node = corner[at(k)];
        (depth_[at(node)] > value ? above[up++] : below[down++]) = node;
      }
      if (up == 0 || down == 0) continue;
      for (std::size_t k = 0; k < up; ++k) direction += position(nodes_[at(above[k])]) / static_cast<double>(up);
      for (std::size_t k = 0; k < down; ++k) direction -= position(nodes_[at(below[k])]) / static_cast<double>(down);
      if (up == 1) add(on_edge(above[0], below[0]), on_edge(above[0], below[1]), on_edge(above[0], below[2]), direction);
      if (up == 3) add(on_edge(below[0], above[0]), on_edge(below[0], above[1]), on_edge(below[0], above[2]), direction);
      if (up == 2) {
        const int p = on_edge(above[0], below[0]), q = on_edge(above[0], below[1]), r = on_edge(above[1], below[1]),
                  s = on_edge(above[1], below[0]);
        add(p, q, r, direction), add(p, r, s, direction);
      }
    }
  }
  LevelSurface cut;
  std::vector<int> kept(raw.points.size(), -1);
  std::unordered_map<std::uint64_t, int> at_border;
  const auto keep = [&](int v) {
    if (kept[at(v)] < 0) kept[at(v)] = static_cast<int>(cut.points.size()), cut.points.push_back(raw.points[at(v)]);
    return kept[at(v)];
  };
  const auto border = [&](int a, int b) {
    if (a > b) std::swap(a, b);
    const auto [entry, added] = at_border.try_emplace((static_cast<std::uint64_t>(a) << 32) | static_cast<std::uint32_t>(b),
                                                      static_cast<int>(cut.points.size()));
    if (added) {
      const double w = std::clamp(-out[at(a)] / (out[at(b)] - out[at(a)]), 1e-3, 1 - 1e-3);
      cut.points.push_back((1 - w) * raw.points[at(a)] + w * raw.points[at(b)]);
    }
    return entry->second;
  };
  for (const auto& t : raw.triangles) {
    std::array<bool, 3> in{};
    int count = 0;
    for (std::size_t k = 0; k < 3; ++k) count += in[k] = out[at(t[k])] < 0;
    if (count == 0) continue;
    if (count == 3) { cut.triangles.push_back({keep(t[0]), keep(t[1]), keep(t[2])}); continue; }
    std::size_t k = 0;  // the corner that differs from the two others
    while (in[k] != (count == 1)) ++k;
    const int a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
    const int ab = border(a, b), ac = border(a, c);
    if (count == 1) {
      cut.triangles.push_back({keep(a), ab, ac});
    } else {
      cut.triangles.push_back({ab, keep(b), keep(c)});
      cut.triangles.push_back({ab, keep(c), ac});
    }
  }
  return cut;
}

}  // namespace mv
