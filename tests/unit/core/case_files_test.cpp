// SPDX-License-Identifier: BSD-3-Clause
#include "geometry/core/case_files.h"

#include <gtest/gtest.h>
#include <vtkFieldData.h>
#include <vtkNew.h>
#include <vtkStringArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridReader.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include "unit/core/sample_case.h"

using namespace mv_test;

namespace {

void expect_equal(const mv::LeafletMesh& a, const mv::LeafletMesh& b) {
  EXPECT_EQ(a.order, b.order);
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.tets, b.tets);
  EXPECT_EQ(a.region, b.region);
  EXPECT_EQ(a.layer, b.layer);
  EXPECT_EQ(a.fibre, b.fibre);
  EXPECT_EQ(a.sheet_normal, b.sheet_normal);
  EXPECT_EQ(a.on_annulus, b.on_annulus);
  EXPECT_EQ(a.on_free_edge, b.on_free_edge);
  EXPECT_EQ(a.side, b.side);
  EXPECT_EQ(a.unfolded, b.unfolded);
}

}  // namespace

TEST(CaseFiles, leaflets_come_back_to_the_last_bit_in_both_orders) {
  const TemporaryDirectory dir;
  for (int order : {1, 2}) {
    const auto mesh = sample_leaflets(order);
    mv::write_leaflets(dir / "leaflets.vtu", mesh);
    expect_equal(mv::read_leaflets(dir / "leaflets.vtu"), mesh);
  }
}

TEST(CaseFiles, leaflets_without_fibres_stay_without_fibres) {
  const TemporaryDirectory dir;
  auto mesh = sample_leaflets(1);
  mesh.fibre.clear();
  mesh.sheet_normal.clear();
  mv::write_leaflets(dir / "leaflets.vtu", mesh);
  expect_equal(mv::read_leaflets(dir / "leaflets.vtu"), mesh);
}

TEST(CaseFiles, chordae_come_back_to_the_last_bit) {
  const TemporaryDirectory dir;
  const auto a = sample_chordae();
  mv::write_chordae(dir / "chordae.vtp", a);
  const auto b = mv::read_chordae(dir / "chordae.vtp");
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.muscle_of_point, b.muscle_of_point);
  ASSERT_EQ(a.segments.size(), b.segments.size());
  for (std::size_t i = 0; i < a.segments.size(); ++i) {
    EXPECT_EQ(a.segments[i].a, b.segments[i].a);
    EXPECT_EQ(a.segments[i].b, b.segments[i].b);
    EXPECT_EQ(a.segments[i].kind, b.segments[i].kind);
    EXPECT_EQ(a.segments[i].muscle, b.segments[i].muscle);
    EXPECT_EQ(a.segments[i].leaflet, b.segments[i].leaflet);
    EXPECT_EQ(a.segments[i].rest_length, b.segments[i].rest_length);
    EXPECT_EQ(a.segments[i].area, b.segments[i].area);
  }
  ASSERT_EQ(a.insertions.size(), b.insertions.size());
  for (std::size_t i = 0; i < a.insertions.size(); ++i) {
    EXPECT_EQ(a.insertions[i].point, b.insertions[i].point);
    EXPECT_EQ(a.insertions[i].node, b.insertions[i].node);
    EXPECT_EQ(a.insertions[i].weight, b.insertions[i].weight);
  }
}

TEST(CaseFiles, a_valve_without_chordae_has_an_empty_file) {
  const TemporaryDirectory dir;
  mv::write_chordae(dir / "chordae.vtp", {});
  const auto b = mv::read_chordae(dir / "chordae.vtp");
  EXPECT_TRUE(b.points.empty());
  EXPECT_TRUE(b.segments.empty());
  EXPECT_TRUE(b.insertions.empty());
}

TEST(CaseFiles, tube_comes_back_to_the_last_bit) {
  const TemporaryDirectory dir;
  const auto a = sample_tube();
  mv::write_tube(dir / "tube.vtu", a);
  const auto b = mv::read_tube(dir / "tube.vtu");
  EXPECT_EQ(a.origin, b.origin);
  EXPECT_EQ(a.axes, b.axes);
  EXPECT_EQ(a.cross_section, b.cross_section);
  EXPECT_EQ(a.z_ventricle, b.z_ventricle);
  EXPECT_EQ(a.z_atrium, b.z_atrium);
  EXPECT_EQ(a.grid_lower, b.grid_lower);
  EXPECT_EQ(a.grid_cells, b.grid_cells);
  EXPECT_EQ(a.grid_spacing, b.grid_spacing);
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.hexes, b.hexes);
}

TEST(CaseFiles, annulus_and_papillary_come_back_to_the_last_bit) {
  const TemporaryDirectory dir;
  const auto a = sample_annulus();
  mv::write_annulus(dir / "annulus.vtp", a);
  const auto b = mv::read_annulus(dir / "annulus.vtp");
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.origin, b.origin);
  EXPECT_EQ(a.normal, b.normal);
  EXPECT_EQ(a.axis_major, b.axis_major);
  EXPECT_EQ(a.residual_rms, b.residual_rms);
  EXPECT_EQ(a.eigenvalues, b.eigenvalues);
  EXPECT_EQ(a.sign_rule, b.sign_rule);
  const auto p = sample_papillary();
  mv::write_papillary(dir / "papillary.vtp", p);
  const auto q = mv::read_papillary(dir / "papillary.vtp");
  EXPECT_EQ(p.tips, q.tips);
  EXPECT_EQ(p.names, q.names);
}

TEST(CaseFiles, same_data_give_the_same_bytes) {
  const TemporaryDirectory dir;
  mv::write_leaflets(dir / "a.vtu", sample_leaflets(2));
  mv::write_leaflets(dir / "b.vtu", sample_leaflets(2));
  mv::write_chordae(dir / "a.vtp", sample_chordae());
  mv::write_chordae(dir / "b.vtp", sample_chordae());
  EXPECT_EQ(mv::sha256_of_file(dir / "a.vtu"), mv::sha256_of_file(dir / "b.vtu"));
  EXPECT_EQ(mv::sha256_of_file(dir / "a.vtp"), mv::sha256_of_file(dir / "b.vtp"));
}

// What other programs do: open by file name, and save it anew without our SHA-256 line.
TEST(CaseFiles, vtk_opens_the_file_and_a_file_saved_by_vtk_is_accepted) {
  const TemporaryDirectory dir;
  const auto mesh = sample_leaflets(1);
  mv::write_leaflets(dir / "a.vtu", mesh);
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  reader->SetFileName((dir / "a.vtu").c_str());
  reader->Update();
  ASSERT_EQ(reader->GetErrorCode(), 0u);
  ASSERT_EQ(reader->GetOutput()->GetNumberOfCells(), 2);
  auto text = [&](const char* name) {
    auto* array = vtkStringArray::SafeDownCast(reader->GetOutput()->GetFieldData()->GetAbstractArray(name));
    return array ? array->GetValue(0) : "missing";
  };
  EXPECT_EQ(text("UnitSystem"), "mm");
  EXPECT_EQ(text("SPACE"), "RAS");
  for (const char* name : {"points", "region", "layer", "fibre", "sheet_normal", "annulus", "free_edge", "side", "unfolded"}) {
    EXPECT_NE(text((std::string("unit:") + name).c_str()), "missing") << name;
  }
  vtkNew<vtkXMLUnstructuredGridWriter> writer;
  writer->SetFileName((dir / "b.vtu").c_str());
  writer->SetInputData(reader->GetOutput());
  writer->SetDataModeToAscii();
  ASSERT_EQ(writer->Write(), 1);
  const auto again = mv::read_leaflets(dir / "b.vtu");
  EXPECT_EQ(again.tets, mesh.tets);
  EXPECT_EQ(again.region, mesh.region);
}

TEST(CaseFiles, writers_refuse_inconsistent_structs) {
  const TemporaryDirectory dir;
  auto mesh = sample_leaflets(1);
  mesh.region.pop_back();
  EXPECT_THROW(mv::write_leaflets(dir / "a.vtu", mesh), std::logic_error);
  mesh = sample_leaflets(1);
  mesh.tets[0][0] = 99;
  EXPECT_THROW(mv::write_leaflets(dir / "a.vtu", mesh), std::logic_error);
  mesh = sample_leaflets(1);
  mesh.points[0].x() = std::nan("");
  EXPECT_THROW(mv::write_leaflets(dir / "a.vtu", mesh), std::logic_error);
  EXPECT_FALSE(std::filesystem::exists(dir / "a.vtu"));
}
