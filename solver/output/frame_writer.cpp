// SPDX-License-Identifier: BSD-3-Clause
#include "solver/output/frame_writer.h"

#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkPolyData.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLImageDataWriter.h>
#include <vtkXMLPolyDataWriter.h>
#include <vtkXMLUnstructuredGridWriter.h>
#include <vtkXMLUtilities.h>

#include <cassert>
#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <sstream>

#include "geometry/core/case_files.h"
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

std::ptrdiff_t ssize_of(const auto& c) { return static_cast<std::ptrdiff_t>(c.size()); }

Vec3 to_world_mm(const SolverFrame& frame, const Vec3& x) { return frame.origin + frame.axes.transpose() * (mm_per_m * x); }
Vec3 turn_to_world(const SolverFrame& frame, const Vec3& v) { return frame.axes.transpose() * v; }

std::string escaped(const std::string& text) {
  std::string out;
  for (char c : text) {
    if (c == '&') out += "&amp;";
    else if (c == '<') out += "&lt;";
    else if (c == '"') out += "&quot;";
    else out += c;
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
  if (collection.entries.empty()) fs::remove(pvd, error);
  else write_pvd(pvd, collection.entries);
  for (const auto& item : fs::directory_iterator(results_ / "frames", error)) {
    const std::string name = item.path().filename().string();
    if (!is_frame_name(name, collection.name, collection.extension)) continue;
    bool kept = false;
    for (const PvdEntry& e : collection.entries) kept = kept || e.file == "frames/" + name;
    if (!kept) fs::remove(item.path(), error);
  }
  if (error) throw IoError((results_ / "frames").string() + ": cannot clear frames of an earlier run: " + error.message());
}

fs::path FrameWriter::store(Collection& collection, double time, const std::string& bytes) {
  std::vector<PvdEntry> entries = collection.entries;
  if (!entries.empty() && std::abs(entries.back().time - time) <= same_time) entries.pop_back();
  char number[16];
  std::snprintf(number, sizeof number, "%04zu", entries.size());
  const std::string name = "frames/" + collection.name + "_" + number + "." + collection.extension;
  entries.push_back({time, name});
  write_text_atomically(results_ / name, bytes);
  write_pvd(results_ / (collection.name + ".pvd"), entries);
  collection.entries = std::move(entries);
  return results_ / name;
}

fs::path FrameWriter::write_leaflets(const LeafletsState& state) {
  const std::size_t point_count = mesh_.points.size(), tet_count = mesh_.tets.size();
  check_size(state.positions.size(), point_count, "positions", false);
  check_size(state.velocities.size(), point_count, "velocities");
  check_size(state.contact_forces.size(), point_count, "contact_forces");
  check_size(state.contact_pressures.size(), point_count, "contact_pressures");
  check_size(state.von_mises.size(), tet_count, "von_mises");
  check_size(state.fibre_stresses.size(), tet_count, "fibre_stresses");
  check_size(state.fibre_strains.size(), tet_count, "fibre_strains");
  check_size(state.volume_ratios.size(), tet_count, "volume_ratios");

  vtkNew<vtkUnstructuredGrid> grid;
  vtk::add_header(grid->GetFieldData(), state.time);
  const Vec3 &o = annulus_.origin, &n = annulus_.normal;
  vtk::add_numbers<vtkDoubleArray>(grid->GetFieldData(), "annulus_origin", {o.x(), o.y(), o.z()});
  vtk::add_text(grid->GetFieldData(), "unit:annulus_origin", "mm");
  vtk::add_numbers<vtkDoubleArray>(grid->GetFieldData(), "annulus_normal", {n.x(), n.y(), n.z()});
  vtk::add_text(grid->GetFieldData(), "unit:annulus_normal", "1");

  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(ssize_of(mesh_.points));
  std::vector<Vec3> world(point_count);
  for (std::size_t i = 0; i < point_count; ++i) {
    world[i] = to_world_mm(frame_, state.positions[i]);
    points->SetPoint(static_cast<vtkIdType>(i), world[i].data());
  }
  grid->SetPoints(points);

  const int nodes = mesh_.nodes_per_tet();
  vtkNew<vtkCellArray> cells;
  for (const auto& tet : mesh_.tets) {
    cells->InsertNextCell(nodes);
    for (int k = 0; k < nodes; ++k) cells->InsertCellPoint(tet[static_cast<std::size_t>(k)]);
  }
  grid->SetCells(mesh_.order == 2 ? VTK_QUADRATIC_TETRA : VTK_TETRA, cells);

  auto* at_points = grid->GetPointData();
  auto* at_cells = grid->GetCellData();
  const auto np = ssize_of(mesh_.points), nt = ssize_of(mesh_.tets);
  using Float = vtkFloatArray;
  const auto u = [](std::ptrdiff_t i) { return static_cast<std::size_t>(i); };
  vtk::add_vectors<Float>(grid, at_points, "displacement", "mm", 3, np, [&](auto i) { return Vec3(world[u(i)] - mesh_.points[u(i)]); });
  if (!state.velocities.empty())
    vtk::add_vectors<Float>(grid, at_points, "velocity", "m/s", 3, np, [&](auto i) { return turn_to_world(frame_, state.velocities[u(i)]); });
  if (!state.contact_forces.empty())
    vtk::add_vectors<Float>(grid, at_points, "contact_force", "N", 3, np,
                            [&](auto i) { return turn_to_world(frame_, state.contact_forces[u(i)]); });
  const auto optional = [&](vtkDataSetAttributes* where, std::span<const double> values, const char* name, const char* unit, double scale) {
    if (values.empty()) return;
    vtk::add_scalars<Float>(grid, where, name, unit, ssize_of(values), [&](auto i) { return scale * values[u(i)]; });
  };
  optional(at_points, state.contact_pressures, "contact_pressure", "kPa", 1 / pascal_per_kPa);
  optional(at_cells, state.von_mises, "von_mises", "kPa", 1 / pascal_per_kPa);
  optional(at_cells, state.fibre_stresses, "fibre_stress", "kPa", 1 / pascal_per_kPa);
  optional(at_cells, state.fibre_strains, "fibre_strain", "1", 1);
  optional(at_cells, state.volume_ratios, "J", "1", 1);

  const auto flags = [&](const std::vector<char>& values, const char* name) {
    if (values.size() == point_count)
      vtk::add_scalars<vtkUnsignedCharArray>(grid, at_points, name, "1", np, [&](auto i) { return values[u(i)] != 0; });
  };
  flags(mesh_.on_annulus, "annulus");
  flags(mesh_.on_free_edge, "free_edge");
  if (mesh_.side.size() == point_count)
    vtk::add_scalars<vtkIntArray>(grid, at_points, "side", "1", np, [&](auto i) { return mesh_.side[u(i)]; });
  if (mesh_.unfolded.size() == point_count)
    vtk::add_vectors<Float>(grid, at_points, "unfolded", "mm", 2, np, [&](auto i) { return mesh_.unfolded[u(i)]; });
  if (mesh_.region.size() == tet_count)
    vtk::add_scalars<vtkIntArray>(grid, at_cells, "region", "1", nt, [&](auto i) { return mesh_.region[u(i)]; });
  if (mesh_.layer.size() == tet_count)
    vtk::add_scalars<vtkIntArray>(grid, at_cells, "layer", "1", nt, [&](auto i) { return mesh_.layer[u(i)]; });

  return store(leaflets_, state.time, vtk::to_bytes<vtkXMLUnstructuredGridWriter>(grid));
}

fs::path FrameWriter::write_chordae(const ChordaeState& state) {
  check_size(state.positions.size(), chordae_.points.size(), "chordae positions", false);
  check_size(state.tensions.size(), chordae_.segments.size(), "chordae tensions");
  vtkNew<vtkPolyData> data;
  vtk::add_header(data->GetFieldData(), state.time);
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (const Vec3& x : state.positions) points->InsertNextPoint(to_world_mm(frame_, x).data());
  data->SetPoints(points);
  vtkNew<vtkCellArray> lines;
  for (const ChordaSegment& s : chordae_.segments) {
    const vtkIdType ends[2] = {s.a, s.b};
    lines->InsertNextCell(2, ends);
  }
  data->SetLines(lines);
  const auto count = ssize_of(chordae_.segments);
  const auto segment = [&](std::ptrdiff_t i) -> const ChordaSegment& { return chordae_.segments[static_cast<std::size_t>(i)]; };
  vtk::add_scalars<vtkIntArray>(data, data->GetCellData(), "kind", "1", count, [&](auto i) { return static_cast<int>(segment(i).kind); });
  vtk::add_scalars<vtkIntArray>(data, data->GetCellData(), "muscle", "1", count, [&](auto i) { return segment(i).muscle; });
  vtk::add_scalars<vtkIntArray>(data, data->GetCellData(), "leaflet", "1", count, [&](auto i) { return segment(i).leaflet; });
  if (!state.tensions.empty())
    vtk::add_scalars<vtkFloatArray>(data, data->GetCellData(), "tension", "N", count,
                                    [&](auto i) { return state.tensions[static_cast<std::size_t>(i)]; });
  return store(chordae_frames_, state.time, vtk::to_bytes<vtkXMLPolyDataWriter>(data));
}

fs::path FrameWriter::write_fluid(const FluidState& state) {
  const auto& [nx, ny, nz] = state.grid.cells;
  vtkNew<vtkImageData> image;
  vtk::add_header(image->GetFieldData(), state.time);
  image->SetDimensions(nx + 1, ny + 1, nz + 1);
  const double spacing = mm_per_m * state.grid.spacing;
  image->SetSpacing(spacing, spacing, spacing);
  image->SetOrigin(to_world_mm(frame_, state.grid.lower).data());
  // columns of the direction matrix are the grid's axes in the world
  vtkNew<vtkMatrix3x3> direction;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) direction->SetElement(r, c, frame_.axes(c, r));
  image->SetDirectionMatrix(direction);

  const std::ptrdiff_t count = std::ptrdiff_t{nx} * ny * nz;
  const auto cell = [nx = nx, ny = ny](std::ptrdiff_t c) {
    return std::array<int, 3>{static_cast<int>(c % nx), static_cast<int>(c / nx % ny), static_cast<int>(c / nx / ny)};
  };
  vtk::add_vectors<vtkFloatArray>(image, image->GetCellData(), "velocity", "m/s", 3, count, [&](auto c) {
    const auto [i, j, k] = cell(c);
    return turn_to_world(frame_, state.velocity(i, j, k));
  });
  vtk::add_scalars<vtkFloatArray>(image, image->GetCellData(), "pressure", "mmHg", count, [&](auto c) {
    const auto [i, j, k] = cell(c);
    return state.pressure(i, j, k) / pascal_per_mmHg;
  });
  if (state.is_blood)
    vtk::add_scalars<vtkUnsignedCharArray>(image, image->GetCellData(), "inside", "1", count, [&](auto c) {
      const auto [i, j, k] = cell(c);
      return state.is_blood(i, j, k) ? 1 : 0;
    });
  return store(fluid_, state.time, vtk::to_bytes<vtkXMLImageDataWriter>(image));
}

void write_pvd(const fs::path& file, std::span<const PvdEntry> entries) {
  std::ostringstream xml;
  xml << "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n  <Collection>\n";
  for (const PvdEntry& e : entries)
    xml << "    <DataSet timestep=\"" << format_number(e.time) << "\" group=\"\" part=\"0\" file=\"" << escaped(e.file) << "\"/>\n";
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
