// SPDX-License-Identifier: BSD-3-Clause
#include "geometry/core/case_files.h"

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDataArray.h>
#include <vtkFieldData.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkUnstructuredGrid.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "geometry/core/errors.h"
#include "geometry/core/leaflet_names.h"
#include "geometry/core/vtk_dataset.h"

namespace mv {
namespace {

using Place = DatasetReader::Place;
constexpr long any = -1;
constexpr long largest = std::numeric_limits<int>::max();
constexpr int largest_muscle = 1000;

void require(bool holds, const std::string& what) {
  if (!holds) throw std::logic_error("case files: " + what);
}

template <int N>
std::span<const double> flat(const std::vector<Eigen::Matrix<double, N, 1>>& v) {
  static_assert(sizeof(Eigen::Matrix<double, N, 1>) == N * sizeof(double));
  return {v.empty() ? nullptr : v[0].data(), v.size() * N};
}

template <int N>
std::vector<Eigen::Matrix<double, N, 1>> vectors(const std::vector<double>& values) {
  std::vector<Eigen::Matrix<double, N, 1>> out(values.size() / N);
  for (std::size_t i = 0; i < out.size(); ++i) {
    for (int c = 0; c < N; ++c) out[i][c] = values[i * N + static_cast<std::size_t>(c)];
  }
  return out;
}

vtkSmartPointer<vtkPoints> points_of(const std::vector<Vec3>& points) {
  auto out = vtkSmartPointer<vtkPoints>::New();
  out->SetDataTypeToDouble();
  out->SetNumberOfPoints(static_cast<vtkIdType>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) out->SetPoint(static_cast<vtkIdType>(i), points[i].data());
  return out;
}

void check_finite(const std::vector<Vec3>& points, const std::string& what) {
  for (const Vec3& p : points) require(p.allFinite(), what + " are not finite");
}

Vec3 field_vector(const DatasetReader& in, const std::string& name) { return vectors<3>(in.reals(Place::field, name, 3, 1))[0]; }
double field_number(const DatasetReader& in, const std::string& name) { return in.reals(Place::field, name, 1, 1)[0]; }
void add_vector(vtkFieldData* field, const std::string& name, const Vec3& v) {
  field->AddArray(real_array(name, {v.data(), 3}, 3));
}
void add_number(vtkFieldData* field, const std::string& name, double v) { field->AddArray(real_array(name, {&v, 1})); }

void expect_units(const DatasetReader& in, const ArrayUnits& units) {
  for (const auto& [name, unit] : units) in.expect_unit(name, unit);
}

const ArrayUnits leaflet_units = {{"points", "mm"}, {"region", "1"},    {"layer", "1"}, {"fibre", "1"},    {"sheet_normal", "1"},
                                  {"annulus", "1"}, {"free_edge", "1"}, {"side", "1"},  {"unfolded", "mm"}};
const ArrayUnits chordae_units = {{"points", "mm"},        {"muscle_of_point", "1"}, {"kind", "1"},   {"muscle", "1"},
                                  {"leaflet", "1"},        {"rest_length", "mm"},    {"area", "mm2"}, {"insertion_point", "1"},
                                  {"insertion_node", "1"}, {"insertion_weight", "1"}};
const ArrayUnits tube_units = {{"points", "mm"},        {"origin", "mm"},      {"axes", "1"},
                               {"cross_section", "mm"}, {"z_ventricle", "mm"}, {"z_atrium", "mm"},
                               {"grid_lower", "mm"},    {"grid_cells", "1"},   {"grid_spacing", "mm"}};
const ArrayUnits annulus_units = {{"points", "mm"},    {"origin", "mm"},       {"normal", "1"},
                                  {"axis_major", "1"}, {"residual_rms", "mm"}, {"eigenvalues", "mm2"}};
const ArrayUnits papillary_units = {{"points", "mm"}};

void check_rotation(const DatasetReader& in, const Mat3& axes) {
  constexpr double tolerance = 1e-6;
  if ((axes * axes.transpose() - Mat3::Identity()).norm() > tolerance || axes.determinant() < 0)
    in.fail("axes", "is not a rotation");
}

}  // namespace

void write_leaflets(const std::filesystem::path& file, const LeafletMesh& mesh) {
  const std::size_t cells = mesh.tets.size(), points = mesh.points.size();
  require(mesh.region.size() == cells && mesh.layer.size() == cells, "leaflets: one region and layer per element");
  require(mesh.fibre.empty() || mesh.fibre.size() == cells, "leaflets: one fibre per element or none");
  require(mesh.sheet_normal.empty() || mesh.sheet_normal.size() == cells, "leaflets: one sheet normal per element or none");
  require(mesh.on_annulus.size() == points && mesh.on_free_edge.size() == points && mesh.side.size() == points &&
              mesh.unfolded.size() == points,
          "leaflets: one annulus, free edge, side and unfolded entry per point");
  check_finite(mesh.points, "leaflet points");
  auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  grid->SetPoints(points_of(mesh.points));
  grid->Allocate(static_cast<vtkIdType>(cells));
  const int corners = mesh.nodes_per_tet();
  for (const auto& tet : mesh.tets) {
    vtkIdType ids[10];
    for (int i = 0; i < corners; ++i) {
      require(tet[i] >= 0 && static_cast<std::size_t>(tet[i]) < points, "leaflets: point index out of range");
      ids[i] = tet[i];
    }
    grid->InsertNextCell(mesh.order == 2 ? VTK_QUADRATIC_TETRA : VTK_TETRA, corners, ids);
  }
  vtkCellData* cell = grid->GetCellData();
  cell->AddArray(integer_array("region", mesh.region));
  cell->AddArray(integer_array("layer", mesh.layer));
  if (!mesh.fibre.empty()) cell->AddArray(real_array("fibre", flat<3>(mesh.fibre), 3));
  if (!mesh.sheet_normal.empty()) cell->AddArray(real_array("sheet_normal", flat<3>(mesh.sheet_normal), 3));
  vtkPointData* point = grid->GetPointData();
  point->AddArray(byte_array("annulus", mesh.on_annulus));
  point->AddArray(byte_array("free_edge", mesh.on_free_edge));
  point->AddArray(integer_array("side", mesh.side));
  point->AddArray(real_array("unfolded", flat<2>(mesh.unfolded), 2));
  add_units(grid, leaflet_units);
  write_vtk(file, grid);
}

LeafletMesh read_leaflets(const std::filesystem::path& file) {
  const auto grid = read_unstructured_grid(file);
  const DatasetReader in(file, grid);
  expect_units(in, leaflet_units);
  LeafletMesh mesh;
  mesh.points = vectors<3>(in.coordinates());
  const long points = grid->GetNumberOfPoints(), cells = grid->GetNumberOfCells();
  if (points == 0 || cells == 0) in.fail("points", "is empty");
  mesh.order = grid->GetCellType(0) == VTK_QUADRATIC_TETRA ? 2 : 1;
  const int expected_type = mesh.order == 2 ? VTK_QUADRATIC_TETRA : VTK_TETRA;
  mesh.tets.resize(static_cast<std::size_t>(cells));
  vtkNew<vtkIdList> ids;
  for (vtkIdType c = 0; c < cells; ++c) {
    if (grid->GetCellType(c) != expected_type)
      in.fail("types", "mixes kinds of cells (cell " + std::to_string(c) + "); expected tetrahedra");
    grid->GetCellPoints(c, ids);
    if (ids->GetNumberOfIds() != mesh.nodes_per_tet())
      in.fail("connectivity", "has a wrong number of points in cell " + std::to_string(c));
    auto& tet = mesh.tets[static_cast<std::size_t>(c)];
    tet.fill(-1);
    for (int i = 0; i < mesh.nodes_per_tet(); ++i) {
      if (ids->GetId(i) < 0 || ids->GetId(i) >= points)
        in.fail("connectivity", "names a point that does not exist in cell " + std::to_string(c));
      tet[static_cast<std::size_t>(i)] = static_cast<int>(ids->GetId(i));
    }
  }
  mesh.region = in.integers(Place::cells, "region", Region::posterior, last_region, 1, cells);
  mesh.layer = in.integers(Place::cells, "layer", 0, 1000, 1, cells);
  if (in.has(Place::cells, "fibre")) mesh.fibre = vectors<3>(in.reals(Place::cells, "fibre", 3, cells));
  if (in.has(Place::cells, "sheet_normal")) mesh.sheet_normal = vectors<3>(in.reals(Place::cells, "sheet_normal", 3, cells));
  const auto annulus = in.integers(Place::points, "annulus", 0, 1, 1, points);
  const auto edge = in.integers(Place::points, "free_edge", 0, 1, 1, points);
  mesh.on_annulus.assign(annulus.begin(), annulus.end());
  mesh.on_free_edge.assign(edge.begin(), edge.end());
  mesh.side = in.integers(Place::points, "side", Side::ventricular, Side::atrial, 1, points);
  mesh.unfolded = vectors<2>(in.reals(Place::points, "unfolded", 2, points));
  return mesh;
}

void write_chordae(const std::filesystem::path& file, const Chordae& chordae) {
  const auto points = static_cast<int>(chordae.points.size());
  require(chordae.muscle_of_point.size() == chordae.points.size(), "chordae: one muscle entry per point");
  check_finite(chordae.points, "chordae points");
  auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(points_of(chordae.points));
  data->GetPointData()->AddArray(integer_array("muscle_of_point", chordae.muscle_of_point));
  vtkNew<vtkCellArray> lines;
  std::vector<int> kind, muscle, leaflet, insertion_point, insertion_node;
  std::vector<double> rest_length, area, weight;
  for (const ChordaSegment& s : chordae.segments) {
    require(s.a >= 0 && s.a < points && s.b >= 0 && s.b < points, "chordae: point index out of range");
    const vtkIdType ids[2] = {s.a, s.b};
    lines->InsertNextCell(2, ids);
    kind.push_back(static_cast<int>(s.kind));
    muscle.push_back(s.muscle);
    leaflet.push_back(s.leaflet);
    rest_length.push_back(s.rest_length);
    area.push_back(s.area);
  }
  data->SetLines(lines);
  for (const Insertion& i : chordae.insertions) {
    insertion_point.push_back(i.point);
    insertion_node.push_back(i.node);
    weight.push_back(i.weight);
  }
  vtkCellData* cell = data->GetCellData();
  cell->AddArray(integer_array("kind", kind));
  cell->AddArray(integer_array("muscle", muscle));
  cell->AddArray(integer_array("leaflet", leaflet));
  cell->AddArray(real_array("rest_length", rest_length));
  cell->AddArray(real_array("area", area));
  vtkFieldData* field = data->GetFieldData();
  field->AddArray(integer_array("insertion_point", insertion_point));
  field->AddArray(integer_array("insertion_node", insertion_node));
  field->AddArray(real_array("insertion_weight", weight));
  add_units(data, chordae_units);
  write_vtk(file, data);
}

Chordae read_chordae(const std::filesystem::path& file) {
  const auto data = read_poly_data(file);
  const DatasetReader in(file, data);
  expect_units(in, chordae_units);
  Chordae chordae;
  chordae.points = vectors<3>(in.coordinates());
  const long points = data->GetNumberOfPoints(), lines = data->GetNumberOfLines();
  if (data->GetNumberOfCells() != lines) in.fail("connectivity", "holds cells that are no lines");
  chordae.muscle_of_point = in.integers(Place::points, "muscle_of_point", -1, largest_muscle, 1, points);
  const auto kind = in.integers(Place::cells, "kind", 0, static_cast<int>(ChordaKind::marginal), 1, lines);
  const auto muscle = in.integers(Place::cells, "muscle", 0, largest_muscle, 1, lines);
  const auto leaflet = in.integers(Place::cells, "leaflet", 0, last_region, 1, lines);
  const auto rest_length = in.reals(Place::cells, "rest_length", 1, lines);
  const auto area = in.reals(Place::cells, "area", 1, lines);
  vtkNew<vtkIdList> ids;
  for (long c = 0; c < lines; ++c) {
    data->GetLines()->GetCellAtId(c, ids);
    if (ids->GetNumberOfIds() != 2) in.fail("connectivity", "has a line without two ends, number " + std::to_string(c));
    const auto i = static_cast<std::size_t>(c);
    ChordaSegment s{static_cast<int>(ids->GetId(0)),
                    static_cast<int>(ids->GetId(1)),
                    static_cast<ChordaKind>(kind[i]),
                    muscle[i],
                    leaflet[i],
                    rest_length[i],
                    area[i]};
    if (ids->GetId(0) < 0 || ids->GetId(0) >= points || ids->GetId(1) < 0 || ids->GetId(1) >= points) {
      in.fail("connectivity", "names a point that does not exist in line " + std::to_string(c));
    }
    if (s.rest_length < 0) in.fail("rest_length", "is negative at line " + std::to_string(c));
    if (s.area < 0) in.fail("area", "is negative at line " + std::to_string(c));
    chordae.segments.push_back(s);
  }
  const auto weight = in.reals(Place::field, "insertion_weight", 1, any);
  const auto count = static_cast<long>(weight.size());
  const auto at = in.integers(Place::field, "insertion_point", 0, points - 1, 1, count);
  const auto node = in.integers(Place::field, "insertion_node", 0, largest, 1, count);
  for (std::size_t i = 0; i < weight.size(); ++i) chordae.insertions.push_back({at[i], node[i], weight[i]});
  return chordae;
}

void write_tube(const std::filesystem::path& file, const Tube& tube) {
  const std::size_t points = tube.points.size();
  check_finite(tube.points, "tube points");
  auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  grid->SetPoints(points_of(tube.points));
  grid->Allocate(static_cast<vtkIdType>(tube.hexes.size()));
  for (const auto& hex : tube.hexes) {
    vtkIdType ids[8];
    for (std::size_t i = 0; i < 8; ++i) {
      require(hex[i] >= 0 && static_cast<std::size_t>(hex[i]) < points, "tube: point index out of range");
      ids[i] = hex[i];
    }
    grid->InsertNextCell(VTK_HEXAHEDRON, 8, ids);
  }
  vtkFieldData* field = grid->GetFieldData();
  add_vector(field, "origin", tube.origin);
  const Mat3 by_rows = tube.axes.transpose();  // Eigen stores columns; the file holds e1, e2, e3 one after the other
  field->AddArray(real_array("axes", {by_rows.data(), 9}, 9));
  field->AddArray(real_array("cross_section", flat<2>(tube.cross_section), 2));
  add_number(field, "z_ventricle", tube.z_ventricle);
  add_number(field, "z_atrium", tube.z_atrium);
  add_vector(field, "grid_lower", tube.grid_lower);
  field->AddArray(integer_array("grid_cells", tube.grid_cells, 3));
  add_number(field, "grid_spacing", tube.grid_spacing);
  add_units(grid, tube_units);
  write_vtk(file, grid);
}

Tube read_tube(const std::filesystem::path& file) {
  const auto grid = read_unstructured_grid(file);
  const DatasetReader in(file, grid);
  expect_units(in, tube_units);
  Tube tube;
  tube.points = vectors<3>(in.coordinates());
  const long points = grid->GetNumberOfPoints();
  vtkNew<vtkIdList> ids;
  for (vtkIdType c = 0; c < grid->GetNumberOfCells(); ++c) {
    grid->GetCellPoints(c, ids);
    if (grid->GetCellType(c) != VTK_HEXAHEDRON || ids->GetNumberOfIds() != 8)
      in.fail("types", "holds a cell that is no hexahedron, number " + std::to_string(c));
    auto& hex = tube.hexes.emplace_back();
    for (int i = 0; i < 8; ++i) {
      if (ids->GetId(i) < 0 || ids->GetId(i) >= points)
        in.fail("connectivity", "names a point that does not exist in cell " + std::to_string(c));
      hex[static_cast<std::size_t>(i)] = static_cast<int>(ids->GetId(i));
    }
  }
  tube.origin = field_vector(in, "origin");
  tube.axes = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(in.reals(Place::field, "axes", 9, 1).data());
  check_rotation(in, tube.axes);
  tube.cross_section = vectors<2>(in.reals(Place::field, "cross_section", 2, any));
  if (tube.cross_section.size() < 3) in.fail("cross_section", "is no polygon");
  tube.z_ventricle = field_number(in, "z_ventricle");
  tube.z_atrium = field_number(in, "z_atrium");
  if (!(tube.z_ventricle < tube.z_atrium)) in.fail("z_ventricle", "does not lie below z_atrium");
  tube.grid_lower = field_vector(in, "grid_lower");
  const auto cells = in.integers(Place::field, "grid_cells", 1, 100000, 3, 1);
  tube.grid_cells = {cells[0], cells[1], cells[2]};
  tube.grid_spacing = field_number(in, "grid_spacing");
  if (tube.grid_spacing <= 0) in.fail("grid_spacing", "is not positive");
  return tube;
}

void write_annulus(const std::filesystem::path& file, const Annulus& annulus) {
  check_finite(annulus.points, "annulus points");
  auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(points_of(annulus.points));
  vtkNew<vtkCellArray> lines;
  std::vector<vtkIdType> loop;
  for (std::size_t i = 0; i <= annulus.points.size(); ++i)
    loop.push_back(static_cast<vtkIdType>(i % std::max<std::size_t>(annulus.points.size(), 1)));
  if (!annulus.points.empty()) lines->InsertNextCell(static_cast<vtkIdType>(loop.size()), loop.data());
  data->SetLines(lines);
  vtkFieldData* field = data->GetFieldData();
  add_vector(field, "origin", annulus.origin);
  add_vector(field, "normal", annulus.normal);
  add_vector(field, "axis_major", annulus.axis_major);
  add_number(field, "residual_rms", annulus.residual_rms);
  add_vector(field, "eigenvalues", annulus.eigenvalues);
  add_texts(field, "sign_rule", {annulus.sign_rule});
  add_units(data, annulus_units);
  write_vtk(file, data);
}

Annulus read_annulus(const std::filesystem::path& file) {
  const auto data = read_poly_data(file);
  const DatasetReader in(file, data);
  expect_units(in, annulus_units);
  constexpr double tolerance = 1e-6;
  Annulus annulus;
  annulus.points = vectors<3>(in.coordinates());
  if (annulus.points.size() < 3) in.fail("points", "is no closed curve");
  annulus.origin = field_vector(in, "origin");
  annulus.normal = field_vector(in, "normal");
  annulus.axis_major = field_vector(in, "axis_major");
  for (const char* name : {"normal", "axis_major"}) {
    if (std::abs(field_vector(in, name).norm() - 1) > tolerance) in.fail(name, "is no unit vector");
  }
  annulus.residual_rms = field_number(in, "residual_rms");
  annulus.eigenvalues = field_vector(in, "eigenvalues");
  const auto rule = in.texts("sign_rule");
  if (rule.size() != 1) in.fail("sign_rule", "is missing");
  annulus.sign_rule = rule[0];
  return annulus;
}

void write_papillary(const std::filesystem::path& file, const Papillary& papillary) {
  require(papillary.names.size() == papillary.tips.size(), "papillary: one name per tip");
  check_finite(papillary.tips, "papillary tips");
  auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(points_of(papillary.tips));
  vtkNew<vtkCellArray> vertices;
  for (std::size_t i = 0; i < papillary.tips.size(); ++i) {
    const auto id = static_cast<vtkIdType>(i);
    vertices->InsertNextCell(1, &id);
  }
  data->SetVerts(vertices);
  add_texts(data->GetFieldData(), "names", papillary.names);
  add_units(data, papillary_units);
  write_vtk(file, data);
}

Papillary read_papillary(const std::filesystem::path& file) {
  const auto data = read_poly_data(file);
  const DatasetReader in(file, data);
  expect_units(in, papillary_units);
  Papillary papillary;
  papillary.tips = vectors<3>(in.coordinates());
  papillary.names = in.texts("names");
  if (papillary.names.size() != papillary.tips.size())
    in.fail("names", "has " + std::to_string(papillary.names.size()) + " entries, expected one per point");
  return papillary;
}

}  // namespace mv
