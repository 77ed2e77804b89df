// SPDX-License-Identifier: BSD-3-Clause
#include "solver/output/frame_reader.h"

#include <vtkCellType.h>
#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkPolyData.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLImageDataReader.h>
#include <vtkXMLPolyDataReader.h>
#include <vtkXMLUnstructuredGridReader.h>

#include "solver/output/vtk_helpers.h"

namespace mv {

namespace fs = std::filesystem;

namespace {

Vec3 field_vector(vtkFieldData* field, const char* name, const Vec3& fallback) {
  vtkDataArray* array = field->GetArray(name);
  if (array == nullptr || array->GetNumberOfValues() != 3) return fallback;
  Vec3 v;
  for (int i = 0; i < 3; ++i) v[i] = array->GetComponent(i / array->GetNumberOfComponents(), i % array->GetNumberOfComponents());
  return v;
}

}  // namespace

LeafletsFrame read_leaflets_frame(const fs::path& file) {
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  vtk::run_reader(reader.Get(), file);
  vtkUnstructuredGrid* grid = reader->GetOutput();
  const std::ptrdiff_t np = grid->GetNumberOfPoints(), nt = grid->GetNumberOfCells();
  if (np == 0 || nt == 0) throw InputError(file.string() + ": no points or no elements (damaged or incomplete?)");

  LeafletsFrame frame;
  frame.time = vtk::field_number(grid->GetFieldData(), "TimeValue", 0);
  frame.annulus_origin = field_vector(grid->GetFieldData(), "annulus_origin", frame.annulus_origin);
  frame.annulus_normal = field_vector(grid->GetFieldData(), "annulus_normal", frame.annulus_normal);

  LeafletMesh& mesh = frame.mesh;
  mesh.order = grid->GetCellType(0) == VTK_QUADRATIC_TETRA ? 2 : 1;
  const int expected_type = mesh.order == 2 ? VTK_QUADRATIC_TETRA : VTK_TETRA;
  mesh.points.resize(static_cast<std::size_t>(np));
  for (std::ptrdiff_t i = 0; i < np; ++i) {
    Vec3& x = mesh.points[static_cast<std::size_t>(i)];
    grid->GetPoint(i, x.data());
    if (!x.allFinite()) throw InputError(file.string() + ": point " + std::to_string(i) + " is not finite");
  }
  mesh.tets.resize(static_cast<std::size_t>(nt));
  for (std::ptrdiff_t i = 0; i < nt; ++i) {
    if (grid->GetCellType(i) != expected_type) throw InputError(file.string() + ": cell " + std::to_string(i) + " is not a tetrahedron");
    vtkIdType count = 0;
    const vtkIdType* ids = nullptr;
    grid->GetCellPoints(i, count, ids);
    auto& tet = mesh.tets[static_cast<std::size_t>(i)];
    tet.fill(-1);
    for (vtkIdType k = 0; k < count; ++k) {
      if (ids[k] < 0 || ids[k] >= np) throw InputError(file.string() + ": element " + std::to_string(i) + " names a missing point");
      tet[static_cast<std::size_t>(k)] = static_cast<int>(ids[k]);
    }
  }

  vtkFieldData *at_points = grid->GetPointData(), *at_cells = grid->GetCellData();
  frame.displacement = vtk::vectors_of(vtk::find_array(at_points, file, "displacement", 3, np, true));
  mesh.on_annulus = vtk::scalars_of<char>(vtk::find_array(at_points, file, "annulus", 1, np, true));
  mesh.on_free_edge = vtk::scalars_of<char>(vtk::find_array(at_points, file, "free_edge", 1, np, true));
  mesh.side = vtk::scalars_of<int>(vtk::find_array(at_points, file, "side", 1, np, true));
  mesh.region = vtk::scalars_of<int>(vtk::find_array(at_cells, file, "region", 1, nt, true));
  mesh.layer = vtk::scalars_of<int>(vtk::find_array(at_cells, file, "layer", 1, nt, false));
  if (vtkDataArray* unfolded = vtk::find_array(at_points, file, "unfolded", 2, np, false)) {
    mesh.unfolded.resize(static_cast<std::size_t>(np));
    for (std::ptrdiff_t i = 0; i < np; ++i)
      mesh.unfolded[static_cast<std::size_t>(i)] = {unfolded->GetComponent(i, 0), unfolded->GetComponent(i, 1)};
  }
  frame.contact_force = vtk::vectors_of(vtk::find_array(at_points, file, "contact_force", 3, np, false));
  frame.contact_pressure = vtk::scalars_of<double>(vtk::find_array(at_points, file, "contact_pressure", 1, np, false));
  frame.von_mises = vtk::scalars_of<double>(vtk::find_array(at_cells, file, "von_mises", 1, nt, false));
  return frame;
}

ChordaeFrame read_chordae_frame(const fs::path& file) {
  vtkNew<vtkXMLPolyDataReader> reader;
  vtk::run_reader(reader.Get(), file);
  vtkPolyData* data = reader->GetOutput();
  const std::ptrdiff_t np = data->GetNumberOfPoints(), count = data->GetNumberOfCells();
  ChordaeFrame frame;
  frame.time = vtk::field_number(data->GetFieldData(), "TimeValue", 0);
  frame.points.resize(static_cast<std::size_t>(np));
  for (std::ptrdiff_t i = 0; i < np; ++i) data->GetPoint(i, frame.points[static_cast<std::size_t>(i)].data());
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    vtkIdType n = 0;
    const vtkIdType* ids = nullptr;
    data->GetCellPoints(i, n, ids);
    if (n != 2) throw InputError(file.string() + ": cell " + std::to_string(i) + " is not a line of two points");
    for (int k = 0; k < 2; ++k)
      if (ids[k] < 0 || ids[k] >= np) throw InputError(file.string() + ": line " + std::to_string(i) + " names a missing point");
    frame.segments.push_back({static_cast<int>(ids[0]), static_cast<int>(ids[1])});
  }
  for (int k : vtk::scalars_of<int>(vtk::find_array(data->GetCellData(), file, "kind", 1, count, true)))
    frame.kind.push_back(static_cast<ChordaKind>(k));
  frame.tension = vtk::scalars_of<double>(vtk::find_array(data->GetCellData(), file, "tension", 1, count, false));
  return frame;
}

FluidFrame read_fluid_frame(const fs::path& file) {
  vtkNew<vtkXMLImageDataReader> reader;
  vtk::run_reader(reader.Get(), file);
  vtkImageData* image = reader->GetOutput();
  FluidFrame frame;
  frame.time = vtk::field_number(image->GetFieldData(), "TimeValue", 0);
  int dimensions[3];
  image->GetDimensions(dimensions);
  for (std::size_t i = 0; i < 3; ++i) frame.cells[i] = dimensions[i] - 1;
  image->GetOrigin(frame.lower.data());
  frame.spacing = image->GetSpacing()[0];
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) frame.axes(c, r) = image->GetDirectionMatrix()->GetElement(r, c);
  const std::ptrdiff_t count = image->GetNumberOfCells();
  frame.velocity = vtk::vectors_of(vtk::find_array(image->GetCellData(), file, "velocity", 3, count, true));
  frame.pressure = vtk::scalars_of<double>(vtk::find_array(image->GetCellData(), file, "pressure", 1, count, true));
  frame.inside = vtk::scalars_of<char>(vtk::find_array(image->GetCellData(), file, "inside", 1, count, false));
  return frame;
}

}  // namespace mv
