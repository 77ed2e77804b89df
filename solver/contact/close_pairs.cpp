// SPDX-License-Identifier: BSD-3-Clause
#include "solver/contact/close_pairs.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "geometry/core/errors.h"
#include "geometry/core/parallel.h"

namespace mv {
namespace {

using Vec3 = Eigen::Vector3d;

constexpr int shells = 64;
constexpr double flat_cosine = 0.70710678118654752;
constexpr double height_room = 1.001;  // over the radius

Vec3 point(std::span<const double> x, int node) { return Eigen::Map<const Vec3>(x.data() + 3 * static_cast<std::size_t>(node)); }

}  // namespace

ClosePairs::ClosePairs(std::span<const double> rest, std::span<const std::array<int, 3>> triangles)
    : triangles_(triangles.begin(), triangles.end()), owned_(triangles.size()), shell_start_(shells + 1, 0) {
  const int vertices = static_cast<int>(rest.size() / 3);
  std::vector<char> is_owned(static_cast<std::size_t>(vertices), 0);
  std::map<std::array<int, 2>, int> known;
  for (std::size_t f = 0; f < triangles_.size(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const int a = triangles_[f][k], b = triangles_[f][(k + 1) % 3];
      if (a < 0 || a >= vertices) throw InputError("close pairs: a triangle refers to vertex " + std::to_string(a) + " of " + std::to_string(vertices));
      if (!is_owned[static_cast<std::size_t>(a)]) owned_[f].vertex[k] = a;
      is_owned[static_cast<std::size_t>(a)] = 1;
      const auto [at, is_new] = known.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<int>(edges_.size()));
      if (!is_new) continue;
      owned_[f].edge[k] = at->second;
      edges_.push_back(at->first);
    }
  }
  for (int v = 0; v < vertices; ++v)
    if (is_owned[static_cast<std::size_t>(v)]) used_.push_back(v);
  star_start_.assign(static_cast<std::size_t>(vertices) + 1, 0);
  for (const auto& t : triangles_)
    for (int v : t) ++star_start_[static_cast<std::size_t>(v) + 1];
  for (int v = 0; v < vertices; ++v) star_start_[static_cast<std::size_t>(v) + 1] += star_start_[static_cast<std::size_t>(v)];
  star_.resize(3 * triangles_.size());
  std::vector<int> next(star_start_.begin(), star_start_.end() - 1);
  for (std::size_t f = 0; f < triangles_.size(); ++f)
    for (int v : triangles_[f]) star_[static_cast<std::size_t>(next[static_cast<std::size_t>(v)]++)] = static_cast<int>(f);
  is_flat_.assign(static_cast<std::size_t>(vertices), 0);
  std::vector<Vec3> centres, normals;
  for (const auto& t : triangles_) {
    const Vec3 a = point(rest, t[0]), b = point(rest, t[1]), c = point(rest, t[2]);
    centres.push_back((a + b + c) / 3);
    normals.push_back((b - a).cross(c - a).stableNormalized());
  }
  tree_ = BoxTree(centres, normals, BoxTree::normal_edges * longest_edge(rest));
}

void ClosePairs::find_flat_vertices(std::span<const double> x) {
  normal_.resize(triangles_.size());
  height_.resize(triangles_.size());
  parallel_for(static_cast<std::ptrdiff_t>(triangles_.size()), [&](std::ptrdiff_t f) {
    const auto& t = triangles_[f];
    const Vec3 a = point(x, t[0]), b = point(x, t[1]), c = point(x, t[2]);
    normal_[f] = (b - a).cross(c - a);
    const double area2 = normal_[f].norm(), longest = std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
    height_[f] = area2 > 0 ? area2 / longest : 0;
    if (area2 > 0) normal_[f] /= area2;
  });
  parallel_for(static_cast<std::ptrdiff_t>(used_.size()), [&](std::ptrdiff_t k) {
    const auto v = static_cast<std::size_t>(used_[static_cast<std::size_t>(k)]);
    Vec3 axis = Vec3::Zero();
    for (int s = star_start_[v]; s < star_start_[v + 1]; ++s) axis += normal_[static_cast<std::size_t>(star_[s])];
    const double length = axis.norm();
    bool is_flat = true;
    for (int s = star_start_[v]; s < star_start_[v + 1]; ++s) {
      const auto f = static_cast<std::size_t>(star_[s]);
      const double along = normal_[f].dot(axis);  // times length: cosine, by which the height shrinks at most when seen along the axis
      is_flat = is_flat && along > flat_cosine * length && height_[f] * along > height_room * radius_ * length;
    }
    is_flat_[v] = is_flat;
  });
}

/// Bit l: triangle f and that in lane l of the leaf have a vertex in common around which the surface is flat.
unsigned ClosePairs::sharing_a_flat_vertex(int f, int leaf) const {
  const Lanes& l = lanes_[static_cast<std::size_t>(leaf)];
  FloatMask shared{};
  for (int a : triangles_[static_cast<std::size_t>(f)]) {
    if (!is_flat_[static_cast<std::size_t>(a)]) continue;
    for (const auto& vertices : l.vertex) shared |= load_ints(vertices.data()) == a;
  }
  return bits(shared);
}

/// Bit l: a plane across the line of the centres of triangle f and that in lane l parts them by more than the radius.
unsigned ClosePairs::far_from(int f, int leaf, std::span<const double> x) const {
  const Lanes& l = lanes_[static_cast<std::size_t>(leaf)];
  const auto corner = [&](int k, int c) { return load_floats(l.corner[static_cast<std::size_t>(k)][static_cast<std::size_t>(c)].data()); };
  std::array<Eigen::Vector3f, 3> own;
  for (std::size_t k = 0; k < 3; ++k) own[k] = point(x, triangles_[static_cast<std::size_t>(f)][k]).cast<float>();
  const Eigen::Vector3f centre = (own[0] + own[1] + own[2]) / 3;
  std::array<Floats, 3> axis;
  for (int c = 0; c < 3; ++c) axis[static_cast<std::size_t>(c)] = (corner(0, c) + corner(1, c) + corner(2, c)) * (1 / 3.0F) - centre[c];
  // Heights along the axis over the centre of f: small numbers.
  Floats near{}, far{};
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3f p = own[static_cast<std::size_t>(k)] - centre;
    const Floats u = axis[0] * p[0] + axis[1] * p[1] + axis[2] * p[2];
    const Floats v = axis[0] * (corner(k, 0) - centre[0]) + axis[1] * (corner(k, 1) - centre[1]) + axis[2] * (corner(k, 2) - centre[2]);
    near = k == 0 ? u : (u > near ? u : near);
    far = k == 0 ? v : (v < far ? v : far);
  }
  const Floats gap = far - near;
  const float reach = static_cast<float>(radius_) * 1.0001F + margin_;
  return bits((gap > 0) & (gap * gap > reach * reach * (axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2])));
}

void ClosePairs::add(bool is_edges, const std::array<int, 4>& node, std::span<const double> x, std::vector<ClosePair>& out) const {
  const contact::FourPoints p{point(x, node[0]), point(x, node[1]), point(x, node[2]), point(x, node[3])};
  if (is_edges) {
    // Spheres around the edges: twice the distance of the centres against the sum of the lengths.
    const double lengths = (p[1] - p[0]).norm() + (p[3] - p[2]).norm() + 2 * radius_;
    if ((p[0] + p[1] - p[2] - p[3]).squaredNorm() > lengths * lengths) return;
  }
  const double distance = contact::nearest_points(is_edges, p).separation.norm();
  if (distance < radius_) out.push_back({node, is_edges, std::max(0.0F, static_cast<float>(distance) * (1 - 1e-6F))});
}

void ClosePairs::add_pairs(int f, int g, std::span<const double> x, std::vector<ClosePair>& out) const {
  const auto has = [](const std::array<int, 3>& t, int v) { return t[0] == v || t[1] == v || t[2] == v; };
  const auto add_vertices = [&](const Owned& of, const std::array<int, 3>& t) {
    for (int v : of.vertex)
      if (v >= 0 && !has(t, v)) add(false, {v, t[0], t[1], t[2]}, x, out);
  };
  add_vertices(owned_[f], triangles_[g]);
  add_vertices(owned_[g], triangles_[f]);
  for (int i : owned_[f].edge) {
    if (i < 0) continue;
    for (int j : owned_[g].edge) {
      if (j < 0) continue;
      const auto& [a, b] = edges_[std::min(i, j)];
      const auto& [c, d] = edges_[std::max(i, j)];
      if (a == c || a == d || b == c || b == d) continue;
      add(true, {a, b, c, d}, x, out);
    }
  }
}

void ClosePairs::update(std::span<const double> x, double radius) {
  radius_ = radius;
  find_flat_vertices(x);
  const int count = static_cast<int>(triangles_.size());
  centre_.resize(triangles_.size());
  box_.resize(triangles_.size());
  parallel_for(count, [&](std::ptrdiff_t f) {
    const auto& t = triangles_[f];
    const Vec3 a = point(x, t[0]), b = point(x, t[1]), c = point(x, t[2]);
    centre_[f] = (a + b + c) / 3;
    box_[f] = {a.cwiseMin(b).cwiseMin(c).cast<float>().array(), a.cwiseMax(b).cwiseMax(c).cast<float>().array()};
  });
  double largest = 0, checksum = 0;
  for (int f = 0; f < count; ++f) {
    largest = std::max(largest, centre_[f].cwiseAbs().maxCoeff());
    checksum += centre_[f].sum();
  }
  if (!std::isfinite(checksum)) throw TrustError("contact: positions are not finite; the run has diverged");
  margin_ = static_cast<float>(1e-6 * (largest + radius));
  const float inflated = static_cast<float>(radius) + margin_;
  tree_.fit([&](int f) { return box_[static_cast<std::size_t>(f)]; });
  lanes_.resize(static_cast<std::size_t>(tree_.leaf_count()));
  parallel_for(
      tree_.leaf_count(),
      [&](std::ptrdiff_t leaf) {
        for (int lane = 0; lane < BoxTree::width; ++lane) {
          const int f = tree_.item(static_cast<int>(leaf) * BoxTree::width + lane);
          for (int k = 0; k < 3; ++k) {
            const int v = f < 0 ? -1 : triangles_[static_cast<std::size_t>(f)][k];
            lanes_[leaf].vertex[k][lane] = v;
            for (int c = 0; c < 3; ++c) lanes_[leaf].corner[k][c][lane] = v < 0 ? 0 : static_cast<float>(x[3 * static_cast<std::size_t>(v) + c]);
          }
        }
      },
      64);
  const auto around = [&](BoxTree::Box box) {
    box.lower -= inflated;
    box.upper += inflated;
    return box;
  };

  constexpr int piece = 16;  // leaves
  const int leaves = tree_.leaf_count(), pieces = (leaves + piece - 1) / piece;
  found_.resize(static_cast<std::size_t>(pieces));
  parallel_pieces(
      pieces, 1,
      [&](std::ptrdiff_t first_piece, std::ptrdiff_t last_piece, int) {
        for (std::ptrdiff_t p = first_piece; p < last_piece; ++p) {
          std::vector<ClosePair> list = std::move(found_[p]);
          list.clear();
          for (int leaf = static_cast<int>(p) * piece; leaf < std::min(leaves, static_cast<int>(p + 1) * piece); ++leaf) {
            tree_.for_leaves(around(tree_.leaf_box(leaf)), leaf, [&](int other) {
              unsigned own = tree_.overlapping(leaf, around(tree_.leaf_box(other)));
              for (; own != 0; own &= own - 1) {
                const int lane = __builtin_ctz(own), f = tree_.item(leaf * BoxTree::width + lane);
                unsigned mask = tree_.overlapping(other, around(box_[static_cast<std::size_t>(f)]));
                if (other == leaf) mask &= ~0U << (lane + 1);  // each pair once
                if (mask != 0) mask &= ~sharing_a_flat_vertex(f, other);
                if (mask != 0) mask &= ~far_from(f, other, x);
                for (; mask != 0; mask &= mask - 1) add_pairs(f, tree_.item(other * BoxTree::width + __builtin_ctz(mask)), x, list);
              }
            });
          }
          found_[p] = std::move(list);
        }
      },
      2);

  // Sorted by shells of distance, within a shell in the order found.
  const auto shell_of = [&](const ClosePair& pair) { return std::min(shells - 1, static_cast<int>(pair.distance / radius * shells)); };
  std::fill(shell_start_.begin(), shell_start_.end(), 0);
  for (const auto& list : found_)
    for (const ClosePair& pair : list) ++shell_start_[static_cast<std::size_t>(shell_of(pair)) + 1];
  for (int s = 0; s < shells; ++s) shell_start_[static_cast<std::size_t>(s) + 1] += shell_start_[static_cast<std::size_t>(s)];
  pairs_.resize(static_cast<std::size_t>(shell_start_.back()));
  std::array<int, shells> next;
  std::copy_n(shell_start_.begin(), shells, next.begin());
  for (const auto& list : found_)
    for (const ClosePair& pair : list) pairs_[static_cast<std::size_t>(next[static_cast<std::size_t>(shell_of(pair))]++)] = pair;
}

double ClosePairs::longest_edge(std::span<const double> x) const {
  std::vector<double> largest(static_cast<std::size_t>(thread_count()), 0.0);
  parallel_ranges(static_cast<std::ptrdiff_t>(edges_.size()), [&](std::ptrdiff_t begin, std::ptrdiff_t end, int thread) {
    double squared = 0;
    for (std::ptrdiff_t e = begin; e < end; ++e) squared = std::max(squared, (point(x, edges_[e][0]) - point(x, edges_[e][1])).squaredNorm());
    largest[static_cast<std::size_t>(thread)] = squared;
  });
  return std::sqrt(*std::max_element(largest.begin(), largest.end()));
}

std::span<const ClosePair> ClosePairs::pairs_within(double distance) const {
  if (!(distance < radius_)) return pairs_;
  const int shell = std::clamp(static_cast<int>(distance / radius_ * shells), 0, shells - 1);
  return std::span<const ClosePair>(pairs_).first(static_cast<std::size_t>(shell_start_[static_cast<std::size_t>(shell) + 1]));
}

}  // namespace mv
