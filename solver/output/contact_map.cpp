// SPDX-License-Identifier: BSD-3-Clause
#include "solver/output/contact_map.h"

#include <vtkCellArray.h>
#include <vtkIdList.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include "geometry/core/leaflet_names.h"
#include "geometry/core/unfolded.h"
#include "solver/output/vtk_helpers.h"

namespace mv {

namespace {

// Faces of a tetrahedron of positive volume (VTK corner order), wound so that the normal points out; for the quadratic element
// the middle node of each face edge follows in the same order.
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
    std::array<int, 3> key;
    int element, local;
  };
  std::vector<Face> faces;
  faces.reserve(4 * mesh.tets.size());
  for (std::size_t e = 0; e < mesh.tets.size(); ++e)
    for (int f = 0; f < 4; ++f) {
      std::array<int, 3> key;
      for (std::size_t k = 0; k < 3; ++k) key[k] = mesh.tets[e][static_cast<std::size_t>(face_corners[f][k])];
      if (!accept(key[0], key[1], key[2])) continue;
      std::sort(key.begin(), key.end());
      faces.push_back({key, static_cast<int>(e), f});
    }
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) { return a.key < b.key; });
  FaceTriangles out;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const Face& face = faces[i];
    const bool is_shared = (i > 0 && faces[i - 1].key == face.key) || (i + 1 < faces.size() && faces[i + 1].key == face.key);
    if (is_shared) continue;
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

}  // namespace

FaceTriangles faces_on_side(const LeafletMesh& mesh, int side) {
  const auto on_side = [&](int a) { return mesh.side[static_cast<std::size_t>(a)] == side; };
  return collect_faces(mesh, [&](int a, int b, int c) { return on_side(a) && on_side(b) && on_side(c); });
}

FaceTriangles boundary_faces(const LeafletMesh& mesh) {
  return collect_faces(mesh, [](int, int, int) { return true; });
}

ContactMap make_contact_map(const LeafletMesh& mesh, std::span<const double> contact_pressures,
                            std::span<const double> contact_forces, std::span<const double> gaps, std::span<const char> in_belt) {
  const std::size_t np = mesh.points.size();
  if (contact_pressures.size() != np || contact_forces.size() != 3 * np || gaps.size() != np ||
      (!in_belt.empty() && in_belt.size() != np))
    throw std::logic_error("contact map: sizes of the point data do not match the mesh");
  const double period = unfolded_period(mesh);

  ContactMap map;
  std::map<std::pair<int, bool>, int> index;  // (mesh point, drawn beyond the seam) -> map point
  const auto map_point = [&](int p, bool is_beyond, int region) {
    const auto [at, is_new] = index.try_emplace({p, is_beyond}, static_cast<int>(map.points.size()));
    if (is_new) {
      const auto i = static_cast<std::size_t>(p);
      map.points.push_back(mesh.unfolded[i] + Vec2(is_beyond ? period : 0.0, 0));
      map.contact_pressure.push_back(contact_pressures[i] * 1e-3);
      map.contact_force.push_back(Vec3(contact_forces[3 * i], contact_forces[3 * i + 1], contact_forces[3 * i + 2]).norm());
      map.gap.push_back(gaps[i] * 1e3);
      map.region.push_back(region);
      map.mesh_point.push_back(p);
      if (!in_belt.empty()) map.in_belt.push_back(in_belt[i]);
    }
    return at->second;
  };
  const FaceTriangles faces = faces_on_side(mesh, atrial);
  for (std::size_t f = 0; f < faces.triangles.size(); ++f) {
    const auto& t = faces.triangles[f];
    const auto u = [&](int p) { return mesh.unfolded[static_cast<std::size_t>(p)].x(); };
    const double highest = std::max({u(t[0]), u(t[1]), u(t[2])});
    std::array<int, 3> mapped;
    for (std::size_t k = 0; k < 3; ++k) {
      const bool is_beyond = period > 0 && highest - u(t[k]) > period / 2;
      mapped[k] = map_point(t[k], is_beyond, mesh.region[static_cast<std::size_t>(faces.element[f])]);
    }
    map.triangles.push_back(mapped);
  }
  return map;
}

void write_contact_map(const std::filesystem::path& file, const ContactMap& map) {
  vtkNew<vtkPolyData> data;
  add_units(data, {{"points", "mm"}});
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
  const std::size_t count = map.points.size();
  vtkFieldData* at_points = data->GetPointData();
  const auto numbers = [&](const std::vector<double>& values, const char* name, const char* unit) {
    vtk::add_array<vtkDoubleArray>(data, at_points, name, unit, 1, count, [&](auto i) { return values[i]; });
  };
  numbers(map.contact_pressure, "contact_pressure_kPa", "kPa");
  numbers(map.contact_force, "contact_force_N", "N");
  numbers(map.gap, "gap_mm", "mm");
  vtk::add_array<vtkIntArray>(data, at_points, "region", "1", 1, count, [&](auto i) { return map.region[i]; });
  vtk::add_array<vtkIntArray>(data, at_points, "mesh_point", "1", 1, count, [&](auto i) { return map.mesh_point[i]; });
  if (!map.in_belt.empty())
    vtk::add_array<vtkUnsignedCharArray>(data, at_points, "in_belt", "1", 1, count, [&](auto i) { return map.in_belt[i] != 0; });
  write_vtk(file, data);
}

ContactMap read_contact_map(const std::filesystem::path& file) {
  using Place = DatasetReader::Place;
  const auto data = read_poly_data(file);
  const DatasetReader in(file, data);
  const long np = data->GetNumberOfPoints();
  if (np == 0 || data->GetNumberOfCells() == 0) in.fail("points", "is empty");
  ContactMap map;
  for (const Vec3& p : vtk::to_vectors(in.coordinates())) map.points.emplace_back(p.x(), p.y());
  vtkNew<vtkIdList> ids;
  for (vtkIdType c = 0; c < data->GetNumberOfCells(); ++c) {
    data->GetCellPoints(c, ids);
    if (ids->GetNumberOfIds() != 3) in.fail("polys", "is not a triangle at cell " + std::to_string(c));
    std::array<int, 3> t;
    for (std::size_t k = 0; k < 3; ++k) {
      const vtkIdType id = ids->GetId(static_cast<vtkIdType>(k));
      if (id < 0 || id >= np) in.fail("polys", "names a missing point in cell " + std::to_string(c));
      t[k] = static_cast<int>(id);
    }
    map.triangles.push_back(t);
  }
  constexpr long largest = std::numeric_limits<int>::max();
  map.contact_pressure = in.reals(Place::points, "contact_pressure_kPa", 1, np);
  map.contact_force = in.reals(Place::points, "contact_force_N", 1, np);
  // NaN is an answer here (nothing faces the point), so the general check for finite values does not apply
  vtkDataArray* gap = data->GetPointData()->GetArray("gap_mm");
  if (gap == nullptr || gap->GetNumberOfComponents() != 1) in.fail("gap_mm", "is missing or not a scalar");
  for (vtkIdType i = 0; i < np; ++i) map.gap.push_back(gap->GetComponent(i, 0));
  map.region = in.integers(Place::points, "region", posterior, last_region, 1, np);
  map.mesh_point = in.integers(Place::points, "mesh_point", 0, largest, 1, np);
  if (in.has(Place::points, "in_belt")) {
    const std::vector<int> belt = in.integers(Place::points, "in_belt", 0, 1, 1, np);
    map.in_belt.assign(belt.begin(), belt.end());
  }
  return map;
}

}  // namespace mv
