// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/loft/curve_files.h"

#include <gtest/gtest.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

#include <fstream>

#include "geometry/core/errors.h"
#include "geometry/core/vtk_dataset.h"
#include "unit/core/sample_case.h"

using namespace mv;
using mv_test::TemporaryDirectory;

namespace {

CurveSet read(const TemporaryDirectory& dir, const std::string& name, const std::string& text, bool is_lps = false) {
  std::ofstream(dir / name) << text;
  CurveSet set;
  read_curves(dir / name, is_lps, set);
  return set;
}

std::string message_of(const std::string& name, const std::string& text) {
  const TemporaryDirectory dir;
  try {
    read(dir, name, text);
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

std::string markup(const std::string& type, const std::string& system, const std::string& points, const std::string& more = "") {
  return R"({"markups":[{"type":")" + type + R"(","coordinateSystem":)" + system + R"(,"coordinateUnits":"mm",)" + more + R"("controlPoints":[)" + points + "]}]}";
}

const std::string three = R"({"position":[1,2,3],"positionStatus":"defined"},{"position":[4,5,6]},{"position":[7,8,9]})";

#define EXPECT_NAMES(message, part) EXPECT_NE((message).find(part), std::string::npos) << (message)

}  // namespace

TEST(CurveFiles, csv_gives_curves_annulus_and_papillary_points) {
  const TemporaryDirectory dir;
  std::string text = "curve,leaflet,x_mm,y_mm,z_mm,thickness_mm\n1,anterior,1,2,3,0.9\n1,anterior,2,2,3,1\n1,posterior,5,5,5,1\n1,anterior,3,2,3,1.1\n0,papillary_posteromedial,9,8,7,1\n";
  for (int i = 0; i < 8; ++i) text += "0,annulus," + std::to_string(15 * std::cos(0.8 * i)) + "," + std::to_string(15 * std::sin(0.8 * i)) + ",0,1\n";
  const CurveSet set = read(dir, "c.csv", text);
  ASSERT_EQ(set.curves.size(), 2u);
  EXPECT_EQ(set.curves[0].region, anterior);
  EXPECT_EQ(set.curves[0].points.size(), 3u);
  EXPECT_EQ(set.curves[0].thickness[2], 1.1);
  EXPECT_EQ(set.annulus_curve.size(), 8u);
  ASSERT_EQ(set.papillary_points.size(), 1u);
  EXPECT_EQ(set.papillary_names[0], "posteromedial");
  const CurveSet lps = read(dir, "l.csv", text, true);
  EXPECT_EQ(lps.curves[0].points[0], Vec3(-1, -2, 3));
}

TEST(CurveFiles, csv_defects_are_named_with_their_line) {
  EXPECT_NAMES(message_of("c.csv", "leaflet,curve,x,y,z\n"), "column 'x_mm'");
  EXPECT_NAMES(message_of("c.csv", "leaflet,curve,x_mm,y_mm,z_mm\nanterior,1,1,2,three\n"), "line 2: z_mm: 'three'");
  EXPECT_NAMES(message_of("c.csv", "leaflet,curve,x_mm,y_mm,z_mm\nanterior,1,1,2,nan\n"), "line 2: z_mm: 'nan'");
  EXPECT_NAMES(message_of("c.csv", "leaflet,curve,x_mm,y_mm,z_mm\nanterior,1,1,2\n"), "line 2: z_mm: ''");
  EXPECT_NAMES(message_of("c.csv", "leaflet,curve,x_mm,y_mm,z_mm\nseptal,1,1,2,3\n"), "'septal'");
  EXPECT_NAMES(message_of("c.csv", "leaflet,curve,x_mm,y_mm,z_mm\n"), "no points");
  EXPECT_NAMES(message_of("c.csv", ""), "is empty");
  EXPECT_NAMES(message_of("c.csv", "leaflet,curve,x_mm,y_mm,z_mm\nannulus,1,1,2,3\n"), "at least 8");
  EXPECT_NAMES(message_of("c.txt", "x"), "unknown kind");
}

TEST(CurveFiles, slicer_markups_are_turned_from_lps_to_ras_by_their_own_word) {
  const TemporaryDirectory dir;
  const CurveSet lps = read(dir, "anterior_1.mrk.json", markup("Curve", "\"LPS\"", three));
  ASSERT_EQ(lps.curves.size(), 1u);
  EXPECT_EQ(lps.curves[0].region, anterior);
  EXPECT_EQ(lps.curves[0].points[1], Vec3(-4, -5, 6));
  const CurveSet ras = read(dir, "x.mrk.json", markup("Curve", "\"RAS\"", three, R"("name":"posterior P2",)"));
  EXPECT_EQ(ras.curves[0].region, posterior);
  EXPECT_EQ(ras.curves[0].points[1], Vec3(4, 5, 6));
  const CurveSet muscles = read(dir, "muscles.mrk.json", markup("Fiducial", "\"RAS\"", R"({"label":"anterolateral","position":[1,2,3]},{"label":"","position":[1,2,4],"positionStatus":"undefined"})"));
  ASSERT_EQ(muscles.papillary_points.size(), 1u);
  EXPECT_EQ(muscles.papillary_names[0], "anterolateral");
}

TEST(CurveFiles, markup_defects_are_named) {
  EXPECT_NAMES(message_of("anterior.mrk.json", markup("Plane", "\"LPS\"", three)), "type \"Plane\"");
  EXPECT_NAMES(message_of("anterior.mrk.json", markup("Curve", "\"scanner\"", three)), "coordinateSystem \"scanner\"");
  EXPECT_NAMES(message_of("anterior.mrk.json", markup("Curve", "7", three)), "coordinateSystem 7");
  EXPECT_NAMES(message_of("one.mrk.json", markup("Curve", "\"LPS\"", three)), "tells the leaflet");
  EXPECT_NAMES(message_of("anterior.mrk.json", markup("Curve", "\"LPS\"", R"({"position":[1,2]})")), "position of three");
  EXPECT_NAMES(message_of("anterior.mrk.json", markup("Curve", "\"LPS\"", R"({"position":[1,2,"x"]})")), "not a finite number");
  EXPECT_NAMES(message_of("anterior.mrk.json", "{\"markups\":[{\"type\":"), "not valid JSON");
  EXPECT_NAMES(message_of("anterior.mrk.json", "{\"points\":[]}"), "no list 'markups'");
  EXPECT_NAMES(message_of("anterior.mrk.json", "{\"markups\":[{\"type\":3}]}"), "type");
}

TEST(CurveFiles, polylines_with_leaflet_array) {
  const TemporaryDirectory dir;
  vtkNew<vtkPolyData> data;
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> lines;
  for (int k = 0; k < 2; ++k) {
    lines->InsertNextCell(4);
    for (int i = 0; i < 4; ++i) lines->InsertCellPoint(points->InsertNextPoint(i, k, 0));
  }
  data->SetPoints(points);
  data->SetLines(lines);
  const std::vector<int> regions = {1, 2}, wrong = {1, 5};
  data->GetCellData()->AddArray(integer_array("leaflet", regions));
  write_vtk(dir / "lines.vtp", data);
  CurveSet set;
  read_curves(dir / "lines.vtp", false, set);
  ASSERT_EQ(set.curves.size(), 2u);
  EXPECT_EQ(set.curves[1].region, anterior);
  EXPECT_EQ(set.curves[1].points[3], Vec3(3, 1, 0));
  data->GetCellData()->AddArray(integer_array("leaflet", wrong));
  write_vtk(dir / "wrong.vtp", data);
  EXPECT_THROW(read_curves(dir / "wrong.vtp", false, set), InputError);
  data->SetLines(nullptr);
  data->GetCellData()->Initialize();
  write_vtk(dir / "none.vtp", data);
  EXPECT_THROW(read_curves(dir / "none.vtp", false, set), InputError);
}
