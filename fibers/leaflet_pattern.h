// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// One leaflet on the flat pattern: u unwrapped, border as a function of u, and the tangents dx/du, dx/dv at its nodes. Internal to
// mv_fibers. Throws InputError when the leaflet has no free border or a degenerate map.

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <queue>
#include <string>
#include <vector>

#include "geometry/core/case.h"
#include "geometry/core/errors.h"
#include "geometry/core/unfolded.h"

namespace mv {

class LeafletPattern {
 public:
  LeafletPattern(const LeafletMesh& mesh, int region, double period)
      : mesh_(mesh), u_(mesh.points.size(), 0.0), is_used_(mesh.points.size(), 0) {
    for (std::size_t e = 0; e < mesh.tets.size(); ++e)
      if (mesh.region[e] == region) elements_.push_back(static_cast<int>(e));
    if (elements_.empty()) return;
    unwrap(period);
    find_extent();
    find_tangents();
  }

  const std::vector<int>& elements() const { return elements_; }
  const std::vector<int>& nodes() const { return nodes_; }
  double t(int node) const { return (u_[at(node)] - middle_) / half_width_; }
  double v(int node) const { return mesh_.unfolded[at(node)].y(); }
  double half_width() const { return half_width_; }
  double tallest() const { return tallest_; }
  double spacing() const { return spacing_; }
  const Vec3& along_u(int node) const { return along_u_[at(node)]; }
  const Vec3& along_v(int node) const { return along_v_[at(node)]; }
  const Vec3& normal(int node) const { return normal_[at(node)]; }

  // Height of the border at t, linear between border points.
  double border(double share) const {
    const double u = middle_ + share * half_width_;
    const auto after = std::lower_bound(border_.begin(), border_.end(), u, [](const Vec2& p, double x) { return p.x() < x; });
    if (after == border_.begin()) return border_.front().y();
    if (after == border_.end()) return border_.back().y();
    const Vec2 &a = *(after - 1), &b = *after;
    return b.x() > a.x() ? a.y() + (b.y() - a.y()) * (u - a.x()) / (b.x() - a.x()) : b.y();
  }
  // Lowest border between t = -left and t = right.
  double lowest_border(double left, double right) const {
    double lowest = std::min(border(-left), border(right));
    for (const Vec2& p : border_)
      if (std::abs(p.x() - middle_) < (p.x() < middle_ ? left : right) * half_width_) lowest = std::min(lowest, p.y());
    return lowest;
  }

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }

  void unwrap(double period) {
    std::vector<std::vector<int>> adjacent(mesh_.points.size());
    for (int e : elements_)
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < 4; ++j)
          if (i != j) adjacent[at(mesh_.tets[at(e)][i])].push_back(mesh_.tets[at(e)][j]);
    for (int e : elements_) {
      const int seed = mesh_.tets[at(e)][0];
      if (is_used_[at(seed)]) continue;
      // Parts of a leaflet that hang on nothing else start on the image nearest to the first part.
      u_[at(seed)] = nodes_.empty() ? mesh_.unfolded[at(seed)].x()
                                    : nearest_image(mesh_.unfolded[at(seed)].x(), u_[at(nodes_.front())], period);
      is_used_[at(seed)] = 1;
      std::queue<int> queue({seed});
      while (!queue.empty()) {
        const int i = queue.front();
        queue.pop();
        nodes_.push_back(i);
        for (int j : adjacent[at(i)]) {
          if (is_used_[at(j)]) continue;
          is_used_[at(j)] = 1;
          u_[at(j)] = nearest_image(mesh_.unfolded[at(j)].x(), u_[at(i)], period);
          queue.push(j);
        }
      }
    }
    std::sort(nodes_.begin(), nodes_.end());
  }

  void find_extent() {
    double low = u_[at(nodes_.front())], high = low;
    for (int i : nodes_) {
      low = std::min(low, u_[at(i)]);
      high = std::max(high, u_[at(i)]);
      if (mesh_.on_free_edge[at(i)] && mesh_.side[at(i)] == atrial) border_.emplace_back(u_[at(i)], v(i));
    }
    middle_ = 0.5 * (low + high);
    half_width_ = 0.5 * (high - low);
    if (border_.size() < 3 || !(half_width_ > 0))
      throw InputError("fibers: arcs need the free border of each leaflet (point arrays 'free_edge', 'side', 'unfolded')");
    std::sort(border_.begin(), border_.end(), [](const Vec2& a, const Vec2& b) { return a.x() < b.x(); });
    for (const Vec2& p : border_)
      tallest_ = std::max(tallest_, p.y());
  }

  void find_tangents() {
    along_u_.assign(mesh_.points.size(), Vec3::Zero());
    along_v_.assign(mesh_.points.size(), Vec3::Zero());
    normal_.assign(mesh_.points.size(), Vec3::Zero());
    double edges = 0;
    std::size_t count = 0;
    for (int e : elements_) {
      const auto& tet = mesh_.tets[at(e)];
      Mat3 x;
      Vec3 du, dv;
      for (int i = 0; i < 3; ++i) {
        const int node = tet[at(i + 1)];
        x.row(i) = (mesh_.points[at(node)] - mesh_.points[at(tet[0])]).transpose();
        du[i] = u_[at(node)] - u_[at(tet[0])];
        dv[i] = v(node) - v(tet[0]);
        edges += x.row(i).norm();
        ++count;
      }
      const double volume = std::abs(x.determinant()) / 6;
      const Vec3& s = mesh_.sheet_normal[at(e)];
      const Mat3 inverse = x.inverse();
      Vec3 gu = inverse * du, gv = inverse * dv;
      gu -= s * s.dot(gu);
      gv -= s * s.dot(gv);
      // Tangent vectors dual to the two gradients.
      const double uu = gu.squaredNorm(), vv = gv.squaredNorm(), uv = gu.dot(gv), det = uu * vv - uv * uv;
      for (std::size_t i = 0; i < 4; ++i) {
        normal_[at(tet[i])] += volume * s;
        if (!(det > 1e-12 * uu * vv)) continue;
        along_u_[at(tet[i])] += volume * (gu * vv - gv * uv) / det;
        along_v_[at(tet[i])] += volume * (gv * uu - gu * uv) / det;
      }
    }
    spacing_ = edges / static_cast<double>(count);
    for (int i : nodes_) {
      // One common factor: the two keep their ratio, which the slope of a pattern curve needs.
      const double length = along_u_[at(i)].norm();
      if (!(length > 0)) throw InputError("fibers: the unfolded map is degenerate around leaflet node " + std::to_string(i));
      along_u_[at(i)] /= length;
      along_v_[at(i)] /= length;
      normal_[at(i)].normalize();
    }
  }

  const LeafletMesh& mesh_;
  std::vector<int> elements_, nodes_;
  std::vector<double> u_;
  std::vector<char> is_used_;
  std::vector<Vec3> along_u_, along_v_, normal_;
  std::vector<Vec2> border_;
  double middle_ = 0, half_width_ = 0, tallest_ = 0, spacing_ = 0;
};

}  // namespace mv
