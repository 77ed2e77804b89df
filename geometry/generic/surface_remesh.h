// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Incremental remeshing of a triangulated parameter domain towards equilateral triangles in space. Internal to mv_generic.
// Operations after Botsch & Kobbelt, "A remeshing approach to multiresolution modeling", 2004: split, collapse, flip, smooth;
// here points live in the (u, v) of an exact surface map, so nothing has to be projected back.

#include <array>
#include <functional>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

/// Surface map of a simply connected piece of (u, v).
struct SurfaceMap {
  std::function<Vec3(const Vec2&)> position;
  std::function<Vec3(const Vec2&)> along_u;
  std::function<Vec3(const Vec2&)> along_v;
  double half_thickness = 0;  // the surface will be offset by this to both sides
  std::function<double(const Vec2&)> half_thickness_at;  // the same where it varies; empty: uniform

  double half_thickness_of(const Vec2& uv) const { return half_thickness_at ? half_thickness_at(uv) : half_thickness; }
};

/// Triangle mesh over (u, v) with its image in space. The border is kept: points given as fixed do not move, border
/// edges do not flip, split or collapse.
class SurfaceRemesh {
 public:
  SurfaceRemesh(SurfaceMap map, std::vector<Vec2> uv, std::vector<std::array<int, 3>> triangles, std::vector<char> fixed);

  /// Inserts a free point into the triangle that holds it; returns false (nothing changed) when it lies outside or on an edge.
  bool insert(const Vec2& uv);
  int size() const { return static_cast<int>(uv_.size()); }
  int split_longer_than(double length);  // returns the number of splits
  /// Splits interior edges that are longer than `length` on either offset face; returns the number of splits.
  int split_longer_on_faces(double length);
  int split_border_chords(double length);                    // interior edges between two fixed points
  int collapse_shorter_than(double length, double longest);  // no edge longer than `longest` is made
  int flip_to_delaunay();                                    // opposite angles in space sum to more than pi
  /// Moves free points towards the area centroid of their surrounding triangles: those from index `first` on and their
  /// neighbours.
  void smooth(int sweeps, double relaxation, int first = 0);
  void equalise_edges(int sweeps, double power);  // descends on the sum of edge^(power + 2): shortens the longest edges first

  /// Removes dead points and triangles; call once at the end.
  void compact();
  const std::vector<Vec2>& uv() const { return uv_; }
  const std::vector<Vec3>& points() const { return x_; }
  const std::vector<std::array<int, 3>>& triangles() const { return triangles_; }

 private:
  using Triangle = std::array<int, 3>;
  Vec2 difference(int a, int b) const;  // uv_b - uv_a
  double area_uv(int a, int b, int c) const;
  double area_uv(int a, int b, const Vec2& p) const;
  int triangle_holding(const Vec2& p) const;
  double cosine_at(int a, int b, int c) const;  // of the angle at a
  double distance(int a, int b) const { return (x_[static_cast<std::size_t>(a)] - x_[static_cast<std::size_t>(b)]).norm(); }
  std::vector<std::pair<int, int>> edges() const;       // interior edges, a < b
  std::array<int, 2> triangles_of(int a, int b) const;  // -1 when absent
  int opposite(int triangle, int a, int b) const;
  std::vector<int> neighbours(int a) const;
  void replace(int triangle, int from, int to);
  double face_distance(int a, int b) const;
  int split_where(const std::function<double(int, int)>& excess);
  void split(int a, int b);
  bool collapse(int a, int b, double longest);
  bool flip(int a, int b, int t0, int t1);
  bool move(int a, const Vec3& target, double relaxation);
  double worst_quality(int a) const;

  SurfaceMap map_;
  std::vector<Vec2> uv_;
  std::vector<Vec3> x_;
  std::vector<Triangle> triangles_;
  std::vector<char> fixed_, alive_;
  std::vector<std::vector<int>> star_;
  int last_inserted_ = -1;
};

/// Triangles of a simple counter-clockwise polygon without new points (ear clipping, widest ear first). Throws GateError when the
/// polygon is not simple.
std::vector<std::array<int, 3>> triangulate_polygon(const std::vector<Vec2>& polygon);

}  // namespace mv
