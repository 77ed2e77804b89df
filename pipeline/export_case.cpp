// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/export_case.h"

#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkFieldData.h>
#include <vtkPointData.h>
#include <vtkPointSet.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkUnstructuredGrid.h>

#include "geometry/core/errors.h"
#include "geometry/core/vtk_dataset.h"
#include "pipeline/case_directory.h"

namespace mv {
namespace {

constexpr const char* files[] = {"mid_surface.vtp", "annulus.vtp", "papillary.vtp", "leaflets.vtu", "chordae.vtp", "tube.vtu"};

/// Three numbers that are no vector of the files' space: the tube's grid is given in the tube's frame.
bool is_in_tube_frame(const std::string& name) { return name == "grid_lower"; }

/// RAS and LPS differ by half a turn about the third axis. Rows of three (vectors) or nine (rows of a matrix of unit vectors).
void turn(vtkDataArray* array) {
  const int components = array->GetNumberOfComponents();
  for (vtkIdType i = 0; i < array->GetNumberOfTuples(); ++i) {
    for (int k = 0; k < components; ++k) {
      if (k % 3 != 2) array->SetComponent(i, k, -array->GetComponent(i, k));
    }
  }
}

void turn_vectors(vtkFieldData* fields) {
  for (int a = 0; a < fields->GetNumberOfArrays(); ++a) {
    vtkDataArray* array = fields->GetArray(a);
    if (!array || (array->GetDataType() != VTK_DOUBLE && array->GetDataType() != VTK_FLOAT)) continue;
    const int components = array->GetNumberOfComponents();
    if ((components == 3 || components == 9) && !is_in_tube_frame(array->GetName())) turn(array);
  }
}

void turn_to_lps(vtkPointSet* data) {
  turn(data->GetPoints()->GetData());
  turn_vectors(data->GetPointData());
  turn_vectors(data->GetCellData());
  turn_vectors(data->GetFieldData());
  data->GetFieldData()->RemoveArray("SPACE");
  add_texts(data->GetFieldData(), "SPACE", {"LPS"});
}

}  // namespace

std::vector<std::filesystem::path> export_case(const std::filesystem::path& case_directory, const std::filesystem::path& directory,
                    const std::string& space) {
  read_case_config(case_directory);
  std::error_code failure;
  std::filesystem::create_directories(directory, failure);
  if (!std::filesystem::is_directory(directory)) throw IoError("cannot create the directory " + directory.string());
  if (std::filesystem::equivalent(case_directory, directory))
    throw UsageError("-o names the case itself: expected another directory");
  std::vector<std::filesystem::path> written;
  for (const char* name : files) {
    const auto file = case_directory / name;
    if (!std::filesystem::exists(file)) continue;
    const auto data = file.extension() == ".vtu" ? vtkSmartPointer<vtkPointSet>(read_unstructured_grid(file))
                                                 : vtkSmartPointer<vtkPointSet>(read_poly_data(file));
    if (space == "LPS") turn_to_lps(data);
    write_vtk(directory / name, data);
    written.push_back(directory / name);
  }
  return written;
}

}  // namespace mv
