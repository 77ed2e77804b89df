// SPDX-License-Identifier: BSD-3-Clause
#include "solver/output/frame_writer.h"

#include <vtkCellArray.h>
#include <vtkCellType.h>
#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLUtilities.h>

#include <cctype>
#include <cmath>
#include <cstdio>
#include <sstream>
#include <stdexcept>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "solver/output/carried_annulus.h"
#include "solver/output/series.h"
#include "solver/output/vtk_helpers.h"

namespace mv {

namespace fs = std::filesystem;

namespace {

constexpr double mm_per_m = 1e3;
constexpr double pascal_per_mmHg = 133.322387415;
constexpr double pascal_per_kPa = 1e3;
/// Two instants closer than this are one: output times are multiples of a cadence far above it.
constexpr double same_time = 1e-12;

Vec3 entry(std::span<const double> xyz, std::size_t i) { return {xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2]}; }
Vec3 to_world_mm(const SolverFrame& frame, const Vec3& x) { return frame.origin + frame.axes.transpose() * (mm_per_m * x); }
Vec3 turn_to_world(const SolverFrame& frame, const Vec3& v) { return frame.axes.transpose() * v; }

std::string escaped(const std::string& text) {
  std::string out;
  for (char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

/// True for NAME_dddd.EXT, the names this writer gives.
bool is_frame_name(const std::string& name, const std::string& stem, const std::string& extension) {
  const std::string head = stem + "_", tail = "." + extension;
  if (name.size() <= head.size() + tail.size() || !name.starts_with(head) || !name.ends_with(tail)) return false;
  for (std::size_t i = head.size(); i < name.size() - tail.size(); ++i)
    if (std::isdigit(static_cast<unsigned char>(name[i])) == 0) return false;
  return true;
}

void check_size(std::size_t found, std::size_t expected, const char* what, bool optional = true) {
  if ((optional && found == 0) || found == expected) return;
  throw std::logic_error(std::string("frame writer: ") + what + " has " + std::to_string(found) + " entries, expected " +
                         std::to_string(expected));
}

}  // namespace

FrameWriter::FrameWriter(fs::path results, const LeafletMesh& mesh, const Chordae& chordae, const Annulus& annulus,
                         const SolverFrame& frame, double resume_time)
    : results_(std::move(results)), mesh_(mesh), chordae_(chordae), annulus_(annulus), frame_(frame) {
  std::error_code error;
  fs::create_directories(results_ / "frames", error);
  if (error) throw IoError((results_ / "frames").string() + ": cannot create the folder: " + error.message());
  for (Collection* c : {&leaflets_, &chordae_frames_, &fluid_}) open_collection(*c, resume_time);
}

void FrameWriter::open_collection(Collection& collection, double resume_time) {
  const fs::path pvd = results_ / (collection.name + ".pvd");
  const std::vector<PvdEntry> earlier = resume_time >= 0 ? read_pvd(pvd) : std::vector<PvdEntry>{};
  for (const PvdEntry& e : earlier)
    if (e.time <= resume_time + same_time) collection.entries.push_back(e);

  // the collection first: it must never name a frame that is gone
  std::error_code error;
  if (collection.entries.empty())
    fs::remove(pvd, error);
  else
    write_pvd(pvd, collection.entries);
  for (const auto& item : fs::directory_iterator(results_ / "frames", error)) {
    const std::string name = item.path().filename().string();
    if (!is_frame_name(name, collection.name, collection.extension)) continue;
    bool kept = false;
    for (const PvdEntry& e : collection.entries) kept = kept || e.file == "frames/" + name;
    if (!kept) fs::remove(item.path(), error);
  }
  if (error) throw IoError((results_ / "frames").string() + ": cannot clear frames of an earlier run: " + error.message());
}

fs::path FrameWriter::store(Collection& collection, double time, const std::function<void(const fs::path&)>& write) {
  std::vector<PvdEntry> entries = collection.entries;
  if (!entries.empty() && std::abs(entries.back().time - time) <= same_time) entries.pop_back();
  char number[24];
  std::snprintf(number, sizeof number, "%04zu", entries.size());
  const std::string name = "frames/" + collection.name + "_" + number + "." + collection.extension;
  entries.push_back({time, name});
  write(results_ / name);
  write_pvd(results_ / (collection.name + ".pvd"), entries);
  collection.entries = std::move(entries);
  return results_ / name;
}

fs::path FrameWriter::write_leaflets(const LeafletsState& state) {
  const std::size_t np = mesh_.points.size(), nt = mesh_.tets.size();
  check_size(state.positions.size(), 3 * np, "positions", false);
  check_size(state.velocities.size(), 3 * np, "velocities");
  check_size(state.contact_forces.size(), 3 * np, "contact_forces");
  check_size(state.contact_pressures.size(), np, "contact_pressures");
  check_size(state.von_mises.size(), nt, "von_mises");
  check_size(state.fibre_stresses.size(), nt, "fibre_stresses");
  check_size(state.fibre_strains.size(), nt, "fibre_strains");
  check_size(state.volume_ratios.size(), nt, "volume_ratios");

  vtkNew<vtkUnstructuredGrid> grid;
  vtk::add_header(grid, state.time);

  // double precision: the last frame is checked exactly for self-intersection
  std::vector<Vec3> world(np);
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(static_cast<vtkIdType>(np));
  for (std::size_t i = 0; i < np; ++i) {
    world[i] = to_world_mm(frame_, entry(state.positions, i));
    points->SetPoint(static_cast<vtkIdType>(i), world[i].data());
  }
  grid->SetPoints(points);
  const Annulus annulus = carried_annulus(annulus_, mesh_, world);
  const Vec3 &o = annulus.origin, &n = annulus.normal;
  vtk::add_field(grid, "annulus_origin", "mm", {o.x(), o.y(), o.z()});
  vtk::add_field(grid, "annulus_normal", "1", {n.x(), n.y(), n.z()});
  const int nodes = mesh_.nodes_per_tet();
  vtkNew<vtkCellArray> cells;
  for (const auto& tet : mesh_.tets) {
    cells->InsertNextCell(nodes);
    for (int k = 0; k < nodes; ++k) cells->InsertCellPoint(tet[static_cast<std::size_t>(k)]);
  }
  grid->SetCells(mesh_.order == 2 ? VTK_QUADRATIC_TETRA : VTK_TETRA, cells);

  using Float = vtkFloatArray;
  vtkFieldData *at_points = grid->GetPointData(), *at_cells = grid->GetCellData();
  vtk::add_array<Float>(grid, at_points, "displacement", "mm", 3, np, [&](auto i) { return Vec3(world[i] - mesh_.points[i]); });
  const auto vectors = [&](std::span<const double> values, const char* name, const char* unit) {
    if (!values.empty())
      vtk::add_array<Float>(grid, at_points, name, unit, 3, np, [&](auto i) { return turn_to_world(frame_, entry(values, i)); });
  };
  const auto scalars = [&](vtkFieldData* where, std::span<const double> values, const char* name, const char* unit,
                           double scale) {
    if (!values.empty())
      vtk::add_array<Float>(grid, where, name, unit, 1, values.size(), [&](auto i) { return scale * values[i]; });
  };
  vectors(state.velocities, "velocity", "m/s");
  vectors(state.contact_forces, "contact_force", "N");
  scalars(at_points, state.contact_pressures, "contact_pressure", "kPa", 1 / pascal_per_kPa);
  scalars(at_cells, state.von_mises, "von_mises", "kPa", 1 / pascal_per_kPa);
  scalars(at_cells, state.fibre_stresses, "fibre_stress", "kPa", 1 / pascal_per_kPa);
  scalars(at_cells, state.fibre_strains, "fibre_strain", "1", 1);
  scalars(at_cells, state.volume_ratios, "J", "1", 1);

  using Byte = vtkUnsignedCharArray;
  vtk::add_array<Byte>(grid, at_points, "annulus", "1", 1, np, [&](auto i) { return mesh_.on_annulus[i] != 0; });
  vtk::add_array<Byte>(grid, at_points, "free_edge", "1", 1, np, [&](auto i) { return mesh_.on_free_edge[i] != 0; });
  vtk::add_array<vtkIntArray>(grid, at_points, "side", "1", 1, np, [&](auto i) { return mesh_.side[i]; });
  vtk::add_array<Float>(grid, at_points, "unfolded", "mm", 2, mesh_.unfolded.size(), [&](auto i) { return mesh_.unfolded[i]; });
  vtk::add_array<vtkIntArray>(grid, at_cells, "region", "1", 1, nt, [&](auto i) { return mesh_.region[i]; });
  vtk::add_array<vtkIntArray>(grid, at_cells, "layer", "1", 1, nt, [&](auto i) { return mesh_.layer[i]; });
  return store(leaflets_, state.time, [&](const fs::path& file) { write_vtk(file, grid); });
}

fs::path FrameWriter::write_chordae(const ChordaeState& state) {
  const auto& segments = chordae_.segments;
  check_size(state.positions.size(), 3 * chordae_.points.size(), "chordae positions", chordae_.points.empty());
  check_size(state.tensions.size(), segments.size(), "chordae tensions");
  vtkNew<vtkPolyData> data;
  vtk::add_header(data, state.time);
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (std::size_t i = 0; i < chordae_.points.size(); ++i)
    points->InsertNextPoint(to_world_mm(frame_, entry(state.positions, i)).data());
  data->SetPoints(points);
  vtkNew<vtkCellArray> lines;
  for (const ChordaSegment& s : segments) {
    const vtkIdType ends[2] = {s.a, s.b};
    lines->InsertNextCell(2, ends);
  }
  data->SetLines(lines);
  vtkFieldData *at_cells = data->GetCellData(), *at_points = data->GetPointData();
  const std::size_t count = segments.size();
  vtk::add_array<vtkIntArray>(data, at_points, "muscle_of_point", "1", 1, chordae_.muscle_of_point.size(),
                              [&](auto i) { return chordae_.muscle_of_point[i]; });
  vtk::add_array<vtkIntArray>(data, at_cells, "kind", "1", 1, count, [&](auto i) { return static_cast<int>(segments[i].kind); });
  vtk::add_array<vtkIntArray>(data, at_cells, "muscle", "1", 1, count, [&](auto i) { return segments[i].muscle; });
  vtk::add_array<vtkIntArray>(data, at_cells, "leaflet", "1", 1, count, [&](auto i) { return segments[i].leaflet; });
  if (!state.tensions.empty())
    vtk::add_array<vtkFloatArray>(data, at_cells, "tension", "N", 1, count, [&](auto i) { return state.tensions[i]; });
  return store(chordae_frames_, state.time, [&](const fs::path& file) { write_vtk(file, data); });
}

fs::path FrameWriter::write_fluid(const FluidState& state) {
  const auto& [nx, ny, nz] = state.grid.cells;
  vtkNew<vtkImageData> image;
  vtk::add_header(image, state.time);
  image->SetDimensions(nx + 1, ny + 1, nz + 1);
  const double spacing = mm_per_m * state.grid.spacing;
  image->SetSpacing(spacing, spacing, spacing);
  image->SetOrigin(to_world_mm(frame_, state.grid.lower).data());
  // columns of the direction matrix are the grid's axes in the world
  vtkNew<vtkMatrix3x3> direction;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) direction->SetElement(r, c, frame_.axes(c, r));
  image->SetDirectionMatrix(direction);

  const auto ni = static_cast<std::size_t>(nx), nj = static_cast<std::size_t>(ny), count = ni * nj * static_cast<std::size_t>(nz);
  const auto at_cell = [&](auto&& rule) {
    return [&rule, ni, nj](std::size_t c) {
      return rule(static_cast<int>(c % ni), static_cast<int>(c / ni % nj), static_cast<int>(c / ni / nj));
    };
  };
  const auto velocity = [&](int i, int j, int k) { return turn_to_world(frame_, state.velocity(i, j, k)); };
  const auto pressure = [&](int i, int j, int k) { return state.pressure(i, j, k) / pascal_per_mmHg; };
  vtkFieldData* at_cells = image->GetCellData();
  vtk::add_array<vtkFloatArray>(image, at_cells, "velocity", "m/s", 3, count, at_cell(velocity));
  vtk::add_array<vtkFloatArray>(image, at_cells, "pressure", "mmHg", 1, count, at_cell(pressure));
  if (state.is_blood) vtk::add_array<vtkUnsignedCharArray>(image, at_cells, "inside", "1", 1, count, at_cell(state.is_blood));
  return store(fluid_, state.time, [&](const fs::path& file) { write_vtk(file, image); });
}

void write_pvd(const fs::path& file, std::span<const PvdEntry> entries) {
  std::ostringstream xml;
  xml << "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n  <Collection>\n";
  for (const PvdEntry& e : entries)
    xml << "    <DataSet timestep=\"" << format_number(e.time) << "\" group=\"\" part=\"0\" file=\"" << escaped(e.file)
        << "\"/>\n";
  xml << "  </Collection>\n</VTKFile>\n";
  write_text_atomically(file, xml.str());
}

std::vector<PvdEntry> read_pvd(const fs::path& file) {
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return {};
  const int display = vtkObject::GetGlobalWarningDisplay();
  vtkObject::GlobalWarningDisplayOff();
  const auto root = vtkSmartPointer<vtkXMLDataElement>::Take(vtkXMLUtilities::ReadElementFromFile(file.c_str()));
  vtkObject::SetGlobalWarningDisplay(display);
  vtkXMLDataElement* collection = root ? root->FindNestedElementWithName("Collection") : nullptr;
  if (collection == nullptr) throw InputError(file.string() + ": not a ParaView collection (damaged or incomplete?)");
  std::vector<PvdEntry> entries;
  for (int i = 0; i < collection->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* e = collection->GetNestedElement(i);
    double time = 0;
    const char* name = e->GetAttribute("file");
    if (name == nullptr || e->GetScalarAttribute("timestep", time) == 0)
      throw InputError(file.string() + ": entry " + std::to_string(i) + " has no file or no timestep");
    entries.push_back({time, name});
  }
  return entries;
}

}  // namespace mv
