// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/image/flying_edges.h"

#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkFlyingEdges3D.h>
#include <vtkIdList.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

#include <cmath>

namespace mv {

GridSurface flying_edges(const std::array<int, 3>& size, const std::vector<float>& field, double level, double clearance) {
  vtkNew<vtkImageData> grid;
  grid->SetDimensions(size[0], size[1], size[2]);
  vtkNew<vtkFloatArray> values;
  values->SetNumberOfTuples(static_cast<vtkIdType>(field.size()));
  for (std::size_t v = 0; v < field.size(); ++v) {
    const double above = field[v] - level;
    const double kept = std::abs(above) >= clearance ? above : above >= 0 ? clearance : -clearance;
    values->SetValue(static_cast<vtkIdType>(v), static_cast<float>(kept));
  }
  grid->GetPointData()->SetScalars(values);
  vtkNew<vtkFlyingEdges3D> filter;
  filter->SetInputData(grid);
  filter->SetValue(0, 0.0);
  filter->ComputeNormalsOff();
  filter->ComputeGradientsOff();
  filter->ComputeScalarsOff();
  filter->Update();
  vtkPolyData* surface = filter->GetOutput();
  GridSurface out;
  out.points.reserve(static_cast<std::size_t>(surface->GetNumberOfPoints()));
  for (vtkIdType p = 0; p < surface->GetNumberOfPoints(); ++p) out.points.emplace_back(Vec3(surface->GetPoint(p)));
  vtkNew<vtkIdList> ids;
  auto* cells = surface->GetPolys();
  for (cells->InitTraversal(); cells->GetNextCell(ids);)
    out.triangles.push_back({static_cast<int>(ids->GetId(0)), static_cast<int>(ids->GetId(1)), static_cast<int>(ids->GetId(2))});
  return out;
}

}  // namespace mv
