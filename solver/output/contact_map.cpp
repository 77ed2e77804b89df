// SPDX-License-Identifier: BSD-3-Clause
#include "solver/output/contact_map.h"

#include <vtkPolyData.h>
#include <vtkXMLPolyDataReader.h>
#include <vtkXMLPolyDataWriter.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "geometry/core/case_files.h"
#include "solver/output/vtk_helpers.h"

namespace mv {

namespace {

// Faces of a tetrahedron of positive volume (VTK corner order), wound so that the normal points out; for the quadratic element the
// middle node of each face edge follows in the same order.
constexpr int face_corners[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
constexpr int face_midpoints[4][3] = {{6, 5, 4}, {4, 8, 7}, {5, 9, 8}, {7, 9, 6}};

double signed_volume(const LeafletMesh& mesh, const std::array<int, 10>& tet) {
  const auto x = [&](int k) -> const Vec3& { return mesh.points[static_cast<std::size_t>(tet[static_cast<std::size_t>(k)])]; };
  return (x(1) - x(0)).cross(x(2) - x(0)).dot(x(3) - x(0)) / 6;
}

/// Boundary faces for which accept(corner a, b, c) holds.
template <class Accept>
FaceTriangles collect_faces(const LeafletMesh& mesh, Accept&& accept) {
  struct Face {
    int count = 0;
    int element = 0;
    int local = 0;
  };
  std::map<std::array<int, 3>, Face> faces;
  for (std::size_t e = 0; e < mesh.tets.size(); ++e)
    for (int f = 0; f < 4; ++f) {
      std::array<int, 3> key;
      for (std::size_t k = 0; k < 3; ++k) key[k] = mesh.tets[e][static_cast<std::size_t>(face_corners[f][k])];
      if (!accept(key[0], key[1], key[2])) continue;
      std::sort(key.begin(), key.end());
      Face& face = faces[key];
      ++face.count;
      face.element = static_cast<int>(e);
      face.local = f;
    }
  FaceTriangles out;
  for (const auto& [key, face] : faces) {
    if (face.count != 1) continue;
    const auto& tet = mesh.tets[static_cast<std::size_t>(face.element)];
    const bool is_inverted = signed_volume(mesh, tet) < 0;
    const auto add = [&](int a, int b, int c) {
      if (is_inverted) std::swap(b, c);
      out.triangles.push_back({a, b, c});
      out.element.push_back(face.element);
    };
    const auto node = [&](int k) { return tet[static_cast<std::size_t>(k)]; };
    const int* c = face_corners[face.local];
    if (mesh.order == 1) {
      add(node(c[0]), node(c[1]), node(c[2]));
    } else {
      const int* m = face_midpoints[face.local];
      add(node(c[0]), node(m[0]), node(m[2]));
      add(node(m[0]), node(c[1]), node(m[1]));
      add(node(m[2]), node(m[1]), node(c[2]));
      add(node(m[0]), node(m[1]), node(m[2]));
    }
  }
  return out;
}

/// Length of the closed pattern: the extent of u along the annulus plus the edge that closes it, taken as long in u as its
/// neighbours are for their length in space.
double estimate_pattern_length(const LeafletMesh& mesh, const FaceTriangles& faces, double u_min, double u_max) {
  double u_inside = 0, x_inside = 0, x_seam = 0;
  int seam_edges = 0;
  const double half = (u_max - u_min) / 2;
  for (const auto& t : faces.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto a = static_cast<std::size_t>(t[k]), b = static_cast<std::size_t>(t[(k + 1) % 3]);
      if (mesh.on_annulus[a] == 0 || mesh.on_annulus[b] == 0) continue;
      const double du = std::abs(mesh.unfolded[a].x() - mesh.unfolded[b].x());
      const double dx = (mesh.points[a] - mesh.points[b]).norm();
      if (du > half) {
        x_seam += dx;
        ++seam_edges;
      } else {
        u_inside += du;
        x_inside += dx;
      }
    }
  const double seam = seam_edges > 0 && x_inside > 0 ? x_seam / seam_edges * u_inside / x_inside : 0;
  return u_max - u_min + seam;
}

}  // namespace

FaceTriangles faces_on_side(const LeafletMesh& mesh, int side) {
  const auto on_side = [&](int a) { return mesh.side[static_cast<std::size_t>(a)] == side; };
  return collect_faces(mesh, [&](int a, int b, int c) { return on_side(a) && on_side(b) && on_side(c); });
}

FaceTriangles boundary_faces(const LeafletMesh& mesh) {
  return collect_faces(mesh, [](int, int, int) { return true; });
}

ContactMap make_contact_map(const LeafletMesh& mesh, std::span<const double> contact_pressures, std::span<const Vec3> contact_forces,
                            std::span<const double> gaps, std::span<const char> in_belt, double pattern_length) {
  const FaceTriangles faces = faces_on_side(mesh, atrial);
  double u_min = std::numeric_limits<double>::infinity(), u_max = -u_min;
  for (const auto& t : faces.triangles)
    for (int p : t) {
      u_min = std::min(u_min, mesh.unfolded[static_cast<std::size_t>(p)].x());
      u_max = std::max(u_max, mesh.unfolded[static_cast<std::size_t>(p)].x());
    }
  if (pattern_length <= 0) pattern_length = estimate_pattern_length(mesh, faces, u_min, u_max);
  const double half = (u_max - u_min) / 2;

  ContactMap map;
  std::map<std::pair<int, int>, int> index;  // (mesh point, shifts) -> map point
  const auto map_point = [&](int p, int shift, int region) {
    const auto [at, is_new] = index.try_emplace({p, shift}, static_cast<int>(map.points.size()));
    if (is_new) {
      const auto i = static_cast<std::size_t>(p);
      map.points.push_back(mesh.unfolded[i] + Vec2(shift * pattern_length, 0));
      map.contact_pressure.push_back(contact_pressures[i] * 1e-3);
      map.contact_force.push_back(contact_forces[i].norm());
      map.gap.push_back(gaps[i] * 1e3);
      map.region.push_back(region);
      map.mesh_point.push_back(p);
      if (!in_belt.empty()) map.in_belt.push_back(in_belt[i]);
    }
    return at->second;
  };
  for (std::size_t f = 0; f < faces.triangles.size(); ++f) {
    const auto& t = faces.triangles[f];
    double highest = -std::numeric_limits<double>::infinity();
    for (int p : t) highest = std::max(highest, mesh.unfolded[static_cast<std::size_t>(p)].x());
    std::array<int, 3> mapped;
    for (std::size_t k = 0; k < 3; ++k) {
      const bool is_beyond_seam = highest - mesh.unfolded[static_cast<std::size_t>(t[k])].x() > half;
      mapped[k] = map_point(t[k], is_beyond_seam ? 1 : 0, mesh.region[static_cast<std::size_t>(faces.element[f])]);
    }
    map.triangles.push_back(mapped);
  }
  return map;
}

void write_contact_map(const std::filesystem::path& file, const ContactMap& map) {
  vtkNew<vtkPolyData> data;
  vtk::add_text(data->GetFieldData(), "UnitSystem", "mm");
  vtk::add_text(data->GetFieldData(), "SPACE", "unfolded");
  vtk::add_text(data->GetFieldData(), "unit:points", "mm");
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (const Vec2& p : map.points) points->InsertNextPoint(p.x(), p.y(), 0);
  data->SetPoints(points);
  vtkNew<vtkCellArray> triangles;
  for (const auto& t : map.triangles) {
    const vtkIdType ids[3] = {t[0], t[1], t[2]};
    triangles->InsertNextCell(3, ids);
  }
  data->SetPolys(triangles);
  const auto count = static_cast<std::ptrdiff_t>(map.points.size());
  const auto u = [](std::ptrdiff_t i) { return static_cast<std::size_t>(i); };
  auto* at_points = data->GetPointData();
  using Double = vtkDoubleArray;
  vtk::add_scalars<Double>(data, at_points, "contact_pressure_kPa", "kPa", count, [&](auto i) { return map.contact_pressure[u(i)]; });
  vtk::add_scalars<Double>(data, at_points, "contact_force_N", "N", count, [&](auto i) { return map.contact_force[u(i)]; });
  vtk::add_scalars<Double>(data, at_points, "gap_mm", "mm", count,
                           [&](auto i) { return std::isfinite(map.gap[u(i)]) ? map.gap[u(i)] : std::numeric_limits<double>::quiet_NaN(); });
  vtk::add_scalars<vtkIntArray>(data, at_points, "region", "1", count, [&](auto i) { return map.region[u(i)]; });
  vtk::add_scalars<vtkIntArray>(data, at_points, "mesh_point", "1", count, [&](auto i) { return map.mesh_point[u(i)]; });
  if (!map.in_belt.empty())
    vtk::add_scalars<vtkUnsignedCharArray>(data, at_points, "in_belt", "1", count, [&](auto i) { return map.in_belt[u(i)] != 0; });
  write_text_atomically(file, vtk::to_bytes<vtkXMLPolyDataWriter>(data));
}

ContactMap read_contact_map(const std::filesystem::path& file) {
  vtkNew<vtkXMLPolyDataReader> reader;
  vtk::run_reader(reader.Get(), file);
  vtkPolyData* data = reader->GetOutput();
  const std::ptrdiff_t np = data->GetNumberOfPoints();
  if (np == 0 || data->GetNumberOfCells() == 0) throw InputError(file.string() + ": the contact map is empty (damaged or incomplete?)");
  ContactMap map;
  for (std::ptrdiff_t i = 0; i < np; ++i) {
    const double* p = data->GetPoint(i);
    if (!std::isfinite(p[0]) || !std::isfinite(p[1])) throw InputError(file.string() + ": point " + std::to_string(i) + " is not finite");
    map.points.emplace_back(p[0], p[1]);
  }
  for (vtkIdType i = 0; i < data->GetNumberOfCells(); ++i) {
    vtkIdType n = 0;
    const vtkIdType* ids = nullptr;
    data->GetCellPoints(i, n, ids);
    if (n != 3) throw InputError(file.string() + ": cell " + std::to_string(i) + " is not a triangle");
    std::array<int, 3> t;
    for (std::size_t k = 0; k < 3; ++k) {
      if (ids[k] < 0 || ids[k] >= np) throw InputError(file.string() + ": triangle " + std::to_string(i) + " names a missing point");
      t[k] = static_cast<int>(ids[k]);
    }
    map.triangles.push_back(t);
  }
  vtkFieldData* at_points = data->GetPointData();
  map.contact_pressure = vtk::scalars_of<double>(vtk::find_array(at_points, file, "contact_pressure_kPa", 1, np, true));
  map.contact_force = vtk::scalars_of<double>(vtk::find_array(at_points, file, "contact_force_N", 1, np, true));
  map.gap = vtk::scalars_of<double>(vtk::find_array(at_points, file, "gap_mm", 1, np, true, true));
  map.region = vtk::scalars_of<int>(vtk::find_array(at_points, file, "region", 1, np, true));
  map.mesh_point = vtk::scalars_of<int>(vtk::find_array(at_points, file, "mesh_point", 1, np, false));
  map.in_belt = vtk::scalars_of<char>(vtk::find_array(at_points, file, "in_belt", 1, np, false));
  return map;
}

}  // namespace mv
