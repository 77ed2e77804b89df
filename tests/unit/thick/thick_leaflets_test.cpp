// SPDX-License-Identifier: GPL-3.0-or-later
// The thick path on the generic valve: faces known in closed form, each mesher by itself, what the later stages read.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <map>
#include <set>

#include "geometry/chordae/leaflet_chart.h"
#include "geometry/core/errors.h"
#include "geometry/core/program.h"
#include "geometry/core/side_faces.h"
#include "geometry/generic/generic_valve.h"
#include "geometry/surface/self_intersection.h"
#include "geometry/thick/relocate.h"
#include "geometry/thick/thick_leaflets.h"
#include "geometry/volume/gates.h"
#include "unit/core/sample_case.h"

namespace {

using mv::Vec3;

std::size_t at(long i) { return static_cast<std::size_t>(i); }

const mv::MidSurface& valve() {
  static const mv::MidSurface surface = mv::build_generic_valve({}, 1.5).mid_surface;
  return surface;
}

/// Closed surface of the valve with `thickness`, as a measurement would give it.
mv::SolidSurface measured(double thickness) {
  const mv::LeafletBoundary b = mv::boundary_of(mv::thicken(valve(), {thickness, 1, 1}));
  return {b.points, b.triangles, {}};
}

double volume(const mv::LeafletMesh& m) {
  double sum = 0;
  for (const auto& t : m.tets) {
    const Vec3 a = m.points[at(t[0])];
    sum += (m.points[at(t[1])] - a).cross(m.points[at(t[2])] - a).dot(m.points[at(t[3])] - a) / 6;
  }
  return sum;
}

bool is_installed(mv::TetMesher mesher) {
  return !mv::find_program(mesher == mv::TetMesher::tetgen ? "tetgen" : "gmsh").empty();
}

class Mesher : public testing::TestWithParam<mv::TetMesher> {};

}  // namespace

TEST(ThickFaces, points_move_to_the_measured_faces_and_the_annulus_stays) {
  mv::LeafletBoundary b = mv::boundary_of(mv::thicken(valve(), {1.6, 2, 1}));
  const mv::LeafletBoundary before = b;
  const mv::FaceFit fit = mv::move_to_faces(b, measured(2.0), 1.0);
  std::printf("distance %.3f mm on average, %.3f at most; after %.3f and %.3f; %ld held back\n", fit.before_mean, fit.before_max, fit.after_mean, fit.after_max, fit.held_back);
  EXPECT_NEAR(fit.before_mean, 0.2, 0.02);  // half the difference of the thicknesses
  EXPECT_LT(fit.after_mean, 0.02);
  EXPECT_LT(fit.after_max, 0.2);
  for (std::size_t i = 0; i < b.points.size(); ++i)
    if (b.on_annulus[i]) {
      EXPECT_EQ(b.points[i], before.points[i]);
    }
  EXPECT_TRUE(mv::self_intersections(b.points, b.triangles).empty());
}

TEST(ThickFaces, a_face_out_of_reach_or_looking_the_other_way_draws_nothing) {
  mv::LeafletBoundary b = mv::boundary_of(mv::thicken(valve(), {1.0, 2, 1}));
  const mv::LeafletBoundary before = b;
  mv::SolidSurface inside_out = measured(1.3);
  for (auto& t : inside_out.triangles) std::swap(t[0], t[1]);
  mv::move_to_faces(b, inside_out, 1.0);
  double moved = 0;
  for (std::size_t i = 0; i < b.points.size(); ++i) moved = std::max(moved, (b.points[i] - before.points[i]).norm());
  EXPECT_LT(moved, 1e-9);
  mv::move_to_faces(b, measured(3.0), 0.5);  // faces 1 mm away
  for (std::size_t i = 0; i < b.points.size(); ++i)
    if (b.side[i] != mv::between && !b.on_free_edge[i]) {
      EXPECT_LT((b.points[i] - before.points[i]).norm(), 0.5);
    }
}

TEST_P(Mesher, fills_the_measured_leaflets_and_every_field_is_right) {
  if (!is_installed(GetParam())) GTEST_SKIP() << "SKIPPED: " << mv::to_string(GetParam()) << " is not installed; ./dev test installs it";
  mv::ThickOptions options;
  options.spacing = 1.5;
  options.thickness = 1.6;
  options.dihedral_limit = 5;
  options.meshers = {GetParam()};
  mv::ThickReport report;
  const mv::LeafletMesh m = mv::fill_leaflets(valve(), measured(2.0), options, &report);
  ASSERT_EQ(report.trials.size(), 1u);
  std::printf("%s: %zu points, %zu tetrahedra, angles %.1f to %.1f, %ld below the limit, %ld with long steps\n", std::string(mv::to_string(GetParam())).c_str(), m.points.size(), m.tets.size(),
              report.trials[0].dihedral_min, report.trials[0].dihedral_max, report.trials[0].below_limit, report.trials[0].too_long);
  EXPECT_EQ(report.trials[0].below_limit, 0);
  EXPECT_TRUE(mv::gate_boundary(m).passed) << mv::gate_boundary(m).message;
  EXPECT_TRUE(mv::gate_volumes(m).passed) << mv::gate_volumes(m).message;
  EXPECT_TRUE(mv::gate_fibres(m).passed) << mv::gate_fibres(m).message;
  EXPECT_NEAR(volume(m), volume(mv::thicken(valve(), {2.0, 1, 1})), 0.03 * volume(m)) << "the measured volume; the rim at the annulus stays at 1.6 mm";

  // Both faces are one sheet each, and the chordae's chart finds border and leaflets.
  const mv::LeafletChart chart(m), layers(mv::thicken(valve(), {2.0, 2, 1}));
  EXPECT_NEAR(chart.border_length(), layers.border_length(), 0.03 * layers.border_length());
  EXPECT_EQ(mv::side_triangles(m, mv::atrial).size(), mv::side_triangles(mv::thicken(valve(), {2.0, 2, 1}), mv::atrial).size()) << "the surface is kept, triangle by triangle";
  std::set<int> regions(m.region.begin(), m.region.end());
  EXPECT_EQ(regions, (std::set<int>{mv::anterior, mv::posterior}));
  for (std::size_t e = 0; e < m.tets.size(); ++e) {
    EXPECT_NEAR(m.sheet_normal[e].norm(), 1, 1e-9);
    EXPECT_GE(m.layer[e], 0);
    EXPECT_LT(m.layer[e], options.layers);
  }
  // The same input gives the same mesh.
  const mv::LeafletMesh again = mv::fill_leaflets(valve(), measured(2.0), options);
  EXPECT_EQ(again.tets, m.tets);
}

INSTANTIATE_TEST_SUITE_P(Both, Mesher, testing::Values(mv::TetMesher::tetgen, mv::TetMesher::gmsh), [](const auto& one) { return std::string(mv::to_string(one.param)); });

TEST(ThickLeaflets, the_better_of_two_meshes_is_kept) {
  if (!is_installed(mv::TetMesher::tetgen) || !is_installed(mv::TetMesher::gmsh)) GTEST_SKIP() << "SKIPPED: tetgen or gmsh is not installed; ./dev test installs them";
  mv::ThickOptions options;
  options.spacing = 1.5;
  options.thickness = 1.6;
  options.dihedral_limit = 5;
  const mv_test::TemporaryDirectory dir;
  options.directory = dir / "work";
  EXPECT_THROW(mv::fill_leaflets(valve(), measured(2.0), options), mv::IoError) << "the meshers' files belong there";
  std::filesystem::create_directory(options.directory);
  mv::ThickReport report;
  const mv::LeafletMesh m = mv::fill_leaflets(valve(), measured(2.0), options, &report);
  EXPECT_TRUE(std::filesystem::is_empty(options.directory));
  ASSERT_EQ(report.trials.size(), 2u);
  const mv::TetTrial &kept = report.trials[report.kept == report.trials[0].mesher ? 0 : 1], &other = report.trials[report.kept == report.trials[0].mesher ? 1 : 0];
  EXPECT_LE(kept.below_limit, other.below_limit);
  EXPECT_EQ(kept.tets, m.tets.size());
}

TEST(ThickLeaflets, an_open_surface_ends_with_the_reason_of_each_mesher) {
  if (!is_installed(mv::TetMesher::tetgen) || !is_installed(mv::TetMesher::gmsh)) GTEST_SKIP() << "SKIPPED: tetgen or gmsh is not installed; ./dev test installs them";
  mv::SolidSurface open = measured(2.0);
  open.triangles.resize(open.triangles.size() / 2);
  for (const mv::TetMesher mesher : {mv::TetMesher::tetgen, mv::TetMesher::gmsh}) {
    try {
      mv::fill_surface(mesher, open.points, open.triangles, 1.0, 60);
      ADD_FAILURE() << mv::to_string(mesher) << " filled an open surface";
    } catch (const mv::Error& e) {
      EXPECT_EQ(e.code(), mv::ExitCode::input) << e.what();
    }
  }
}

TEST(Relocate, a_sliver_beside_an_inner_point_is_opened) {
  // Eight tetrahedra around a point of an octahedron that lies nearly on one of its faces.
  mv::TetFill fill;
  fill.points = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}, {0.31, 0.31, 0.31}};
  for (const int x : {0, 1})
    for (const int y : {2, 3})
      for (const int z : {4, 5}) {
        std::array<int, 4> t{x, y, z, 6};
        if ((x == 0) == ((y == 2) == (z == 4))) std::swap(t[0], t[1]);
        const Vec3 a = fill.points[at(t[0])];
        if ((fill.points[at(t[1])] - a).cross(fill.points[at(t[2])] - a).dot(fill.points[6] - a) < 0) std::swap(t[0], t[1]);
        fill.tets.push_back(t);
      }
  const auto smallest = [&] {
    double least = 180;
    for (const auto& t : fill.tets)
      for (const double angle : mv::dihedral_angles(fill.points[at(t[0])], fill.points[at(t[1])], fill.points[at(t[2])], fill.points[at(t[3])])) least = std::min(least, angle);
    return least;
  };
  EXPECT_LT(smallest(), 10);
  const std::vector<Vec3> before(fill.points.begin(), fill.points.begin() + 6);
  EXPECT_EQ(mv::relocate_points(fill, std::vector<char>(6, 0), 40), 0);
  EXPECT_GT(smallest(), 40);
  EXPECT_EQ(std::vector<Vec3>(fill.points.begin(), fill.points.begin() + 6), before) << "points of the surface moved though an inner one could";
}

TEST(Relocate, a_point_of_the_surface_moves_only_without_an_inner_one_and_hardly) {
  mv::TetFill fill;
  fill.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.3, 0.08}};  // flat: a large move of any point would help
  fill.tets = {{0, 1, 2, 3}};
  const std::vector<Vec3> before = fill.points;
  const double longest = std::sqrt(2.0);
  mv::relocate_points(fill, {1, 0, 0, 0}, 40);
  EXPECT_EQ(fill.points[0], before[0]) << "held";
  double moved = 0;
  for (std::size_t i = 1; i < 4; ++i) moved = std::max(moved, (fill.points[i] - before[i]).norm());
  EXPECT_GT(moved, 0);
  EXPECT_LT(moved, 0.1 * longest * 1.1) << "the edges may grow a little on the way";
}

TEST(Relocate, long_steps_are_split_inside_and_the_surface_is_kept) {
  mv::TetFill fill;  // two tetrahedra on either side of a triangle, tops 4 mm away
  fill.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.3, 4}, {0.3, 0.3, -4}};
  fill.tets = {{0, 1, 2, 3}, {0, 2, 1, 4}};
  const std::vector<std::array<int, 3>> surface{{0, 1, 3}, {1, 2, 3}, {2, 0, 3}, {1, 0, 4}, {2, 1, 4}, {0, 2, 4}};
  EXPECT_EQ(mv::split_long_steps(fill, 5, surface, 1.5), 0) << "every edge is on the surface";
  // A point in the middle of the lower triangle gives the upper tetrahedron inner edges.
  fill.points = {{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {0, 0, 3}, {0.5, 0.5, 0.5}};
  fill.tets = {{0, 1, 2, 4}, {0, 3, 1, 4}, {0, 2, 3, 4}, {1, 3, 2, 4}};
  const std::vector<std::array<int, 3>> faces{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  for (auto& t : fill.tets) {
    const Vec3 a = fill.points[at(t[0])];
    if ((fill.points[at(t[1])] - a).cross(fill.points[at(t[2])] - a).dot(fill.points[at(t[3])] - a) < 0) std::swap(t[0], t[1]);
  }
  const std::size_t points = fill.points.size();
  const long added = mv::split_long_steps(fill, 4, faces, 2.0);
  EXPECT_GT(added, 0);
  EXPECT_EQ(fill.points.size(), points + static_cast<std::size_t>(added));
  std::map<std::array<int, 3>, int> uses;  // a conforming mesh: every face once or twice, and once only on the surface
  for (const auto& t : fill.tets)
    for (std::array<int, 3> f : {std::array{t[0], t[1], t[2]}, std::array{t[0], t[1], t[3]}, std::array{t[0], t[2], t[3]}, std::array{t[1], t[2], t[3]}}) {
      std::sort(f.begin(), f.end());
      ++uses[f];
    }
  long outer = 0;
  for (const auto& [face, count] : uses) {
    EXPECT_LE(count, 2);
    outer += count == 1;
  }
  EXPECT_EQ(outer, 4);
  double sum = 0;
  for (const auto& t : fill.tets) {
    const Vec3 a = fill.points[at(t[0])];
    const double v = (fill.points[at(t[1])] - a).cross(fill.points[at(t[2])] - a).dot(fill.points[at(t[3])] - a) / 6;
    EXPECT_GT(v, 0);
    sum += v;
  }
  EXPECT_NEAR(sum, 4.5, 1e-12);
}

TEST(Spacing, of_an_element_is_the_longest_step_between_its_corners) {
  EXPECT_DOUBLE_EQ(mv::spanning_step({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}), 1.0);
  EXPECT_DOUBLE_EQ(mv::spanning_step({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0.5, 0), Vec3(5, 0.5, 0)}), 3.0);
}

TEST(Program, none_starts_after_the_running_ones_were_ended) {
  const mv_test::TemporaryDirectory dir;
  const auto sh = mv::find_program("sh");
  const auto interrupted = [&] {
    mv::end_running_programs();
    try {
      mv::run_program(sh, {"-c", "exit 0"}, dir / "log");
    } catch (const mv::Error& e) {
      std::_Exit(static_cast<int>(e.code()));
    }
    std::_Exit(0);
  };
  EXPECT_EXIT(interrupted(), testing::ExitedWithCode(static_cast<int>(mv::ExitCode::interrupted)), "");
}

TEST(Program, runs_reports_its_code_and_is_killed_when_it_takes_too_long) {
  const mv_test::TemporaryDirectory dir;
  const auto sh = mv::find_program("sh");
  ASSERT_FALSE(sh.empty());
  EXPECT_TRUE(mv::find_program("no-such-program-here").empty());
  EXPECT_EQ(mv::run_program(sh, {"-c", "echo said; exit 3"}, dir / "log"), 3);
  std::string line;
  std::getline(std::ifstream(dir / "log"), line);
  EXPECT_EQ(line, "said");
  EXPECT_EQ(mv::run_program(sh, {"-c", "kill -9 $$"}, dir / "log"), 137);
  EXPECT_EQ(mv::run_program(sh, {"-c", "exec sleep 30"}, dir / "log", 0.2), mv::timed_out);
  EXPECT_THROW(mv::run_program(dir / "none", {}, dir / "log"), mv::IoError);
}
