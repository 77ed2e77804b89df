// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/source_file.h"

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkFieldData.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

#include "geometry/core/vtk_dataset.h"

namespace mv {
namespace {

using Place = DatasetReader::Place;

const ArrayUnits units = {
    {"points", "mm"}, {"normal", "1"},     {"unfolded", "mm"}, {"annulus", "1"},        {"free_edge", "1"},
    {"region", "1"},  {"perimeter", "mm"}, {"axis", "1"},      {"annulus_curve", "mm"}, {"anterior_direction", "1"},
    {"scale", "1"}};

std::vector<double> flat(const std::vector<Vec3>& vectors) {
  std::vector<double> out;
  for (const Vec3& v : vectors) out.insert(out.end(), v.data(), v.data() + 3);
  return out;
}

std::vector<Vec3> vectors(const std::vector<double>& values) {
  std::vector<Vec3> out;
  for (std::size_t i = 0; i + 2 < values.size(); i += 3) out.emplace_back(values[i], values[i + 1], values[i + 2]);
  return out;
}

}  // namespace

void write_source(const std::filesystem::path& file, const SourceGeometry& source) {
  const MidSurface& surface = source.surface;
  vtkNew<vtkPolyData> data;
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (const Vec3& p : surface.points) points->InsertNextPoint(p.data());
  data->SetPoints(points);
  vtkNew<vtkCellArray> triangles;
  for (const auto& t : surface.triangles) {
    const vtkIdType ids[3] = {t[0], t[1], t[2]};
    triangles->InsertNextCell(3, ids);
  }
  data->SetPolys(triangles);
  std::vector<double> unfolded;
  for (const Vec2& uv : surface.unfolded) unfolded.insert(unfolded.end(), uv.data(), uv.data() + 2);
  data->GetPointData()->AddArray(real_array("normal", flat(surface.normals), 3));
  data->GetPointData()->AddArray(real_array("unfolded", unfolded, 2));
  data->GetPointData()->AddArray(byte_array("annulus", surface.on_annulus));
  data->GetPointData()->AddArray(byte_array("free_edge", surface.on_free_edge));
  if (!surface.thickness.empty()) data->GetPointData()->AddArray(real_array("thickness", surface.thickness));
  data->GetCellData()->AddArray(integer_array("region", surface.region));
  vtkFieldData* field = data->GetFieldData();
  field->AddArray(real_array("perimeter", {&surface.perimeter, 1}));
  field->AddArray(real_array("axis", {surface.axis.data(), 3}, 3));
  field->AddArray(real_array("annulus_curve", flat(source.annulus_curve), 3));
  field->AddArray(real_array("anterior_direction", {source.anterior_direction.data(), 3}, 3));
  field->AddArray(real_array("scale", {&source.scale, 1}));
  ArrayUnits all = units;
  if (!surface.thickness.empty()) all.emplace_back("thickness", "mm");
  add_units(data, all);
  write_vtk(file, data);
}

SourceGeometry read_source(const std::filesystem::path& file) {
  const auto data = read_poly_data(file);
  const DatasetReader in(file, data);
  for (const auto& [name, unit] : units) in.expect_unit(name, unit);
  SourceGeometry source;
  MidSurface& surface = source.surface;
  surface.points = vectors(in.coordinates());
  const long points = data->GetNumberOfPoints(), triangles = data->GetNumberOfPolys();
  if (points == 0 || triangles == 0 || triangles != data->GetNumberOfCells()) in.fail("connectivity", "is no triangle surface");
  vtkNew<vtkIdList> ids;
  for (long t = 0; t < triangles; ++t) {
    data->GetPolys()->GetCellAtId(t, ids);
    if (ids->GetNumberOfIds() != 3) in.fail("connectivity", "holds a polygon that is no triangle, number " + std::to_string(t));
    auto& triangle = surface.triangles.emplace_back();
    for (int i = 0; i < 3; ++i) {
      const vtkIdType id = ids->GetId(i);
      if (id < 0 || id >= points) in.fail("connectivity", "names a point that does not exist in triangle " + std::to_string(t));
      triangle[static_cast<std::size_t>(i)] = static_cast<int>(id);
    }
  }
  surface.normals = vectors(in.reals(Place::points, "normal", 3, points));
  const auto unfolded = in.reals(Place::points, "unfolded", 2, points);
  for (std::size_t i = 0; i < unfolded.size(); i += 2) surface.unfolded.emplace_back(unfolded[i], unfolded[i + 1]);
  const auto annulus = in.integers(Place::points, "annulus", 0, 1, 1, points);
  const auto edge = in.integers(Place::points, "free_edge", 0, 1, 1, points);
  surface.on_annulus.assign(annulus.begin(), annulus.end());
  surface.on_free_edge.assign(edge.begin(), edge.end());
  surface.region = in.integers(Place::cells, "region", Region::posterior, Region::anterior, 1, triangles);
  in.expect_unit("thickness", "mm");
  if (in.has(Place::points, "thickness")) surface.thickness = in.reals(Place::points, "thickness", 1, points);
  surface.perimeter = in.reals(Place::field, "perimeter", 1, 1)[0];
  surface.axis = vectors(in.reals(Place::field, "axis", 3, 1))[0];
  source.annulus_curve = vectors(in.reals(Place::field, "annulus_curve", 3, -1));
  source.anterior_direction = vectors(in.reals(Place::field, "anterior_direction", 3, 1))[0];
  source.scale = in.reals(Place::field, "scale", 1, 1)[0];
  return source;
}

}  // namespace mv
