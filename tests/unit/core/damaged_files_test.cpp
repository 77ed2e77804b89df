// SPDX-License-Identifier: BSD-3-Clause
// A damaged case must be refused with the file's name, never crash and never be read as something else.
#include <gtest/gtest.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLPolyDataReader.h>
#include <vtkXMLPolyDataWriter.h>
#include <vtkXMLUnstructuredGridReader.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <fstream>
#include <functional>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "unit/core/sample_case.h"

using namespace mv_test;

namespace {

/// Without the synchronisation of write_text_atomically, of which these tests would need thousands.
void write_bytes(const std::filesystem::path& file, const std::string& bytes) { std::ofstream(file, std::ios::binary) << bytes; }

/// Message of the InputError, or what happened instead.
std::string refusal(const std::function<void()>& read) {
  try {
    read();
  } catch (const mv::InputError& e) {
    EXPECT_EQ(e.code(), mv::ExitCode::input);
    return e.what();
  }
  return "accepted";
}

void expect_holds(const std::string& text, std::initializer_list<const char*> parts) {
  for (const char* part : parts) EXPECT_NE(text.find(part), std::string::npos) << "missing \"" << part << "\" in: " << text;
}

template <class Reader, class Writer, class Data>
void edit(const std::filesystem::path& file, const std::function<void(Data*)>& change) {
  vtkNew<Reader> reader;
  reader->SetFileName(file.c_str());
  reader->Update();
  vtkSmartPointer<Data> data = reader->GetOutput();
  change(data);
  vtkNew<Writer> writer;
  writer->SetFileName(file.c_str());
  writer->SetInputData(data);
  writer->Write();
}

/// Writes the sample leaflets, lets `change` spoil them through VTK and returns how they are refused.
std::string spoiled_leaflets(const std::function<void(vtkUnstructuredGrid*)>& change) {
  const TemporaryDirectory dir;
  mv::write_leaflets(dir / "leaflets.vtu", sample_leaflets(1));
  edit<vtkXMLUnstructuredGridReader, vtkXMLUnstructuredGridWriter, vtkUnstructuredGrid>(dir / "leaflets.vtu", change);
  return refusal([&] { mv::read_leaflets(dir / "leaflets.vtu"); });
}
std::string spoiled_tube(const std::function<void(vtkUnstructuredGrid*)>& change) {
  const TemporaryDirectory dir;
  mv::write_tube(dir / "tube.vtu", sample_tube());
  edit<vtkXMLUnstructuredGridReader, vtkXMLUnstructuredGridWriter, vtkUnstructuredGrid>(dir / "tube.vtu", change);
  return refusal([&] { mv::read_tube(dir / "tube.vtu"); });
}
std::string spoiled_chordae(const std::function<void(vtkPolyData*)>& change) {
  const TemporaryDirectory dir;
  mv::write_chordae(dir / "chordae.vtp", sample_chordae());
  edit<vtkXMLPolyDataReader, vtkXMLPolyDataWriter, vtkPolyData>(dir / "chordae.vtp", change);
  return refusal([&] { mv::read_chordae(dir / "chordae.vtp"); });
}

using Grid = vtkUnstructuredGrid;

}  // namespace

TEST(DamagedFiles, truncation_at_any_place_is_refused) {
  const TemporaryDirectory dir;
  mv::write_leaflets(dir / "whole.vtu", sample_leaflets(1));
  const std::string bytes = mv::read_file(dir / "whole.vtu");
  for (std::size_t size = 0; size < bytes.size(); size += size < 64 ? 1 : 41) {
    const auto file = dir / "leaflets.vtu";
    write_bytes(file, bytes.substr(0, size));
    const bool only_hash_is_cut = bytes.substr(0, size).find("</VTKFile>") != std::string::npos;
    if (!only_hash_is_cut) expect_holds(refusal([&] { mv::read_leaflets(file); }), {"leaflets.vtu", "incomplete"});
  }
}

TEST(DamagedFiles, a_flipped_bit_anywhere_is_refused) {
  const TemporaryDirectory dir;
  mv::write_chordae(dir / "whole.vtp", sample_chordae());
  const std::string bytes = mv::read_file(dir / "whole.vtp");
  const std::size_t hash_line = bytes.rfind("<!-- sha256");
  for (std::size_t i = 0; i < hash_line; i += 13) {
    std::string spoiled = bytes;
    spoiled[i] = static_cast<char>(spoiled[i] ^ (1 << (i % 8)));
    write_bytes(dir / "chordae.vtp", spoiled);
    EXPECT_NE(refusal([&] { mv::read_chordae(dir / "chordae.vtp"); }).find("chordae.vtp"), std::string::npos) << "byte " << i;
  }
}

// Without the SHA-256 line, as in files saved by other programs, VTK itself meets the damage.
TEST(DamagedFiles, a_flipped_bit_without_the_hash_never_crashes) {
  const TemporaryDirectory dir;
  mv::write_papillary(dir / "whole.vtp", sample_papillary());
  std::string bytes = mv::read_file(dir / "whole.vtp");
  bytes.resize(bytes.rfind("<!-- sha256"));
  int refused = 0, tried = 0;
  for (std::size_t i = bytes.find("<AppendedData"); i < bytes.size(); i += 3, ++tried) {
    std::string spoiled = bytes;
    spoiled[i] = static_cast<char>(spoiled[i] ^ 4);
    write_bytes(dir / "papillary.vtp", spoiled);
    try {
      const auto read = mv::read_papillary(dir / "papillary.vtp");
      EXPECT_EQ(read.tips, sample_papillary().tips) << "byte " << i;
      EXPECT_EQ(read.names, sample_papillary().names) << "byte " << i;
    } catch (const mv::InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, tried / 2);
}

TEST(DamagedFiles, other_files_are_refused) {
  const TemporaryDirectory dir;
  for (const char* text :
       {"", "not a VTK file", "<?xml version=\"1.0\"?><VTKFile></VTKFile>", "<VTKFile type=\"UnstructuredGrid\"></VTKFile>"}) {
    write_bytes(dir / "leaflets.vtu", text);
    expect_holds(refusal([&] { mv::read_leaflets(dir / "leaflets.vtu"); }), {"leaflets.vtu"});
  }
  mv::write_chordae(dir / "leaflets.vtu", sample_chordae());
  expect_holds(refusal([&] { mv::read_leaflets(dir / "leaflets.vtu"); }), {"leaflets.vtu", "UnstructuredGrid"});
  mv::write_tube(dir / "leaflets.vtu", sample_tube());
  expect_holds(refusal([&] { mv::read_leaflets(dir / "leaflets.vtu"); }), {"leaflets.vtu"});
  EXPECT_THROW(mv::read_leaflets(dir / "none.vtu"), mv::IoError);
}

TEST(DamagedFiles, the_array_is_named) {
  EXPECT_EQ(spoiled_leaflets([](Grid*) {}), "accepted") << "the harness itself must not spoil the file";
  for (const char* name : {"region", "layer"}) {
    expect_holds(spoiled_leaflets([&](Grid* g) { g->GetCellData()->RemoveArray(name); }), {"leaflets.vtu", name, "is missing"});
  }
  for (const char* name : {"annulus", "free_edge", "side", "unfolded"}) {
    expect_holds(spoiled_leaflets([&](Grid* g) { g->GetPointData()->RemoveArray(name); }), {"leaflets.vtu", name, "is missing"});
  }
  expect_holds(spoiled_leaflets([](Grid* g) { g->GetCellData()->GetArray("region")->SetComponent(1, 0, 7); }),
               {"region", "7", "entry 1"});
  expect_holds(spoiled_leaflets([](Grid* g) { g->GetCellData()->GetArray("layer")->SetComponent(0, 0, -1); }),
               {"layer", "entry 0"});
  expect_holds(spoiled_leaflets([](Grid* g) { g->GetPointData()->GetArray("side")->SetComponent(2, 0, 2); }),
               {"side", "entry 2"});
  expect_holds(spoiled_leaflets([](Grid* g) { g->GetCellData()->GetArray("fibre")->SetComponent(1, 2, std::nan("")); }),
               {"fibre", "not finite", "entry 1"});
  expect_holds(spoiled_leaflets([](Grid* g) { g->GetPoints()->SetPoint(3, 0, HUGE_VAL, 0); }),
               {"points", "not finite", "point 3"});
  expect_holds(spoiled_leaflets([](Grid* g) {
                 vtkNew<vtkDoubleArray> wide;
                 wide->SetName("unfolded");
                 wide->SetNumberOfComponents(3);
                 wide->SetNumberOfTuples(g->GetNumberOfPoints());
                 wide->Fill(0);
                 g->GetPointData()->AddArray(wide);
               }),
               {"unfolded", "3 components", "expected 2"});
  expect_holds(spoiled_leaflets([](Grid* g) { g->GetFieldData()->RemoveArray("SPACE"); }), {"SPACE", "RAS"});
}

TEST(DamagedFiles, an_index_out_of_range_is_refused) {
  for (const vtkIdType index : {5, -1, 1000000}) {
    const auto answer = spoiled_leaflets([&](Grid* g) {
      g->GetCells()->ReplaceCellAtId(1, 4, std::array<vtkIdType, 4>{0, 1, 2, index}.data());
    });
    expect_holds(answer, {"leaflets.vtu"});
    EXPECT_NE(answer, "accepted");
  }
  expect_holds(spoiled_chordae([](vtkPolyData* d) {
                 d->GetLines()->ReplaceCellAtId(1, 2, std::array<vtkIdType, 2>{0, 9}.data());
               }),
               {"chordae.vtp"});
  expect_holds(spoiled_chordae([](vtkPolyData* d) { d->GetFieldData()->GetArray("insertion_point")->SetComponent(1, 0, 4); }),
               {"insertion_point", "entry 1"});
  expect_holds(spoiled_chordae([](vtkPolyData* d) { d->GetFieldData()->GetArray("insertion_node")->SetComponent(0, 0, -2); }),
               {"insertion_node"});
}

TEST(DamagedFiles, chordae_and_tube_defects_name_the_array) {
  EXPECT_EQ(spoiled_chordae([](vtkPolyData*) {}), "accepted");
  EXPECT_EQ(spoiled_tube([](Grid*) {}), "accepted");
  expect_holds(spoiled_chordae([](vtkPolyData* d) { d->GetCellData()->GetArray("kind")->SetComponent(0, 0, 9); }), {"kind"});
  expect_holds(spoiled_chordae([](vtkPolyData* d) { d->GetCellData()->GetArray("rest_length")->SetComponent(2, 0, -1); }),
               {"rest_length", "negative"});
  expect_holds(spoiled_chordae([](vtkPolyData* d) { d->GetCellData()->GetArray("area")->SetComponent(2, 0, std::nan("")); }),
               {"area", "finite"});
  expect_holds(spoiled_chordae([](vtkPolyData* d) { d->GetFieldData()->RemoveArray("insertion_node"); }),
               {"insertion_node", "missing"});
  expect_holds(spoiled_chordae([](vtkPolyData* d) { d->GetFieldData()->GetArray("insertion_node")->SetNumberOfTuples(2); }),
               {"insertion_node", "2 entries, expected 3"});
  expect_holds(spoiled_tube([](Grid* g) { g->GetFieldData()->GetArray("axes")->SetComponent(0, 0, 0.5); }), {"axes", "rotation"});
  expect_holds(spoiled_tube([](Grid* g) { g->GetFieldData()->GetArray("grid_cells")->SetComponent(0, 1, 0); }), {"grid_cells"});
  expect_holds(spoiled_tube([](Grid* g) { g->GetFieldData()->GetArray("grid_spacing")->SetComponent(0, 0, -1); }),
               {"grid_spacing"});
  expect_holds(spoiled_tube([](Grid* g) { g->GetFieldData()->GetArray("z_atrium")->SetComponent(0, 0, -50); }), {"z_ventricle"});
  expect_holds(spoiled_tube([](Grid* g) { g->GetFieldData()->RemoveArray("cross_section"); }), {"cross_section", "missing"});
}
