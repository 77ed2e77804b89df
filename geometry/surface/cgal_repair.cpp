// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/surface/cgal_repair.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair_self_intersections.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Surface_mesh.h>

#include <map>

#include "geometry/surface/surface_query.h"

namespace mv {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

std::size_t at(long i) { return static_cast<std::size_t>(i); }

struct Face {
  int a, b, c;
  Face(int i, int j, int k) : a(i), b(j), c(k) {}
};

}  // namespace

bool fill_hole(Soup& s, const std::vector<int>& rim) {
  std::vector<Kernel::Point_3> polyline;
  for (int v : rim) polyline.emplace_back(s.points[at(v)].x(), s.points[at(v)].y(), s.points[at(v)].z());
  std::vector<Face> faces;
  try {
    PMP::triangulate_hole_polyline(polyline, std::back_inserter(faces));
  } catch (const std::exception&) {
    return false;
  }
  if (faces.size() + 2 != rim.size()) return false;
  for (const Face& f : faces) {
    // The rim runs along the surface's own triangles: the patch runs against it.
    s.triangles.push_back({rim[at(f.a)], rim[at(f.c)], rim[at(f.b)]});
    s.group.push_back(-1);
  }
  return true;
}

bool remove_self_intersections(Soup& s) {
  std::vector<Kernel::Point_3> points;
  for (const Vec3& p : s.points) points.emplace_back(p.x(), p.y(), p.z());
  std::vector<std::vector<std::size_t>> triangles;
  for (const auto& t : s.triangles) triangles.push_back({at(t[0]), at(t[1]), at(t[2])});
  if (!PMP::is_polygon_soup_a_polygon_mesh(triangles)) return false;
  Mesh mesh;
  PMP::polygon_soup_to_polygon_mesh(points, triangles, mesh);
  bool done = false;
  try {
    done = PMP::experimental::remove_self_intersections(mesh, PMP::parameters::preserve_genus(true));
  } catch (const std::exception&) {
    return false;
  }
  mesh.collect_garbage();
  Soup out;
  std::map<Mesh::Vertex_index, int> index;
  for (const auto v : mesh.vertices()) {
    index[v] = static_cast<int>(out.points.size());
    out.points.emplace_back(mesh.point(v).x(), mesh.point(v).y(), mesh.point(v).z());
  }
  const SurfaceQuery before(s.points, s.triangles);
  for (const auto f : mesh.faces()) {
    std::array<int, 3> t{};
    std::size_t k = 0;
    Vec3 middle = Vec3::Zero();
    for (const auto v : mesh.vertices_around_face(mesh.halfedge(f))) {
      t[k++] = index[v];
      middle += out.points[at(index[v])] / 3;
    }
    out.triangles.push_back(t);
    out.group.push_back(s.group[at(before.nearest(middle).triangle)]);
  }
  s.points.swap(out.points), s.triangles.swap(out.triangles), s.group.swap(out.group);
  return done;
}

}  // namespace mv
