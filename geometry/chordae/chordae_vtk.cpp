// SPDX-License-Identifier: GPL-3.0-or-later
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDataSet.h>
#include <vtkGenericDataObjectReader.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkObject.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>
#include <vtkXMLPolyDataReader.h>

#include <cmath>
#include <string>

#include "geometry/chordae/network_builder.h"
#include "geometry/core/errors.h"

namespace mv {
namespace {

/// VTK prints what it finds wrong; the checks below say it in our words.
class QuietVtk {
 public:
  QuietVtk() : previous_(vtkObject::GetGlobalWarningDisplay()) { vtkObject::SetGlobalWarningDisplay(0); }
  ~QuietVtk() { vtkObject::SetGlobalWarningDisplay(previous_); }
  QuietVtk(const QuietVtk&) = delete;
  QuietVtk& operator=(const QuietVtk&) = delete;

 private:
  int previous_;
};

vtkSmartPointer<vtkDataSet> read_legacy(const std::filesystem::path& file) {
  const QuietVtk quiet;
  vtkNew<vtkGenericDataObjectReader> reader;
  reader->SetFileName(file.c_str());
  reader->ReadAllScalarsOn();
  reader->ReadAllFieldsOn();
  reader->Update();
  vtkSmartPointer<vtkDataSet> data = vtkDataSet::SafeDownCast(reader->GetOutput());
  if (!data || reader->GetErrorCode() != 0 || data->GetNumberOfPoints() == 0)
    throw InputError(file.string() + ": not a readable legacy VTK file with points and lines (poly data or unstructured grid)");
  return data;
}

/// Other programs' files: no unit, space or hash has to be recorded.
vtkSmartPointer<vtkDataSet> read_xml(const std::filesystem::path& file) {
  const QuietVtk quiet;
  vtkNew<vtkXMLPolyDataReader> reader;
  if (!reader->CanReadFile(file.c_str())) throw InputError(file.string() + ": not a VTK XML file of poly data (.vtp)");
  reader->SetFileName(file.c_str());
  reader->Update();
  vtkSmartPointer<vtkDataSet> data = reader->GetOutput();
  if (!data || reader->GetErrorCode() != 0 || data->GetNumberOfPoints() == 0) throw InputError(file.string() + ": holds no points, or is damaged");
  return data;
}

vtkSmartPointer<vtkDataSet> read_any(const std::filesystem::path& file) {
  return file.extension() == ".vtk" || file.extension() == ".VTK" ? read_legacy(file) : read_xml(file);
}

/// What the file records about itself must not contradict the options.
void check_record(vtkDataSet* data, const char* name, const std::string& asked, const char* key, const std::filesystem::path& file) {
  auto* record = vtkStringArray::SafeDownCast(data->GetFieldData()->GetAbstractArray(name));
  if (!record || record->GetNumberOfValues() == 0) return;
  std::string said = record->GetValue(0);
  for (char& c : said) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (said != asked) throw InputError(file.string() + ": records " + name + " '" + said + "', but " + key + " is '" + asked + "'");
}

/// The first of the names that the file has, with one component and one value per tuple.
vtkDataArray* find_array(vtkFieldData* data, std::initializer_list<const char*> names, const std::filesystem::path& file) {
  for (const char* name : names)
    if (vtkDataArray* a = data->GetArray(name)) {
      if (a->GetNumberOfComponents() != 1)
        throw InputError(file.string() + ": array '" + name + "' has " + std::to_string(a->GetNumberOfComponents()) + " components, expected 1");
      return a;
    }
  return nullptr;
}

struct Thickness {
  vtkDataArray* values = nullptr;
  enum { radius, diameter, area } meaning = radius;

  double area_at(vtkIdType i) const {
    const double v = values->GetComponent(i, 0);
    return meaning == area ? v : area_of_radius(meaning == radius ? v : 0.5 * v);
  }
};

Thickness find_thickness(vtkFieldData* data, const std::filesystem::path& file) {
  if (auto* a = find_array(data, {"area", "Area"}, file)) return {a, Thickness::area};
  if (auto* a = find_array(data, {"radius", "Radius"}, file)) return {a, Thickness::radius};
  if (auto* a = find_array(data, {"diameter", "Diameter"}, file)) return {a, Thickness::diameter};
  return {};
}

}  // namespace

std::vector<std::vector<Vec3>> read_polylines(const std::filesystem::path& file) {
  const vtkSmartPointer<vtkDataSet> data = read_any(file);
  std::vector<std::vector<Vec3>> out;
  vtkNew<vtkIdList> ids;
  for (vtkIdType c = 0; c < data->GetNumberOfCells(); ++c) {
    if (data->GetCellType(c) != VTK_LINE && data->GetCellType(c) != VTK_POLY_LINE) continue;
    data->GetCellPoints(c, ids);
    out.emplace_back();
    for (vtkIdType k = 0; k < ids->GetNumberOfIds(); ++k) {
      if (ids->GetId(k) < 0 || ids->GetId(k) >= data->GetNumberOfPoints()) throw InputError(file.string() + ": line " + std::to_string(c) + " names a point that does not exist");
      out.back().push_back(Vec3::Map(data->GetPoint(ids->GetId(k))));
    }
  }
  return out;
}

RawChordae read_chordae_vtk(const std::filesystem::path& file, const ChordaeFileOptions& options) {
  NetworkBuilder network(file, options);
  const vtkSmartPointer<vtkDataSet> data = read_any(file);
  check_record(data, "UnitSystem", options.unit, "chordae.file_unit", file);
  check_record(data, "SPACE", options.space == ChordaeSpace::lps ? "lps" : "ras", "chordae.file_space", file);
  const Thickness of_cell = find_thickness(data->GetCellData(), file), of_point = find_thickness(data->GetPointData(), file);
  vtkDataArray* rest = find_array(data->GetCellData(), {"rest_length"}, file);
  vtkDataArray* kind = find_array(data->GetCellData(), {"kind"}, file);
  vtkDataArray* root = find_array(data->GetPointData(), {"root", "fixed"}, file);
  vtkDataArray* muscle = find_array(data->GetPointData(), {"muscle_of_point"}, file);
  vtkDataArray* end = find_array(data->GetPointData(), {"leaflet", "on_leaflet"}, file);
  const vtkIdType points = data->GetNumberOfPoints();
  vtkNew<vtkIdList> ids;
  long other_cells = 0;
  for (vtkIdType c = 0; c < data->GetNumberOfCells(); ++c) {
    const int type = data->GetCellType(c);
    if (type != VTK_LINE && type != VTK_POLY_LINE) {
      other_cells += type != VTK_VERTEX && type != VTK_POLY_VERTEX;
      continue;
    }
    data->GetCellPoints(c, ids);
    const std::string where = "line " + std::to_string(c);
    double whole = 0;  // of a polyline, to share its rest length among its segments
    for (vtkIdType k = 0; k + 1 < ids->GetNumberOfIds(); ++k) {
      for (vtkIdType id : {ids->GetId(k), ids->GetId(k + 1)})
        if (id < 0 || id >= points)
          throw InputError(file.string() + ": " + where + " names point " + std::to_string(id) + ", the file has " + std::to_string(points));
      whole += (Vec3::Map(data->GetPoint(ids->GetId(k + 1))) - Vec3(Vec3::Map(data->GetPoint(ids->GetId(k))))).norm();
    }
    for (vtkIdType k = 0; k + 1 < ids->GetNumberOfIds(); ++k) {
      const vtkIdType from = ids->GetId(k), to = ids->GetId(k + 1);
      const Vec3 xa = Vec3::Map(data->GetPoint(from)), xb = Vec3::Map(data->GetPoint(to));
      const int a = network.point(xa, "point " + std::to_string(from)), b = network.point(xb, "point " + std::to_string(to));
      for (const auto& [id, p] : {std::pair(from, a), std::pair(to, b)}) {
        if (root && root->GetComponent(id, 0) != 0) network.mark_root(p);
        if (muscle && muscle->GetComponent(id, 0) >= 0) network.mark_root(p);
        if (end && end->GetComponent(id, 0) != 0) network.mark_leaflet_end(p);
      }
      NetworkBuilder::Segment values;
      if (of_cell.values)
        values.area = of_cell.area_at(c);
      else if (of_point.values)
        values.area = 0.5 * (of_point.area_at(from) + of_point.area_at(to));
      if (rest && whole > 0) values.rest_length = rest->GetComponent(c, 0) * (xb - xa).norm() / whole;
      if (kind) {
        values.kind = static_cast<int>(kind->GetComponent(c, 0));
        if (values.kind < -1 || values.kind > static_cast<int>(ChordaKind::marginal))
          throw InputError(file.string() + ": array 'kind' is " + std::to_string(values.kind) + " at " + where + ", expected 0 to 4, or -1 for not known");
      }
      network.segment(a, b, values, where);
    }
  }
  if (other_cells > 0) network.note(std::to_string(other_cells) + " cells that are no lines left out");
  return network.take();
}

}  // namespace mv
