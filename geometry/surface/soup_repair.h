// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// The repairs that need no geometry library: each changes the surface and tells what it did. Internal to repair_surface.

#include "geometry/surface/repair.h"

namespace mv {

/// A surface under repair.
struct Soup {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;
  std::vector<int> group;  // per triangle
  std::vector<std::string>* report = nullptr;

  double size() const;  // mm, diagonal of the box around the triangles
  double area(std::size_t triangle) const;
  void tell(const std::string& line) const { report->push_back(line); }
  /// Keeps the triangles marked, and the points they use.
  void keep(const std::vector<char>& marked);
};

void weld_points(Soup& soup, double distance);
void remove_degenerate_triangles(Soup& soup);  // flat ones are flipped into their neighbour when that has room
void remove_duplicate_triangles(Soup& soup);
/// Edges with more than two triangles: small sheets that hang on them (share of the area) are dropped, otherwise the surface is cut there.
void cut_crowded_edges(Soup& soup, double small_share);
/// One orientation per part, that of most of its area; closed parts outwards. Throws InputError for a part that has none.
void orient_parts(Soup& soup);
void split_pinched_points(Soup& soup);  // a point where several fans of triangles meet becomes one a fan
void drop_specks(Soup& soup, double smallest_share);
/// Joins two rims by a strip, the shorter diagonal first.
void close_strip(Soup& soup, std::vector<int> rim_a, std::vector<int> rim_b);

}  // namespace mv
