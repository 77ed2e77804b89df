// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "geometry/core/errors.h"
#include "geometry/surface/read_surface.h"

namespace {

using mv::InputError;
using mv::RawSurface;
using mv::read_surface;

std::filesystem::path file_of(const std::string& name, const std::string& text) {
  const auto path = std::filesystem::path(testing::TempDir()) / ("read_surface_" + std::to_string(::getpid()) + "_" + name);
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

double area_of(const RawSurface& s) {
  double area = 0;
  for (const auto& t : s.triangles) {
    const auto p = [&](std::size_t k) { return s.points[static_cast<std::size_t>(t[k])]; };
    area += 0.5 * (p(1) - p(0)).cross(p(2) - p(0)).norm();
  }
  return area;
}

/// The error says each of the words.
void expect_refused(const std::string& name, const std::string& text, const std::vector<std::string>& words) {
  try {
    read_surface(file_of(name, text));
    ADD_FAILURE() << name << " was accepted";
  } catch (const InputError& e) {
    std::printf("%s: %s\n", name.c_str(), e.what());
    for (const auto& word : words) EXPECT_NE(std::string(e.what()).find(word), std::string::npos) << word << " not in: " << e.what();
    EXPECT_NE(std::string(e.what()).find(name), std::string::npos) << "the file is not named";
  }
}

template <class T>
std::string bytes(T value) {
  std::string out(sizeof value, '\0');
  std::memcpy(out.data(), &value, sizeof value);
  return out;
}

const float square[2][9] = {{0, 0, 0, 2, 0, 0, 2, 3, 0}, {0, 0, 0, 2, 3, 0, 0, 3, 0}};  // 2 x 3

std::string binary_stl(std::uint32_t count) {
  std::string text(80, ' ');
  text.replace(0, 12, "solid binary");  // many programs write it
  text += bytes(count);
  for (const auto& t : square) {
    text += std::string(12, '\0');
    for (float x : t) text += bytes(x);
    text += std::string(2, '\0');
  }
  return text;
}

const std::string ascii_stl =
    "solid a\nfacet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 2.0e0 0 0\n  vertex +2 3 0\n endloop\nendfacet\n"
    "facet normal 0 0 1\r\n outer loop\r\n  vertex 0 0 0\r\n  vertex 2 3 0\r\n  vertex 0 3 0\r\n endloop\r\nendfacet\r\nendsolid a\n";

TEST(ReadSurface, stl_ascii_and_binary_hold_the_same_square) {
  for (const auto& path : {file_of("a.stl", ascii_stl), file_of("b.STL", binary_stl(2))}) {
    const RawSurface s = read_surface(path);
    std::printf("%s: %zu points, %zu triangles, %.1f of 6 mm2\n", path.c_str(), s.points.size(), s.triangles.size(), area_of(s));
    EXPECT_EQ(s.points.size(), 4u);  // corners of both triangles joined
    EXPECT_EQ(s.triangles.size(), 2u);
    EXPECT_DOUBLE_EQ(area_of(s), 6);
    EXPECT_TRUE(s.group.empty());
  }
}

TEST(ReadSurface, stl_defects_are_named) {
  expect_refused("truncated.stl", binary_stl(2).substr(0, 150), {"truncated", "184", "150"});
  expect_refused("giant.stl", binary_stl(4000000000u), {"4000000000"});
  expect_refused("empty.stl", "", {"empty"});
  expect_refused("none.stl", std::string(80, ' ') + bytes(std::uint32_t{0}), {"no triangle"});
  expect_refused("cut.stl", ascii_stl.substr(0, 170), {"truncated", "endsolid"});
  expect_refused("word.stl", "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 zero 0\n", {"line 4", "zero"});
  expect_refused("nan.stl", "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 nan 0\n", {"line 4", "nan"});
  std::string with_nan = binary_stl(2);
  with_nan.replace(84 + 12, 4, bytes(std::numeric_limits<float>::quiet_NaN()));
  expect_refused("nan_binary.stl", with_nan, {"triangle 0", "not finite"});
  expect_refused("surface.stp", "x", {".stp", ".stl"});
  EXPECT_THROW(read_surface(std::filesystem::path(testing::TempDir()) / "read_surface_absent.stl"), mv::IoError);
}

TEST(ReadSurface, obj_quads_groups_and_negative_indices) {
  const RawSurface s = read_surface(file_of("quads.obj",
                                            "# c\nv 0 0 0\nv 2 0 0\nv 2 3 0\nv 0 3 0\nvn 0 0 1\ng anterior\nf 1/1/1 2/2/1 3/3/1 4/4/1\n"
                                            "v 0 6 0\nv 2 6 0\ng posterior\nf -4 -1 -2 4\n"));
  std::printf("quads.obj: %zu triangles, %.1f of 12 mm2\n", s.triangles.size(), area_of(s));
  EXPECT_EQ(s.triangles.size(), 4u);
  EXPECT_NEAR(area_of(s), 12, 1e-12);
  ASSERT_EQ(s.group_names.size(), 2u);
  EXPECT_EQ(s.group, (std::vector<int>{0, 0, 1, 1}));
  EXPECT_EQ(s.group_names[1], "posterior");
  EXPECT_EQ(s.notes.size(), 1u);
}

TEST(ReadSurface, obj_concave_polygon_keeps_its_area) {
  const RawSurface s = read_surface(file_of("arrow.obj", "v 0 0 0\nv 4 -2 0\nv 1 0 0\nv 4 2 0\nf 1 2 3 4\n"));
  EXPECT_NEAR(area_of(s), 2, 1e-12);  // a fan from the wrong corner covers more
}

TEST(ReadSurface, obj_defects_are_named) {
  expect_refused("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n", {"line 4", "point 7 of 3"});
  expect_refused("zero.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", {"line 4", "count from 1"});
  expect_refused("negative.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -9 1 2\n", {"line 4", "-9"});
  expect_refused("two.obj", "v 0 0 0\nv 1 0 0\nf 1 2\n", {"line 3", "2 corners"});
  expect_refused("nan.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", {"line 1", "nan"});
  expect_refused("points.obj", "v 0 0 0\n", {"no triangle"});
}

const std::string ply_head = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";

TEST(ReadSurface, ply_ascii_and_both_byte_orders) {
  std::string little, big;
  const auto add = [&](auto value) {
    std::string b = bytes(value);
    little += b;
    std::reverse(b.begin(), b.end());
    big += b;
  };
  for (float x : {0.f, 0.f, 0.f, 2.f, 0.f, 0.f, 2.f, 3.f, 0.f, 0.f, 3.f, 0.f}) add(x);
  add(std::uint8_t{4});
  for (std::int32_t i : {0, 1, 2, 3}) add(i);
  for (const auto& path : {file_of("a.ply", "ply\nformat ascii 1.0\n" + ply_head + "0 0 0\n2 0 0\n2 3 0\n0 3 0\n4 0 1 2 3\n"),
                           file_of("l.ply", "ply\nformat binary_little_endian 1.0\n" + ply_head + little),
                           file_of("b.ply", "ply\nformat binary_big_endian 1.0\n" + ply_head + big)}) {
    const RawSurface s = read_surface(path);
    std::printf("%s: %zu triangles, %.1f of 6 mm2\n", path.c_str(), s.triangles.size(), area_of(s));
    EXPECT_EQ(s.triangles.size(), 2u);
    EXPECT_DOUBLE_EQ(area_of(s), 6);
  }
  expect_refused("short.ply", "ply\nformat binary_little_endian 1.0\n" + ply_head + little.substr(0, 55), {"truncated"});
  expect_refused("index.ply", "ply\nformat ascii 1.0\n" + ply_head + "0 0 0\n2 0 0\n2 3 0\n0 3 0\n4 0 1 2 4\n", {"face 0", "point 4 of 4"});
  expect_refused("count.ply", "ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n", {"4000000000"});
  expect_refused("head.ply", "ply\nformat ascii 1.0\nelement vertex 3\n", {"header"});
}

TEST(ReadSurface, vtp_and_legacy_vtk_with_labels) {
  const std::string vtp =
      "<?xml version=\"1.0\"?><VTKFile type=\"PolyData\" version=\"0.1\" byte_order=\"LittleEndian\"><PolyData><Piece NumberOfPoints=\"4\" NumberOfVerts=\"0\" "
      "NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"2\"><CellData><DataArray type=\"Int32\" Name=\"leaflet\" format=\"ascii\">2 1</DataArray>"
      "</CellData><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 2 0 0 2 3 0 0 3 0</DataArray></Points><Polys>"
      "<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2 0 2 3</DataArray><DataArray type=\"Int64\" Name=\"offsets\" "
      "format=\"ascii\">3 6</DataArray></Polys></Piece></PolyData></VTKFile>\n";
  const std::string vtk = "# vtk DataFile Version 3.0\nsquare\nASCII\nDATASET POLYDATA\nPOINTS 4 double\n0 0 0 2 0 0 2 3 0 0 3 0\nPOLYGONS 1 5\n4 0 1 2 3\n";
  const RawSurface s = read_surface(file_of("a.vtp", vtp)), q = read_surface(file_of("a.vtk", vtk));
  std::printf("vtp %.1f, vtk %.1f of 6 mm2\n", area_of(s), area_of(q));
  EXPECT_DOUBLE_EQ(area_of(s), 6);
  EXPECT_EQ(s.group, (std::vector<int>{0, 1}));
  EXPECT_EQ(s.group_names, (std::vector<std::string>{"2", "1"}));
  EXPECT_DOUBLE_EQ(area_of(q), 6);
  EXPECT_EQ(q.triangles.size(), 2u);
  expect_refused("cut.vtp", vtp.substr(0, 500), {});
  expect_refused("text.vtk", "no surface\n", {"VTK"});
}

TEST(ReadSurface, units_scale_and_wrong_ones_are_named) {
  const auto path = file_of("metres.obj", "v 0 0 0\nv 0.03 0 0\nv 0 0.04 0\nf 1 2 3\n");
  const RawSurface metres = read_surface(path, "m");
  EXPECT_NEAR(area_of(metres), 600, 1e-9);
  EXPECT_NO_THROW(mv::expect_valve_size(metres, "metres.obj", "m"));
  const auto told = [&](const RawSurface& s, const std::string& unit) -> std::string {
    try {
      mv::expect_valve_size(s, "metres.obj", unit);
    } catch (const InputError& e) {
      std::printf("%s\n", e.what());
      return e.what();
    }
    return "accepted";
  };
  const std::string small = told(read_surface(path), "auto");
  EXPECT_NE(small.find("0.05 mm from corner"), std::string::npos);
  EXPECT_NE(small.find("set surface.unit = \"m\""), std::string::npos);
  const auto in_mm = file_of("mm.obj", "v 0 0 0\nv 30 0 0\nv 0 40 0\nf 1 2 3\n");
  const std::string large = told(read_surface(in_mm, "m"), "m");
  EXPECT_NE(large.find("set surface.unit = \"mm\""), std::string::npos);
}

}  // namespace
