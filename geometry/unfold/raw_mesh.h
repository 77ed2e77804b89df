// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Raw triangles made into an oriented manifold. Internal to mv_unfold.

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "geometry/surface/raw_leaflets.h"

namespace mv {

struct RawMesh {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;
  std::vector<int> region;        // per triangle, Region or 0
  std::vector<double> weight;     // per triangle: 1 measured, less where the program made it up
  std::vector<double> thickness;  // per point, mm, or empty

  double area(std::size_t triangle) const;
  double area() const;
  int add_point(const Vec3& x, double its_thickness);
  void add_triangle(const std::array<int, 3>& corners, int its_region, double its_weight);
};

/// Welds coinciding points, drops degenerate and repeated triangles and flaps on edges with more than two triangles, orients each
/// connected part and splits points where two fans touch. Every repair
/// is noted. Throws
/// InputError: sizes, indices, a coordinate that is not finite, no triangles, a one-sided surface (Moebius, Klein), an edge shared
/// by more than two triangles that cannot be dropped.
RawMesh clean_mesh(const RawLeaflets& raw, std::vector<std::string>& notes);

/// Border loops in the direction in which the triangles run, longest first.
std::vector<std::vector<int>> border_loops(const RawMesh& mesh);
double loop_length(const RawMesh& mesh, const std::vector<int>& loop);

/// Edge-connected parts, largest area first.
std::vector<RawMesh> connected_parts(const RawMesh& mesh);

/// Handles of a connected oriented surface: (2 - V + E - F - loops) / 2.
int handles(const RawMesh& mesh, std::size_t loops);

/// Joins a loop of the border to its centre by a fan of triangles of weight 0.
void fill_hole(RawMesh& mesh, const std::vector<int>& loop);

/// Splits triangles until no edge is longer than `length` and no inner edge joins two border points.
void refine(RawMesh& mesh, double length);

}  // namespace mv
