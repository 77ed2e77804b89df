// SPDX-License-Identifier: GPL-3.0-or-later
// A known Y in every format: a root 10 below a branch point, two ends 5 from it.
#include "geometry/chordae/chordae_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "geometry/chordae/outline_file.h"
#include "geometry/core/errors.h"

namespace {

using namespace mv;

class ChordaeFile : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    const auto file = std::filesystem::path(::testing::TempDir()) / ("chordae_file_" + std::to_string(::getpid()) + "_" + name);
    std::ofstream(file) << text;
    return file;
  }
  std::string message_of(const std::filesystem::path& file, const ChordaeFileOptions& options = {}) const {
    try {
      read_chordae_file(file, options);
    } catch (const InputError& e) {
      return e.what();
    }
    return "no InputError";
  }
};

const std::string swc = "# Y\n1 0 0 0 0 0.3 -1\n2 0 0 0 10 0.3 1\n3 0 3 0 14 0.2 2\n4 0 -3 0 14 0.2 2\n";
const std::string csv = "x0,y0,z0,x1,y1,z1,radius\n0,0,0,0,0,10,0.3\n0,0,10,3,0,14,0.2\n0,0,10,-3,0,14,0.2\n";
const std::string vtk =
    "# vtk DataFile Version 3.0\nY\nASCII\nDATASET POLYDATA\nPOINTS 5 double\n0 0 0  0 0 10  3 0 14  0 0 10  -3 0 14\n"
    "LINES 2 7\n3 0 1 2\n2 3 4\nPOINT_DATA 5\nSCALARS radius double 1\nLOOKUP_TABLE default\n0.3 0.3 0.3 0.3 0.3\nSCALARS fixed int 1\nLOOKUP_TABLE default\n1 0 0 0 0\n";
const std::string vtp =
    "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\"><PolyData>\n"
    "<Piece NumberOfPoints=\"4\" NumberOfVerts=\"0\" NumberOfLines=\"3\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n"
    "<CellData><DataArray type=\"Float64\" Name=\"area\" format=\"ascii\">0.5 0.25 0.25</DataArray></CellData>\n"
    "<Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 0 0 10 3 0 14 -3 0 14</DataArray></Points>\n"
    "<Lines><DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 1 2 1 3</DataArray>"
    "<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">2 4 6</DataArray></Lines>\n</Piece></PolyData></VTKFile>\n";

double length_of(const RawChordae& raw) {
  double sum = 0;
  for (const auto& [a, b] : raw.segments) sum += (raw.points[static_cast<std::size_t>(a)] - raw.points[static_cast<std::size_t>(b)]).norm();
  return sum;
}

TEST_F(ChordaeFile, every_format_gives_the_same_tree) {
  for (const auto& file : {write("y.swc", swc), write("y.csv", csv), write("y.vtk", vtk), write("y.vtp", vtp)}) {
    SCOPED_TRACE(file.string());
    const RawChordae raw = read_chordae_file(file);
    EXPECT_EQ(raw.points.size(), 4u);  // the shared branch point is one
    ASSERT_EQ(raw.segments.size(), 3u);
    EXPECT_NEAR(length_of(raw), 10 + 5 + 5, 1e-12);
  }
}

TEST_F(ChordaeFile, cross_sections_and_roots_are_read) {
  const RawChordae tree = read_chordae_file(write("y2.swc", swc));
  EXPECT_EQ(std::count(tree.is_root.begin(), tree.is_root.end(), 1), 1);
  EXPECT_NEAR(tree.area[0], std::numbers::pi * 0.09, 1e-12);
  EXPECT_NEAR(tree.area[1], std::numbers::pi * 0.04, 1e-12);
  const RawChordae legacy = read_chordae_file(write("y2.vtk", vtk));
  EXPECT_EQ(std::count(legacy.is_root.begin(), legacy.is_root.end(), 1), 1);
  EXPECT_NEAR(read_chordae_file(write("y2.vtp", vtp)).area[0], 0.5, 1e-12);
  EXPECT_TRUE(std::isnan(read_chordae_file(write("n.csv", "x0,y0,z0,x1,y1,z1\n0,0,0,1,0,0\n")).area[0]));
}

TEST_F(ChordaeFile, units_and_space_are_applied) {
  ChordaeFileOptions cm;
  cm.unit = "cm";
  cm.space = ChordaeSpace::lps;
  const RawChordae raw = read_chordae_file(write("cm.csv", csv), cm);
  EXPECT_NEAR(length_of(raw), 200, 1e-9);
  EXPECT_NEAR(raw.area[0], 100 * std::numbers::pi * 0.09, 1e-9);
  EXPECT_NEAR(raw.points[2].x(), -30, 1e-12);
  const RawChordae own = read_chordae_file(write("own.csv", "x0_cm,y0_cm,z0_cm,x1_cm,y1_cm,z1_cm,area_mm2,rest_length_cm\n0,0,0,1,0,0,0.4,1.1\n"));
  EXPECT_NEAR(length_of(own), 10, 1e-12);
  EXPECT_NEAR(own.area[0], 0.4, 1e-12);
  EXPECT_NEAR(own.rest_length[0], 11, 1e-12);
}

TEST_F(ChordaeFile, a_case_written_as_csv_comes_back) {
  Chordae c;
  c.points = {{0, 0, 0}, {0, 0, 10}, {3, 0, 14}, {-3, 0, 14.000000001}};
  c.muscle_of_point = {0, -1, -1, -1};
  c.segments = {{0, 1, ChordaKind::strut, 0, anterior, 10.5, 0.4}, {1, 2, ChordaKind::basal, 0, anterior, 5.25, 0.2}, {1, 3, ChordaKind::marginal, 0, anterior, 5.125, 0.2}};
  c.insertions = {{2, 0, 1}, {3, 1, 1}};
  const auto file = write("case.csv", "");
  write_chordae_csv(file, c);
  const RawChordae raw = read_chordae_file(file);
  ASSERT_EQ(raw.segments.size(), 3u);
  for (std::size_t s = 0; s < 3; ++s) {
    EXPECT_EQ(raw.rest_length[s], c.segments[s].rest_length);
    EXPECT_EQ(raw.area[s], c.segments[s].area);
    EXPECT_EQ(raw.kind[s], static_cast<int>(c.segments[s].kind));
    EXPECT_EQ(raw.points[static_cast<std::size_t>(raw.segments[s][1])], c.points[static_cast<std::size_t>(c.segments[s].b)]);
  }
  EXPECT_EQ(raw.is_root, (std::vector<char>{1, 0, 0, 0}));
  EXPECT_EQ(raw.is_leaflet_end, (std::vector<char>{0, 0, 1, 1}));
}

TEST_F(ChordaeFile, repeated_and_empty_segments_are_left_out_with_a_note) {
  const RawChordae raw = read_chordae_file(write("twice.csv", "x0,y0,z0,x1,y1,z1\n0,0,0,1,0,0\n1,0,0,0,0,0\n2,2,2,2,2,2\n"));
  EXPECT_EQ(raw.segments.size(), 1u);
  EXPECT_EQ(raw.notes.size(), 2u);
}

TEST_F(ChordaeFile, bad_files_are_named_with_line_and_reason) {
  const auto has = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  const std::vector<std::array<std::string, 3>> bad = {
      {"nan.csv", "x0,y0,z0,x1,y1,z1\n0,0,nan,1,0,0\n", "line 2"},
      {"word.csv", "x0,y0,z0,x1,y1,z1\n0,0,a,1,0,0\n", "'a' is not a finite number"},
      {"short.csv", "x0,y0,z0,x1,y1,z1\n0,0,0,1,0\n", "line 2: z1: '' is not a finite number"},
      {"head.csv", "x,y,z\n0,0,0\n", "column 'x0'"},
      {"unit.csv", "x0_furlong,y0,z0,x1,y1,z1\n0,0,0,1,0,0\n", "furlong"},
      {"kind.csv", "x0,y0,z0,x1,y1,z1,kind\n0,0,0,1,0,0,rope\n", "rope"},
      {"area.csv", "x0,y0,z0,x1,y1,z1,area\n0,0,0,1,0,0,-1\n", "expected a positive number"},
      {"none.csv", "x0,y0,z0,x1,y1,z1\n", "no chordae segment"},
      {"empty.csv", "", "is empty"},
      {"negative.csv", "x0,y0,z0,x1,y1,z1,diameter\n0,0,0,1,0,0,-0.5\n", "cross-section is -"},
      {"thick.csv", "x0,y0,z0,x1,y1,z1,diameter\n0,0,0,1,0,0,50\n", "a cross-section of 1.96e+03 mm2"},
      {"cycle.swc", "1 0 0 0 0 1 2\n2 0 0 0 1 1 1\n", "own ancestor"},
      {"orphan.swc", "1 0 0 0 0 1 -1\n2 0 0 0 1 1 7\n", "parent 7"},
      {"twice.swc", "1 0 0 0 0 1 -1\n1 0 0 0 1 1 1\n", "appears twice"},
      {"few.swc", "1 0 0 0 0 1\n", "expected 7"},
      {"text.vtk", "not a vtk file", "not a readable legacy VTK file"},
      {"text.vtp", "<VTKFile", "text.vtp"},
      {"a.stl", "solid", "expected .vtp"}};
  for (const auto& [name, text, part] : bad) {
    const std::string message = message_of(write(name, text));
    std::cout << name << ": " << message << "\n";
    EXPECT_TRUE(has(message, part.c_str())) << name << ": " << message;
    EXPECT_TRUE(has(message, name.c_str())) << name << ": " << message;
  }
  EXPECT_THROW(read_chordae_file("/nowhere/x.csv"), IoError);
  ChordaeFileOptions unit;
  unit.unit = "cubit";
  EXPECT_THROW(read_chordae_file(write("y3.csv", csv), unit), ConfigError);
}

// Texas TriValve 1.1 (Mathur et al. 2022, CC BY 4.0): the numbers were counted with another program. 189 pairs of its nodes and 38 of its
// trusses coincide; the 32 fixed nodes lie in six places.
TEST_F(ChordaeFile, the_tricuspid_sample_is_read_whole) {
  const std::filesystem::path file = std::filesystem::path(MV_SOURCE_DIR) / "../shared/data/texas_trivalve_healthy/Healthy_chordae.vtk";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
  const RawChordae raw = read_chordae_file(file);
  EXPECT_EQ(raw.points.size(), 3755u);
  EXPECT_EQ(raw.segments.size(), 4128u);
  EXPECT_EQ(std::count(raw.is_root.begin(), raw.is_root.end(), 1), 6);
  EXPECT_EQ(std::count(raw.is_leaflet_end.begin(), raw.is_leaflet_end.end(), 1), 1344);
  EXPECT_NEAR(length_of(raw), 9169.48, 0.5);
}

TEST_F(ChordaeFile, outlines_from_csv_and_markups) {
  const auto curves = read_outlines(write("o.csv", "x_mm,y_mm,z_mm,curve\n0,0,0,a\n1,0,0,a\n0,1,0,b\n1,1,0,b\n"), ChordaeSpace::ras);
  ASSERT_EQ(curves.size(), 2u);
  EXPECT_EQ(curves[1][1], Vec3(1, 1, 0));
  const auto marks = read_outlines(write("o.mrk.json", R"({"markups":[{"type":"Curve","coordinateSystem":"LPS","controlPoints":[{"position":[1,2,3]},{"position":[4,5,6]}]}]})"), ChordaeSpace::ras);
  EXPECT_EQ(marks[0][0], Vec3(-1, -2, 3));
  EXPECT_EQ(read_outlines(write("o.vtp", vtp), ChordaeSpace::lps)[1][1], Vec3(-3, 0, 14));
  EXPECT_THROW(read_outlines(write("bad.json", "{"), ChordaeSpace::ras), InputError);
  EXPECT_THROW(read_outlines(write("one.csv", "x_mm,y_mm,z_mm\n0,0,0\n"), ChordaeSpace::ras), InputError);
}

}  // namespace
