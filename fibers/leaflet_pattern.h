// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// One leaflet on the flat pattern: u unwrapped, border as a function of u, and the tangents dx/du, dx/dv at its nodes. Internal to
// mv_fibers.

#include <vector>

#include "geometry/core/case.h"

namespace mv {

class LeafletPattern {
 public:
  /// Elements of `region`; `period` of u. Throws InputError when the leaflet has no free border or a degenerate map.
  LeafletPattern(const LeafletMesh& mesh, int region, double period);

  const std::vector<int>& elements() const { return elements_; }
  const std::vector<int>& nodes() const { return nodes_; }
  double t(int node) const { return (u_[at(node)] - middle_) / half_width_; }  // -1 .. 1 across the leaflet
  double v(int node) const { return mesh_.unfolded[at(node)].y(); }
  double middle() const { return middle_; }
  double half_width() const { return half_width_; }
  double tallest() const { return tallest_; }
  double spacing() const { return spacing_; }
  const Vec3& along_u(int node) const { return along_u_[at(node)]; }
  const Vec3& along_v(int node) const { return along_v_[at(node)]; }
  const Vec3& normal(int node) const { return normal_[at(node)]; }

  /// Height of the border at t, linear between border points.
  double border(double share) const;
  /// Lowest border between t = -left and t = right.
  double lowest_border(double left, double right) const;

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  void unwrap(double period);
  void find_extent();
  void find_tangents();

  const LeafletMesh& mesh_;
  std::vector<int> elements_, nodes_;
  std::vector<double> u_;
  std::vector<char> is_used_;
  std::vector<Vec3> along_u_, along_v_, normal_;
  std::vector<Vec2> border_;
  double middle_ = 0, half_width_ = 0, tallest_ = 0, spacing_ = 0;
};

}  // namespace mv
