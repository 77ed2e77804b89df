// SPDX-License-Identifier: BSD-3-Clause
#include "fibers/intrinsic_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <queue>

#include "geometry/core/side_faces.h"

namespace mv {
namespace {

constexpr double delaunay_tolerance = 1e-10;  // of the cotangents' sum
constexpr int flips_per_edge = 50;            // far beyond what the algorithm needs; it ends by itself

std::size_t at(int i) { return static_cast<std::size_t>(i); }

using Key = std::pair<int, int>;

// Triangles with lengths only.
class LengthMesh {
 public:
  void add(const std::array<int, 3>& t, const std::array<Vec3, 3>& x) {
    const int index = static_cast<int>(triangles_.size());
    triangles_.push_back(t);
    for (std::size_t i = 0; i < 3; ++i) {
      const Key k = std::minmax(t[i], t[(i + 1) % 3]);
      Side& side = sides_[k];
      side.length = (x[i] - x[(i + 1) % 3]).norm();
      (side.triangles[0] < 0 ? side.triangles[0] : side.triangles[1]) = index;
      ++side.uses;
    }
  }

  int flip_to_delaunay() {
    std::queue<Key> queue;
    for (const auto& [k, side] : sides_) queue.push(k);
    int flips = 0;
    const int most = flips_per_edge * static_cast<int>(sides_.size());
    while (!queue.empty() && flips < most) {
      const Key k = queue.front();
      queue.pop();
      const auto it = sides_.find(k);
      if (it == sides_.end() || !is_inner(it->second) || weight(k, it->second) >= -delaunay_tolerance) continue;
      const int c = opposite(it->second.triangles[0], k), d = opposite(it->second.triangles[1], k);
      if (c == d || sides_.count(std::minmax(c, d))) continue;
      for (const Key& changed : flip(k, c, d)) queue.push(changed);
      ++flips;
    }
    return flips;
  }

  double worst_angle_sum() const {
    double worst = 0;
    for (const auto& [k, side] : sides_)
      if (is_inner(side)) worst = std::max(worst, angle_at(side.triangles[0], k) + angle_at(side.triangles[1], k));
    return worst * 180 / std::numbers::pi;
  }

  std::vector<IntrinsicSurface::Edge> edges() const {
    std::vector<IntrinsicSurface::Edge> out;
    for (const auto& [k, side] : sides_) {
      double w = 0;
      for (int i = 0; i < std::min(side.uses, 2); ++i) w += 0.5 * cotangent(side.triangles[at(i)], k);
      // What could not be flipped (two edges between the same points), and obtuse corners of the border.
      out.push_back({k.first, k.second, std::max(w, 0.0)});
    }
    return out;
  }

 private:
  struct Side {
    double length = 0;
    std::array<int, 2> triangles{-1, -1};
    int uses = 0;
  };
  static bool is_inner(const Side& s) { return s.uses == 2; }

  int opposite(int triangle, const Key& k) const {
    for (int p : triangles_[at(triangle)])
      if (p != k.first && p != k.second) return p;
    return -1;
  }
  double length(int a, int b) const { return sides_.at(std::minmax(a, b)).length; }

  // Cotangent and angle of the corner opposite to the edge.
  double cotangent(int triangle, const Key& k) const {
    const int c = opposite(triangle, k);
    const double l = length(k.first, k.second), p = length(k.first, c), q = length(k.second, c), s = 0.5 * (l + p + q);
    const double area = std::sqrt(std::max(s * (s - l) * (s - p) * (s - q), 0.0));
    return (p * p + q * q - l * l) / std::max(4 * area, 1e-300);
  }
  double angle_at(int triangle, const Key& k) const { return std::atan2(1.0, cotangent(triangle, k)); }
  double weight(const Key& k, const Side& side) const { return 0.5 * (cotangent(side.triangles[0], k) + cotangent(side.triangles[1], k)); }

  // The other diagonal of the two triangles laid out in the plane.
  std::array<Key, 4> flip(const Key& k, int c, int d) {
    const auto [a, b] = k;
    const Side side = sides_.at(k);
    const double l = side.length;
    const auto corner = [&](int p) {
      const double pa = length(a, p), pb = length(b, p), x = (l * l + pa * pa - pb * pb) / (2 * l);
      return Vec2(x, std::sqrt(std::max(pa * pa - x * x, 0.0)));
    };
    const Vec2 pc = corner(c), pd = corner(d);
    const double diagonal = std::hypot(pc.x() - pd.x(), pc.y() + pd.y());
    const int t0 = side.triangles[0], t1 = side.triangles[1];
    triangles_[at(t0)] = {c, d, b};
    triangles_[at(t1)] = {d, c, a};
    sides_.erase(k);
    Side& made = sides_[std::minmax(c, d)];
    made.length = diagonal;
    made.triangles = {t0, t1};
    made.uses = 2;
    move(a, c, t0, t1);
    move(b, d, t1, t0);
    return {std::minmax(a, c), std::minmax(b, c), std::minmax(a, d), std::minmax(b, d)};
  }
  void move(int a, int b, int from, int to) {
    for (int& t : sides_.at(std::minmax(a, b)).triangles)
      if (t == from) {
        t = to;
        return;
      }
  }

  std::vector<std::array<int, 3>> triangles_;
  std::map<Key, Side> sides_;
};

int nearest_column(const LeafletMesh& mesh, const std::vector<int>& column_node, int node) {
  double best = std::numeric_limits<double>::max();
  int column = -1;
  for (std::size_t c = 0; c < column_node.size(); ++c)
    if (const double d = (mesh.points[at(column_node[c])] - mesh.points[at(node)]).squaredNorm(); d < best) {
      best = d;
      column = static_cast<int>(c);
    }
  return column;
}

}  // namespace

IntrinsicSurface intrinsic_surface(const LeafletMesh& mesh, const std::vector<int>& elements) {
  IntrinsicSurface surface;
  surface.column_of_node.assign(mesh.points.size(), -1);
  LengthMesh triangles;
  std::map<std::pair<double, double>, int> column_at;  // exact (u, v): prisms copy it through the thickness
  std::vector<char> is_here(mesh.tets.size(), 0);
  for (int e : elements) is_here[at(e)] = 1;
  for (const SideTriangle& triangle : side_triangles(mesh, atrial)) {
    if (!is_here[triangle.element]) continue;
    const std::array<int, 3>& t = triangle.nodes;
    std::array<int, 3> columns{};
    std::array<Vec3, 3> x;
    for (std::size_t i = 0; i < 3; ++i) {
      int& column = surface.column_of_node[at(t[i])];
      if (column < 0) {
        column = static_cast<int>(surface.column_node.size());
        surface.column_node.push_back(t[i]);
        if (!mesh.unfolded.empty()) column_at[{mesh.unfolded[at(t[i])].x(), mesh.unfolded[at(t[i])].y()}] = column;
      }
      columns[i] = column;
      x[i] = mesh.points[at(t[i])];
    }
    triangles.add(columns, x);
  }
  if (surface.column_node.empty()) return surface;
  for (int e : elements)
    for (std::size_t i = 0; i < 4; ++i) {
      const int node = mesh.tets[at(e)][i];
      int& column = surface.column_of_node[at(node)];
      if (column >= 0) continue;
      const auto found = mesh.unfolded.empty() ? column_at.end() : column_at.find({mesh.unfolded[at(node)].x(), mesh.unfolded[at(node)].y()});
      column = found != column_at.end() ? found->second : nearest_column(mesh, surface.column_node, node);
    }
  surface.worst_angle_sum = triangles.worst_angle_sum();
  surface.flips = triangles.flip_to_delaunay();
  surface.edges = triangles.edges();
  return surface;
}

}  // namespace mv
