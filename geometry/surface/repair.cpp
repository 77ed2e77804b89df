// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/surface/repair.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/core/errors.h"
#include "geometry/surface/cgal_repair.h"
#include "geometry/surface/self_intersection.h"
#include "geometry/surface/sheet_remesh.h"
#include "geometry/surface/solid_faces.h"
#include "geometry/surface/soup_repair.h"
#include "geometry/surface/surface_query.h"

namespace mv {
namespace {

std::size_t at(long i) { return static_cast<std::size_t>(i); }

// A double wall has both faces: seen from one side nearly everywhere the other face is near. In units of thickness squared its area
// is large; a mid-surface that forms a tube sees its other side as well, but far away.
constexpr double paired_share_of_walls = 0.5;
constexpr double area_of_walls = 30;

double length_of(const Soup& s, const std::vector<int>& rim) {
  double length = 0;
  for (std::size_t i = 0; i < rim.size(); ++i) length += (s.points[at(rim[i])] - s.points[at(rim[(i + 1) % rim.size()])]).norm();
  return length;
}

/// Mean distance of the points of one rim from the nearest points of the other.
double distance_of(const Soup& s, const std::vector<int>& a, const std::vector<int>& b) {
  double sum = 0;
  for (int i : a) {
    double nearest = std::numeric_limits<double>::max();
    for (int j : b) nearest = std::min(nearest, (s.points[at(i)] - s.points[at(j)]).norm());
    sum += nearest;
  }
  return sum / static_cast<double>(a.size());
}

void fill_holes(Soup& s, double longest_rim, bool keep_longest) {
  auto rims = border_loops(s.points, s.triangles);
  if (keep_longest && !rims.empty()) rims.erase(rims.begin());
  long filled = 0, failed = 0;
  double longest = 0;
  Vec3 first = Vec3::Zero();
  for (const auto& rim : rims) {
    const double length = length_of(s, rim);
    if (length > longest_rim) continue;
    if (!fill_hole(s, rim)) {
      ++failed;
      continue;
    }
    if (++filled == 1) first = s.points[at(rim[0])];
    longest = std::max(longest, length);
  }
  if (filled > 0)
    s.tell(fmt::format("{} holes filled, the longest rim {:.2f} mm, one at ({:.1f}, {:.1f}, {:.1f}) mm", filled, longest, first.x(), first.y(),
                       first.z()));
  if (failed > 0) s.tell(fmt::format("{} holes could not be filled", failed));
}

struct Walls {
  bool are_double = false;
  bool inwards = true;    // the other wall lies against the normal
  double thickness = 0;   // mm
};

/// Does the surface see its own other face nearby, on one side?
Walls look_for_walls(const Soup& s) {
  double area = 0;
  for (std::size_t t = 0; t < s.triangles.size(); ++t) area += s.area(t);
  Walls best;
  for (const bool inwards : {true, false}) {
    const OppositeFaces seen = opposite_faces(s.points, s.triangles, inwards);
    const bool is = seen.share > paired_share_of_walls && area > area_of_walls * seen.thickness * seen.thickness;
    if (is && (!best.are_double || seen.thickness < best.thickness)) best = {true, inwards, seen.thickness};
  }
  return best;
}

/// Closes the rims of a double wall: pairs of rims that run along each other by a strip, rims that run back along themselves by a patch.
void close_walls(Soup& s, double thickness) {
  auto rims = border_loops(s.points, s.triangles);
  while (!rims.empty()) {
    const auto rim = rims.front();
    rims.erase(rims.begin());
    std::size_t partner = rims.size();
    double nearest = 4 * thickness;
    for (std::size_t k = 0; k < rims.size(); ++k) {
      const double d = std::max(distance_of(s, rim, rims[k]), distance_of(s, rims[k], rim));
      if (d < nearest) nearest = d, partner = k;
    }
    if (partner < rims.size()) {
      close_strip(s, rim, rims[partner]);
      rims.erase(rims.begin() + static_cast<long>(partner));
    } else if (fill_hole(s, rim)) {
      s.tell(fmt::format("rim of {:.1f} mm closed between the two walls", length_of(s, rim)));
    } else {
      throw InputError(fmt::format("surface: a rim of {:.1f} mm near ({:.1f}, {:.1f}, {:.1f}) mm cannot be closed; expected two walls joined at the "
                                   "free edge and open along the annulus", length_of(s, rim), s.points[at(rim[0])].x(),
                                   s.points[at(rim[0])].y(), s.points[at(rim[0])].z()));
    }
  }
}

void refuse_open(const Soup& s, const std::vector<std::vector<int>>& rims) {
  const Vec3& p = s.points[at(rims[0][0])];
  throw InputError(fmt::format("surface: surface.kind asks for a closed surface, but {} rims are open, the longest {:.1f} mm near ({:.1f}, {:.1f}, {:.1f}) "
                               "mm; close it, or set surface.kind to \"double_wall\" or \"mid\"", rims.size(), length_of(s, rims[0]), p.x(), p.y(), p.z()));
}

}  // namespace

std::string_view to_string(SurfaceKind kind) {
  switch (kind) {
    case SurfaceKind::automatic: return "auto";
    case SurfaceKind::thick: return "thick";
    case SurfaceKind::double_wall: return "double_wall";
    case SurfaceKind::mid: return "mid";
  }
  return "";
}

RepairedSurface repair_surface(const RawSurface& raw, const RepairOptions& options) {
  RepairedSurface out;
  Soup s{raw.points, raw.triangles, raw.group, &out.report};
  if (s.group.empty()) s.group.assign(s.triangles.size(), -1);
  for (std::size_t i = 0; i < s.points.size(); ++i)
    if (!s.points[i].allFinite()) throw InputError(fmt::format("surface: point {} is not finite", i));
  const double size = s.size();
  if (!(size > 0)) throw InputError("surface: it has no size: all its triangles lie in one point");

  weld_points(s, options.weld > 0 ? options.weld : 1e-6 * size);
  remove_degenerate_triangles(s);
  remove_duplicate_triangles(s);
  cut_crowded_edges(s, options.smallest_part);
  if (s.triangles.empty()) throw InputError("surface: nothing is left after degenerate triangles are taken out");
  orient_parts(s);
  split_pinched_points(s);
  drop_specks(s, options.smallest_part);

  const double longest_rim = options.largest_hole * size;
  auto rims = border_loops(s.points, s.triangles);
  SurfaceKind kind = options.kind;
  Walls walls;
  const bool is_closed_but_for_holes = std::all_of(rims.begin(), rims.end(), [&](const auto& rim) { return length_of(s, rim) <= longest_rim; });
  if (kind == SurfaceKind::automatic && is_closed_but_for_holes) kind = SurfaceKind::thick;
  if (kind == SurfaceKind::automatic || kind == SurfaceKind::double_wall) {
    walls = look_for_walls(s);
    if (kind == SurfaceKind::automatic) kind = walls.are_double ? SurfaceKind::double_wall : SurfaceKind::mid;
  }
  if (kind == SurfaceKind::double_wall) {
    if (!walls.are_double && !rims.empty())
      throw InputError("surface: surface.kind is \"double_wall\", but the two faces are not found next to each other; expected both faces of the "
                       "leaflets, or set surface.kind to \"mid\"");
    fill_holes(s, std::min(longest_rim, 4 * walls.thickness), false);
    close_walls(s, walls.thickness);
    orient_parts(s);
  } else if (kind == SurfaceKind::thick) {
    fill_holes(s, longest_rim, false);
    rims = border_loops(s.points, s.triangles);
    if (!rims.empty()) refuse_open(s, rims);
    orient_parts(s);
  } else {
    if (rims.empty()) throw InputError("surface: surface.kind is \"mid\", but the surface is closed; expected an open mid-surface, or set surface.kind to \"thick\"");
    fill_holes(s, 0.2 * longest_rim, true);
  }

  auto pairs = self_intersections(s.points, s.triangles);
  if (!pairs.empty() && kind != SurfaceKind::mid) {
    const long before = static_cast<long>(pairs.size());
    const bool done = remove_self_intersections(s);
    orient_parts(s);
    pairs = self_intersections(s.points, s.triangles);
    s.tell(fmt::format("{} pairs of triangles intersected, {} are left{}", before, pairs.size(), done ? "" : " (CGAL could not remove all)"));
  } else if (!pairs.empty()) {
    s.tell(fmt::format("{} pairs of triangles intersect", pairs.size()));
  }
  out.self_intersections = static_cast<long>(pairs.size());
  s.keep(std::vector<char>(s.triangles.size(), 1));
  connected_parts(s.triangles, s.points.size(), &out.parts);
  out.points = std::move(s.points), out.triangles = std::move(s.triangles), out.group = std::move(s.group);
  out.kind = kind;
  return out;
}

}  // namespace mv
