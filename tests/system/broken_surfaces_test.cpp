// SPDX-License-Identifier: GPL-3.0-or-later
// `mvprep surface` on surfaces that are broken, strange or no valve at all: each ends with its exit code and the reason, or in a source with a warning. 
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <numbers>
#include <sstream>

#include "geometry/core/case_files.h"
#include "unit/core/sample_case.h"

using mv_test::TemporaryDirectory;

namespace {

constexpr double pi = std::numbers::pi;

struct Outcome {
  int code = -1;  // 124: did not end
  std::string err;
};

Outcome mvprep(const std::string& arguments, const TemporaryDirectory& dir) {
  const std::string command = "timeout 120 " + std::string(MV_BIN_DIR) + "/mvprep " + arguments + " > '" + (dir / "stdout").string() + "' 2> '" + (dir / "stderr").string() + "'";
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, mv::read_file(dir / "stderr")};
}

struct Shape {
  std::vector<mv::Vec3> points;
  std::vector<std::array<int, 4>> quads;  // a triangle has its last point twice

  std::string obj() const {
    std::ostringstream out;
    out.precision(9);
    for (const mv::Vec3& p : points) out << "v " << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
    for (const auto& q : quads) {
      out << 'f';
      for (int k = 0; k < (q[2] == q[3] ? 3 : 4); ++k) out << ' ' << q[static_cast<std::size_t>(k)] + 1;
      out << '\n';
    }
    return out.str();
  }
};

/// Rectangle of `around` x `along` points, closed in the first direction; `twisted`: with its second direction turned round where it closes.
Shape sheet(int around, int along, const std::function<mv::Vec3(double, double)>& place, bool twisted = false) {
  Shape s;
  for (int j = 0; j < along; ++j)
    for (int i = 0; i < around; ++i) s.points.push_back(place(static_cast<double>(i) / around, j / (along - 1.0)));
  for (int j = 0; j + 1 < along; ++j)
    for (int i = 0; i < around; ++i) {
      const int next = (i + 1) % around, turned = twisted && next == 0;
      const int below = turned ? along - 1 - j : j, above = turned ? along - 2 - j : j + 1;
      s.quads.push_back({j * around + i, below * around + next, above * around + next, (j + 1) * around + i});
    }
  return s;
}

/// Mid-surface of a valve: two leaflets of 14 mm, commissures at half that.
Shape funnel(double scale = 1) {
  return sheet(60, 20, [=](double u, double v) {
    return mv::Vec3(scale * (18 - 8 * v) * std::cos(2 * pi * u), scale * (15 - 7 * v) * std::sin(2 * pi * u), -scale * 14 * v * (0.75 - 0.25 * std::cos(4 * pi * u)));
  });
}

/// Thick leaflets, closed all round: the funnel 0.8 mm outwards and inwards, joined by rims.
Shape thick_funnel() {
  const int around = 72, along = 24, across = 3;
  const double half = 0.8;
  Shape s;
  std::vector<std::array<double, 2>> profile;  // share of the height, offset outwards
  for (int j = 0; j < along; ++j) profile.push_back({j / (along - 1.0), -half});
  for (int j = 1; j < across; ++j) profile.push_back({1.0, half * (2.0 * j / across - 1)});
  for (int j = along - 1; j >= 0; --j) profile.push_back({j / (along - 1.0), half});
  for (int j = across - 1; j > 0; --j) profile.push_back({0.0, half * (2.0 * j / across - 1)});
  const int n = static_cast<int>(profile.size());
  for (const auto& [v, offset] : profile)
    for (int i = 0; i < around; ++i) {
      const double u = static_cast<double>(i) / around;
      s.points.emplace_back((18 - 8 * v + offset) * std::cos(2 * pi * u), (15 - 7 * v + offset) * std::sin(2 * pi * u), -14 * v * (0.75 - 0.25 * std::cos(4 * pi * u)));
    }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < around; ++i) s.quads.push_back({j * around + i, ((j + 1) % n) * around + i, ((j + 1) % n) * around + (i + 1) % around, j * around + (i + 1) % around});
  return s;
}

struct Broken {
  const char* name;
  const char* file;  // its ending says the format
  std::function<std::string()> bytes;
  const char* kind;
  int code;
  const char* message;
};

Outcome surface(const TemporaryDirectory& dir, const std::string& file, const std::string& kind, const std::string& more = "") {
  std::ofstream(dir / "tips.csv") << "x_mm,y_mm,z_mm\n-10,-2,-32\n10,-2,-32\n";
  std::ofstream(dir / "c.toml") << "[source]\nkind = \"surface\"\n[surface]\nfile = \"" << file << "\"\nunit = \"mm\"\nkind = \"" << kind
                                << "\"\n[patient]\nanterior_point = [\"0 mm\", \"30 mm\", \"0 mm\"]\npapillary = \"tips.csv\"\n"
                                << "[mesh]\nspacing = \"1.5 mm\"\n[tube]\nspacing = \"4 mm\"\n" << more;
  return mvprep("surface -c '" + (dir / "c.toml").string() + "' -o '" + (dir / "case").string() + "'", dir);
}

class BrokenSurface : public testing::TestWithParam<Broken> {};

}  // namespace

TEST_P(BrokenSurface, ends_as_it_should) {
  const Broken& b = GetParam();
  const TemporaryDirectory dir;
  std::ofstream(dir / b.file, std::ios::binary) << b.bytes();
  const Outcome outcome = surface(dir, b.file, b.kind);
  EXPECT_EQ(outcome.code, b.code) << outcome.err;
  EXPECT_NE(outcome.err.find(b.message), std::string::npos) << "expected '" << b.message << "' in:\n" << outcome.err;
  EXPECT_EQ(outcome.err.find("case/inputs"), std::string::npos) << "names the copy, not the user's file:\n" << outcome.err;
  EXPECT_EQ(std::filesystem::exists(dir / "case/mid_surface.vtp"), b.code == 0);
}

namespace {

std::string damaged(const std::function<void(Shape&)>& damage) {
  Shape s = funnel();
  damage(s);
  return s.obj();
}

const Broken table[] = {
    {"sound", "s.obj", [] { return funnel().obj(); }, "mid", 0, ""},
    {"no_faces", "s.obj", [] { return damaged([](Shape& s) { s.quads.clear(); }); }, "mid", 4, "holds no triangle"},
    {"index_beyond_the_points", "s.obj", [] { return damaged([](Shape& s) { s.quads[7][1] = 99998; }); }, "mid", 4, "s.obj: line 1208: point 99999 of 1200 does not exist"},
    {"nan_point", "s.obj", [] { return damaged([](Shape& s) { s.points[40].y() = std::nan(""); }); }, "mid", 4, "line 41: found 'nan'"},
    {"infinite_point", "s.obj", [] { return damaged([](Shape& s) { s.points[40].y() = std::numeric_limits<double>::infinity(); }); }, "mid", 4, "line 41: found 'inf'"},
    {"empty_file", "s.obj", [] { return std::string(); }, "mid", 4, "is empty"},
    {"no_number", "s.obj", [] { return "v 1 2 three\n" + funnel().obj(); }, "mid", 4, "line 1: found 'three'"},
    {"noise_as_stl", "s.stl", [] { return std::string(3000, '\x7f'); }, "mid", 4, "truncated: its header tells"},
    {"stl_promises_too_much", "s.stl", [] { return std::string(80, '\0') + std::string("\x00\x00\x00\x80", 4) + std::string(50, '\0'); }, "mid", 4, "error surface: s.stl: truncated: its header tells 2147483648 triangles"},
    {"ply_promises_too_much", "s.ply", [] {
       return std::string("ply\nformat ascii 1.0\nelement vertex 1000000000\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
                          "property list uchar int vertex_indices\nend_header\n0 0 0\n");
     }, "mid", 4, "tells 1000000000 elements 'vertex'"},
    {"vtp_cut_off", "s.vtp", [] { return std::string("<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"3\""); }, "mid", 4, "incomplete"},
    {"unknown_ending", "s.step", [] { return funnel().obj(); }, "mid", 4, "has the ending '.step'"},
    {"closed_sphere", "s.obj", [] {
       return sheet(40, 20, [](double u, double v) { return mv::Vec3(15 * std::sin(pi * v) * std::cos(2 * pi * u), 15 * std::sin(pi * v) * std::sin(2 * pi * u), 15 * std::cos(pi * v)); }).obj();
     }, "auto", 4, "no thick sheet"},
    {"moebius_band", "s.obj", [] {
       return sheet(80, 9, [](double u, double v) {
                const double w = 8 * (v - 0.5);
                return mv::Vec3((18 + w * std::cos(pi * u)) * std::cos(2 * pi * u), (18 + w * std::cos(pi * u)) * std::sin(2 * pi * u), w * std::sin(pi * u));
              }, true).obj();
     }, "mid", 4, "no two sides"},
    {"klein_bottle", "s.obj", [] {
       return sheet(60, 31, [](double u, double v) {
                const double a = 4 * std::cos(2 * pi * v), b = 2 * std::sin(4 * pi * v), r = 18 + a * std::cos(pi * u) - b * std::sin(pi * u);
                return mv::Vec3(r * std::cos(2 * pi * u), r * std::sin(2 * pi * u), a * std::sin(pi * u) + b * std::cos(pi * u));
              }, true).obj();
     }, "auto", 4, "no two sides"},
    {"two_valves", "s.obj", [] {
       return damaged([](Shape& s) {
         const int n = static_cast<int>(s.points.size());
         const Shape one = s;
         for (const mv::Vec3& p : one.points) s.points.push_back(p + mv::Vec3(80, 0, 0));
         for (auto q : one.quads) s.quads.push_back({q[0] + n, q[1] + n, q[2] + n, q[3] + n});
       });
     }, "mid", 4, "2 rings, each with an annulus"},
    {"micrometres", "s.obj", [] { return funnel(1000).obj(); }, "mid", 4, "set surface.unit = \"um\""},
    {"metres", "s.obj", [] { return funnel(0.001).obj(); }, "mid", 4, "set surface.unit = \"m\""},
    {"flat_ring", "s.obj", [] { return damaged([](Shape& s) { for (auto& p : s.points) p.z() = 0; }); }, "mid", 4, "nothing tells"},
    {"one_triangle", "s.obj", [] { return std::string("v 0 0 0\nv 10 0 0\nv 0 10 0\nf 1 2 3\n"); }, "auto", 4, "one sheet with one border"},
    {"all_points_in_one_place", "s.obj", [] { return damaged([](Shape& s) { for (auto& p : s.points) p.setZero(); }); }, "mid", 4, "no unit fits"},
    {"flipped_and_doubled_facets", "s.obj", [] {
       return damaged([](Shape& s) {
         for (std::size_t i = 0; i < s.quads.size(); i += 3) std::reverse(s.quads[i].begin(), s.quads[i].end());
         s.quads.insert(s.quads.end(), s.quads.begin(), s.quads.begin() + 50);
       });
     }, "mid", 0, "100 duplicated triangles removed"},
    {"leaflet_torn_off_the_annulus", "s.obj", [] {  // a third of the circumference, along the second row of facets
       return damaged([](Shape& s) { std::erase_if(s.quads, [](const auto& q) { return q[0] >= 60 && q[0] < 120 && q[0] % 60 < 20; }); });
     }, "mid", 4, "too much is missing"},
    {"a_third_of_the_annulus_cut_away", "s.obj", [] { return damaged([](Shape& s) { std::erase_if(s.quads, [](const auto& q) { return q[0] < 240 && q[0] % 60 < 20; }); }); }, "mid", 0, "has a step or corner near"},
    {"half_a_valve", "s.obj", [] { return damaged([](Shape& s) { std::erase_if(s.quads, [](const auto& q) { return q[0] % 60 < 30; }); }); }, "mid", 4, "one sheet with one border"},
    {"a_hole_in_a_leaflet", "s.obj", [] { return damaged([](Shape& s) { std::erase_if(s.quads, [](const auto& q) { return q[0] == 8 * 60 + 15; }); }); }, "mid", 0, "a hole of 1.2 mm2"},
    {"a_spike", "s.obj", [] { return damaged([](Shape& s) { s.points[8 * 60 + 15] += mv::Vec3(0, 200, 0); }); }, "mid", 5, "too flat to unfold"},
};

INSTANTIATE_TEST_SUITE_P(Table, BrokenSurface, testing::ValuesIn(table), [](const auto& one) { return std::string(one.param.name); });

}  // namespace

TEST(ThickPath, a_closed_surface_becomes_a_case_with_its_own_faces) {
  const TemporaryDirectory dir;
  if (std::system("command -v tetgen >/dev/null && command -v gmsh >/dev/null") != 0) GTEST_SKIP() << "SKIPPED: tetgen or gmsh is not installed; ./dev test installs them";
  std::ofstream(dir / "s.obj") << thick_funnel().obj();
  std::ofstream(dir / "tips.csv") << "x_mm,y_mm,z_mm\n-10,-2,-32\n10,-2,-32\n";
  std::ofstream(dir / "c.toml") << "[source]\nkind = \"surface\"\n[surface]\nfile = \"s.obj\"\nunit = \"mm\"\nkind = \"thick\"\n[patient]\nanterior_point = [\"0 mm\", \"30 mm\", \"0 mm\"]\npapillary = \"tips.csv\"\n"
                                << "[mesh]\npath = \"thick\"\nspacing = \"1.2 mm\"\n[tube]\nspacing = \"4 mm\"\n";
  const std::string command = "run -c '" + (dir / "c.toml").string() + "' -o '" + (dir / "case").string() + "'";
  const Outcome outcome = mvprep(command, dir);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("TetGen"), std::string::npos) << "both results are told\n" << outcome.err;
  EXPECT_NE(outcome.err.find("gmsh"), std::string::npos) << outcome.err;
  const std::string quality = mv::read_file(dir / "case/quality.json");
  EXPECT_EQ(quality.find("leaflets.layers"), std::string::npos) << "there are no layers to count";
  EXPECT_NE(quality.find("leaflets.spacing_max"), std::string::npos);

  // Neither program to be found, and a source without thick leaflets.
  const std::string without = "env PATH=/nonexistent " + std::string(MV_BIN_DIR) + "/mvprep mesh '" + (dir / "case").string() + "' 2> '" + (dir / "stderr").string() + "' > /dev/null";
  const int status = std::system(without.c_str());
  EXPECT_EQ(WEXITSTATUS(status), 7);
  EXPECT_NE(mv::read_file(dir / "stderr").find("in the package gmsh"), std::string::npos);
  std::ofstream(dir / "g.toml") << "[mesh]\npath = \"thick\"\nspacing = \"1.5 mm\"\n[tube]\nspacing = \"4 mm\"\n";
  const Outcome generic = mvprep("run -c '" + (dir / "g.toml").string() + "' -o '" + (dir / "g").string() + "'", dir);
  EXPECT_EQ(generic.code, 3);
  EXPECT_NE(generic.err.find("has no thick leaflets"), std::string::npos) << generic.err;
}
