// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <vtkCallbackCommand.h>
#include <vtkCell.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDataSet.h>
#include <vtkFieldData.h>
#include <vtkGenericDataObjectReader.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkStringArray.h>

#include <cmath>
#include <map>
#include <new>
#include <stdexcept>

#include "geometry/core/errors.h"
#include "geometry/core/vtk_dataset.h"
#include "geometry/surface/surface_formats.h"

namespace mv {
namespace {

vtkSmartPointer<vtkDataSet> read_legacy(const std::string& file) {
  vtkNew<vtkGenericDataObjectReader> reader;
  bool failed = false;
  vtkNew<vtkCallbackCommand> on_error;
  on_error->SetClientData(&failed);
  on_error->SetCallback([](vtkObject*, unsigned long, void* flag, void*) { *static_cast<bool*>(flag) = true; });
  reader->AddObserver("ErrorEvent", on_error);
  reader->SetFileName(file.c_str());
  try {
    reader->Update();
  } catch (const std::bad_alloc&) {
    failed = true;
  } catch (const std::length_error&) {
    failed = true;
  }
  vtkSmartPointer<vtkDataSet> data = vtkDataSet::SafeDownCast(reader->GetOutput());
  if (failed || !data) throw InputError("surface: " + file + ": damaged, truncated or no legacy VTK data set; export it again");
  return data;
}

/// First cell array whose name tells that it holds labels.
vtkDataArray* labels_of(vtkDataSet* data) {
  for (const char* name : {"region", "label", "labels", "leaflet", "Label", "Leaflet", "ModelFaceID", "GroupIds", "material"}) {
    vtkDataArray* array = data->GetCellData()->GetArray(name);
    if (array && array->GetNumberOfComponents() == 1 && array->GetNumberOfTuples() == data->GetNumberOfCells()) return array;
  }
  return nullptr;
}

}  // namespace

RawSurface parse_vtk(const std::filesystem::path& file, bool is_xml, std::string& unit) {
  vtkSmartPointer<vtkDataSet> data;
  if (is_xml)
    data = read_foreign_poly_data(file);
  else
    data = read_legacy(file.string());
  if (auto* text = vtkStringArray::SafeDownCast(data->GetFieldData()->GetAbstractArray("unit:points")))
    if (text->GetNumberOfValues() > 0) unit = text->GetValue(0);
  RawSurface s;
  const vtkIdType n = data->GetNumberOfPoints();
  for (vtkIdType i = 0; i < n; ++i) {
    Vec3 p;
    data->GetPoint(i, p.data());
    if (!p.allFinite()) throw InputError(fmt::format("surface: {}: point {} is not finite", file.string(), i));
    s.points.push_back(p);
  }
  vtkDataArray* labels = labels_of(data);
  std::map<long, int> groups;
  long polygons = 0;
  std::map<int, long> ignored;
  for (vtkIdType c = 0; c < data->GetNumberOfCells(); ++c) {
    vtkCell* cell = data->GetCell(c);
    const int type = cell->GetCellType();
    if (cell->GetCellDimension() != 2) {
      ++ignored[type];
      continue;
    }
    std::vector<int> corners;
    for (vtkIdType k = 0; k < cell->GetNumberOfPoints(); ++k) {
      const vtkIdType id = cell->GetPointId(static_cast<int>(k));
      if (id < 0 || id >= n) throw InputError(fmt::format("surface: {}: cell {} refers to point {} of {}", file.string(), c, id, n));
      corners.push_back(static_cast<int>(id));
    }
    int group = -1;
    if (labels) {
      const double value = labels->GetComponent(c, 0);
      if (!std::isfinite(value) || std::abs(value) > 1e9)
        throw InputError(fmt::format("surface: {}: cell {} has the label {}", file.string(), c, value));
      group = groups.try_emplace(std::lround(value), static_cast<int>(groups.size())).first->second;
      if (group == static_cast<int>(s.group_names.size())) s.group_names.push_back(std::to_string(std::lround(value)));
    }
    if (type == VTK_TRIANGLE_STRIP) {
      for (std::size_t k = 0; k + 2 < corners.size(); ++k)
        add_polygon(s, k % 2 == 0 ? std::vector<int>{corners[k], corners[k + 1], corners[k + 2]}
                                  : std::vector<int>{corners[k + 1], corners[k], corners[k + 2]}, group);
    } else if (type == VTK_TRIANGLE || type == VTK_QUAD || type == VTK_POLYGON) {
      polygons += corners.size() > 3;
      if (corners.size() >= 3) add_polygon(s, corners, group);
    } else if (type == VTK_PIXEL) {
      add_polygon(s, {corners[0], corners[1], corners[3], corners[2]}, group);
    } else {
      ++ignored[type];
    }
  }
  if (polygons > 0) s.notes.push_back(fmt::format("{}: {} polygons cut into triangles", file.string(), polygons));
  for (const auto& [type, count] : ignored)
    s.notes.push_back(fmt::format("{}: {} cells of VTK type {} ignored", file.string(), count, type));
  return s;
}

}  // namespace mv
