// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/export_case.h"

#include <gtest/gtest.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkFieldData.h>
#include <vtkNew.h>
#include <vtkStringArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridReader.h>

#include "geometry/core/case_files.h"
#include "geometry/core/config.h"
#include "unit/core/sample_case.h"

using mv_test::TemporaryDirectory;

namespace {

vtkSmartPointer<vtkUnstructuredGrid> raw(const std::string& file) {
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  reader->SetFileName(file.c_str());
  reader->Update();
  return reader->GetOutput();
}

void expect_turned(const double* got, const mv::Vec3& was) {
  EXPECT_EQ(got[0], -was.x());
  EXPECT_EQ(got[1], -was.y());
  EXPECT_EQ(got[2], was.z());
}

}  // namespace

TEST(ExportCase, lps_turns_points_and_vectors_about_the_third_axis_and_nothing_else) {
  const TemporaryDirectory dir;
  std::filesystem::create_directories(dir / "case");
  mv::write_text_atomically(dir / "case/case.toml", "format_version = 1\n" + mv::Config().to_toml() + "\n[provenance]\n");
  const mv::LeafletMesh mesh = mv_test::sample_leaflets(1);
  const mv::Tube tube = mv_test::sample_tube();
  mv::write_leaflets(dir / "case/leaflets.vtu", mesh);
  mv::write_tube(dir / "case/tube.vtu", tube);
  const auto written = mv::export_case(dir / "case", dir / "out", "LPS");
  ASSERT_EQ(written.size(), 2u) << "what does not exist is left out";

  const auto leaflets = raw(dir / "out/leaflets.vtu");
  ASSERT_EQ(static_cast<std::size_t>(leaflets->GetNumberOfPoints()), mesh.points.size());
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    expect_turned(leaflets->GetPoint(static_cast<vtkIdType>(i)), mesh.points[i]);
  for (std::size_t e = 0; e < mesh.fibre.size(); ++e)
    expect_turned(leaflets->GetCellData()->GetArray("fibre")->GetTuple3(static_cast<vtkIdType>(e)), mesh.fibre[e]);
  EXPECT_EQ(vtkStringArray::SafeDownCast(leaflets->GetFieldData()->GetAbstractArray("SPACE"))->GetValue(0), "LPS");

  const auto box = raw(dir / "out/tube.vtu");
  expect_turned(box->GetFieldData()->GetArray("origin")->GetTuple3(0), tube.origin);
  const double* axes = box->GetFieldData()->GetArray("axes")->GetTuple9(0);
  for (int row = 0; row < 3; ++row) expect_turned(axes + 3 * row, tube.axes.row(row));
  const double* lower = box->GetFieldData()->GetArray("grid_lower")->GetTuple3(0);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(lower[k], tube.grid_lower[k]) << "the grid lies in the tube's own frame";
}
