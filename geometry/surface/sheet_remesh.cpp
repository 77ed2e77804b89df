// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/surface/sheet_remesh.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/border.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Surface_mesh.h>
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>

namespace mv {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

std::size_t at(long i) { return static_cast<std::size_t>(i); }

Mesh mesh_of(const LevelSurface& s) {
  std::vector<Kernel::Point_3> points;
  for (const Vec3& p : s.points) points.emplace_back(p.x(), p.y(), p.z());
  std::vector<std::vector<std::size_t>> triangles;
  for (const auto& t : s.triangles) triangles.push_back({at(t[0]), at(t[1]), at(t[2])});
  Mesh mesh;
  if (!PMP::is_polygon_soup_a_polygon_mesh(triangles)) PMP::orient_polygon_soup(points, triangles);
  PMP::polygon_soup_to_polygon_mesh(points, triangles, mesh);
  return mesh;
}

LevelSurface surface_of(const Mesh& mesh) {
  LevelSurface s;
  std::map<Mesh::Vertex_index, int> index;
  for (const auto f : mesh.faces()) {
    std::array<int, 3> t{};
    std::size_t k = 0;
    for (const auto v : mesh.vertices_around_face(mesh.halfedge(f))) {
      const auto [entry, added] = index.try_emplace(v, static_cast<int>(s.points.size()));
      if (added) s.points.emplace_back(mesh.point(v).x(), mesh.point(v).y(), mesh.point(v).z());
      t[k++] = entry->second;
    }
    s.triangles.push_back(t);
  }
  return s;
}

void drop_small_parts(Mesh& mesh, double smallest, std::vector<std::string>& notes) {
  auto part = mesh.add_property_map<Mesh::Face_index, std::size_t>("f:part", 0).first;
  const std::size_t count = PMP::connected_components(mesh, part);
  std::vector<double> area(count, 0.0);
  std::vector<Vec3> middle(count, Vec3::Zero());
  for (const auto f : mesh.faces()) {
    const double a = CGAL::to_double(PMP::face_area(f, mesh));
    const auto& p = mesh.point(mesh.target(mesh.halfedge(f)));
    area[part[f]] += a;
    middle[part[f]] += a * Vec3(p.x(), p.y(), p.z());
  }
  if (count == 0) return;
  const auto largest = static_cast<std::size_t>(std::max_element(area.begin(), area.end()) - area.begin());
  std::vector<std::size_t> kept;
  int dropped = 0;
  double dropped_area = 0;
  Vec3 where = Vec3::Zero();
  for (std::size_t c = 0; c < count; ++c) {
    if (c == largest || area[c] >= smallest) {
      kept.push_back(c);
      continue;
    }
    if (++dropped == 1) where = middle[c] / std::max(area[c], 1e-300);
    dropped_area += area[c];
  }
  if (dropped > 0)
    notes.push_back(fmt::format("mid-surface: {} crumbs with {:.2f} mm2 in all dropped, the first near ({:.1f}, {:.1f}, {:.1f}) mm", dropped,
                                dropped_area, where.x(), where.y(), where.z()));
  PMP::keep_connected_components(mesh, kept, part);
  mesh.remove_property_map(part);
  mesh.collect_garbage();
}

/// Fills the holes that are too short to be rims or do not lie along one.
void fill_false_holes(Mesh& mesh, const SheetOptions& options, std::vector<std::string>& notes) {
  std::vector<Mesh::Halfedge_index> cycles;
  PMP::extract_boundary_cycles(mesh, std::back_inserter(cycles));
  int filled = 0, failed = 0;
  double longest = 0;
  Vec3 where = Vec3::Zero();
  for (const auto h : cycles) {
    double length = 0, off = 0;
    Vec3 first = Vec3::Zero();
    for (auto e = h;;) {
      const auto &p = mesh.point(mesh.source(e)), &q = mesh.point(mesh.target(e));
      const Vec3 a(p.x(), p.y(), p.z()), b(q.x(), q.y(), q.z());
      length += (b - a).norm();
      if (options.rim_distance) off += (b - a).norm() * options.rim_distance(0.5 * (a + b));
      first = a;
      if ((e = mesh.next(e)) == h) break;
    }
    const bool is_far_from_rims = options.rim_distance && off > options.rim_reach * length && length < options.longest_hole;
    if (length >= options.shortest_hole && !is_far_from_rims) continue;
    std::vector<Mesh::Face_index> faces;
    PMP::triangulate_hole(mesh, h, std::back_inserter(faces));
    ++(faces.empty() ? failed : filled);
    if (length > longest) longest = length, where = first;
  }
  if (filled + failed > 0)
    notes.push_back(fmt::format("mid-surface: {} holes that are no rims filled{}, the longest {:.2f} mm around, near ({:.1f}, {:.1f}, {:.1f}) mm", filled,
                                failed > 0 ? fmt::format(", {} could not be filled", failed) : "", longest, where.x(), where.y(), where.z()));
}

}  // namespace

LevelSurface tidy_sheet(const LevelSurface& surface, const SheetOptions& options, std::vector<std::string>& notes) {
  Mesh mesh = mesh_of(surface);
  drop_small_parts(mesh, options.smallest_part, notes);
  fill_false_holes(mesh, options, notes);
  PMP::isotropic_remeshing(mesh.faces(), options.spacing, mesh, PMP::parameters::number_of_iterations(4).number_of_relaxation_steps(2));
  mesh.collect_garbage();
  return surface_of(mesh);
}

std::vector<std::vector<int>> border_loops(const std::vector<Vec3>& points, const std::vector<std::array<int, 3>>& triangles) {
  std::map<std::pair<int, int>, int> uses;
  for (const auto& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) ++uses[{t[k], t[(k + 1) % 3]}];
  std::multimap<int, int> next;
  for (const auto& [edge, count] : uses)
    if (!uses.count({edge.second, edge.first})) next.emplace(edge.first, edge.second);
  std::vector<std::vector<int>> loops;
  while (!next.empty()) {
    std::vector<int> loop;
    int v = next.begin()->first;
    for (auto entry = next.find(v); entry != next.end(); entry = next.find(v)) {
      loop.push_back(v);
      v = entry->second;
      next.erase(entry);
    }
    loops.push_back(std::move(loop));
  }
  const auto length = [&](const std::vector<int>& loop) {
    double sum = 0;
    for (std::size_t i = 0; i < loop.size(); ++i) sum += (points[at(loop[i])] - points[at(loop[(i + 1) % loop.size()])]).norm();
    return sum;
  };
  std::stable_sort(loops.begin(), loops.end(), [&](const auto& p, const auto& q) { return length(p) > length(q); });
  return loops;
}

std::vector<int> connected_parts(const std::vector<std::array<int, 3>>& triangles, std::size_t points, int* count) {
  std::vector<int> root(points);
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int i) {
    while (root[at(i)] != i) i = root[at(i)] = root[at(root[at(i)])];
    return i;
  };
  for (const auto& t : triangles) root[at(find(t[0]))] = find(t[1]), root[at(find(t[1]))] = find(t[2]);
  std::map<int, int> number;
  std::vector<int> part;
  for (const auto& t : triangles) part.push_back(number.try_emplace(find(t[0]), static_cast<int>(number.size())).first->second);
  if (count) *count = static_cast<int>(number.size());
  return part;
}

}  // namespace mv
