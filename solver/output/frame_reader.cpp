// SPDX-License-Identifier: BSD-3-Clause
#include "solver/output/frame_reader.h"

#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkFieldData.h>
#include <vtkIdList.h>
#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLImageDataReader.h>

#include <limits>
#include <string>

#include "geometry/core/leaflet_names.h"
#include "geometry/core/errors.h"
#include "solver/output/vtk_helpers.h"

namespace mv {

namespace fs = std::filesystem;

namespace {

using Place = DatasetReader::Place;
constexpr long any = -1;
constexpr long largest = std::numeric_limits<int>::max();

double time_of(const DatasetReader& in) { return in.reals(Place::field, "TimeValue", 1, 1)[0]; }

std::vector<char> flags(const DatasetReader& in, const std::string& name, long count) {
  const std::vector<int> values = in.integers(Place::points, name, 0, 1, 1, count);
  return {values.begin(), values.end()};
}

std::vector<double> optional_reals(const DatasetReader& in, Place place, const std::string& name, int components, long count) {
  return in.has(place, name) ? in.reals(place, name, components, count) : std::vector<double>{};
}

}  // namespace

LeafletsFrame read_leaflets_frame(const fs::path& file) {
  const auto grid = read_unstructured_grid(file);
  const DatasetReader in(file, grid);
  const long np = grid->GetNumberOfPoints(), nt = grid->GetNumberOfCells();
  if (np == 0 || nt == 0) in.fail("points", "is empty");

  LeafletsFrame frame;
  frame.time = time_of(in);
  frame.annulus_origin = vtk::to_vectors(in.reals(Place::field, "annulus_origin", 3, 1))[0];
  frame.annulus_normal = vtk::to_vectors(in.reals(Place::field, "annulus_normal", 3, 1))[0];

  LeafletMesh& mesh = frame.mesh;
  mesh.order = grid->GetCellType(0) == VTK_QUADRATIC_TETRA ? 2 : 1;
  const int expected_type = mesh.order == 2 ? VTK_QUADRATIC_TETRA : VTK_TETRA;
  mesh.points = vtk::to_vectors(in.coordinates());
  mesh.tets.resize(static_cast<std::size_t>(nt));
  vtkNew<vtkIdList> ids;
  for (long c = 0; c < nt; ++c) {
    if (grid->GetCellType(c) != expected_type) in.fail("types", "is not a tetrahedron at cell " + std::to_string(c));
    grid->GetCellPoints(c, ids);
    auto& tet = mesh.tets[static_cast<std::size_t>(c)];
    tet.fill(-1);
    for (int k = 0; k < mesh.nodes_per_tet(); ++k) {
      if (ids->GetId(k) < 0 || ids->GetId(k) >= np) in.fail("connectivity", "names a missing point in cell " + std::to_string(c));
      tet[static_cast<std::size_t>(k)] = static_cast<int>(ids->GetId(k));
    }
  }
  mesh.on_annulus = flags(in, "annulus", np);
  mesh.on_free_edge = flags(in, "free_edge", np);
  mesh.side = in.integers(Place::points, "side", ventricular, atrial, 1, np);
  mesh.region = in.integers(Place::cells, "region", posterior, last_region, 1, nt);
  mesh.layer = in.integers(Place::cells, "layer", 0, largest, 1, nt);
  const std::vector<double> uv = in.reals(Place::points, "unfolded", 2, np);
  for (std::size_t i = 0; i < uv.size(); i += 2) mesh.unfolded.emplace_back(uv[i], uv[i + 1]);

  frame.displacement = vtk::to_vectors(in.reals(Place::points, "displacement", 3, np));
  frame.contact_force = vtk::to_vectors(optional_reals(in, Place::points, "contact_force", 3, np));
  frame.contact_pressure = optional_reals(in, Place::points, "contact_pressure", 1, np);
  frame.von_mises = optional_reals(in, Place::cells, "von_mises", 1, nt);
  frame.fibre_stress = optional_reals(in, Place::cells, "fibre_stress", 1, nt);
  return frame;
}

ChordaeFrame read_chordae_frame(const fs::path& file) {
  const auto data = read_poly_data(file);
  const DatasetReader in(file, data);
  const long np = data->GetNumberOfPoints(), count = data->GetNumberOfCells();
  ChordaeFrame frame;
  frame.time = time_of(in);
  frame.points = vtk::to_vectors(in.coordinates());
  vtkNew<vtkIdList> ids;
  for (long c = 0; c < count; ++c) {
    data->GetCellPoints(c, ids);
    if (ids->GetNumberOfIds() != 2) in.fail("lines", "is not a line of two points at cell " + std::to_string(c));
    for (vtkIdType k = 0; k < 2; ++k)
      if (ids->GetId(k) < 0 || ids->GetId(k) >= np) in.fail("lines", "names a missing point in cell " + std::to_string(c));
    frame.segments.push_back({static_cast<int>(ids->GetId(0)), static_cast<int>(ids->GetId(1))});
  }
  frame.muscle_of_point = in.integers(Place::points, "muscle_of_point", -1, largest, 1, np);
  for (int k : in.integers(Place::cells, "kind", 0, static_cast<int>(ChordaKind::marginal), 1, count))
    frame.kind.push_back(static_cast<ChordaKind>(k));
  frame.tension = optional_reals(in, Place::cells, "tension", 1, count);
  return frame;
}

FluidFrame read_fluid_frame(const fs::path& file) {
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) throw IoError(file.string() + ": no such file");
  const int display = vtkObject::GetGlobalWarningDisplay();
  vtkObject::GlobalWarningDisplayOff();
  vtkNew<vtkXMLImageDataReader> reader;
  const bool is_image = reader->CanReadFile(file.c_str()) != 0;
  if (is_image) {
    reader->SetFileName(file.c_str());
    reader->Update();
  }
  vtkObject::SetGlobalWarningDisplay(display);
  if (!is_image || reader->GetErrorCode() != 0)
    throw InputError(file.string() + ": not a readable .vti file (damaged or incomplete?)");

  vtkImageData* image = reader->GetOutput();
  const DatasetReader in(file, image);
  FluidFrame frame;
  frame.time = time_of(in);
  int dimensions[3];
  image->GetDimensions(dimensions);
  for (std::size_t i = 0; i < 3; ++i) frame.cells[i] = dimensions[i] - 1;
  image->GetOrigin(frame.lower.data());
  frame.spacing = image->GetSpacing()[0];
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) frame.axes(c, r) = image->GetDirectionMatrix()->GetElement(r, c);
  const long count = image->GetNumberOfCells();
  frame.velocity = vtk::to_vectors(in.reals(Place::cells, "velocity", 3, count));
  frame.pressure = in.reals(Place::cells, "pressure", 1, count);
  if (in.has(Place::cells, "inside")) {
    const std::vector<int> inside = in.integers(Place::cells, "inside", 0, 1, 1, count);
    frame.inside.assign(inside.begin(), inside.end());
  }
  return frame;
}

}  // namespace mv
