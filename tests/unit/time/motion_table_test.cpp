// SPDX-License-Identifier: BSD-3-Clause
#include "geometry/core/motion_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "geometry/core/errors.h"
#include "solver/time/boundary_motion.h"

namespace {

using namespace mv;

std::filesystem::path written(const std::string& text) {
  const auto file = std::filesystem::temp_directory_path() / (std::string("mv_motion_") + testing::UnitTest::GetInstance()->current_test_info()->name() + ".csv");
  std::ofstream(file) << text;
  return file;
}

std::string error_of(const std::string& text) {
  try {
    MotionTable::read(written(text));
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

MotionTable smooth_step(int rows, double duration) {
  std::vector<double> times;
  std::vector<Vec3> u;
  for (int i = 0; i < rows; ++i) {
    const double s = static_cast<double>(i) / (rows - 1);
    times.push_back(duration * s);
    u.push_back(Vec3(2, -1, 0) * (s * s * s * (10 - 15 * s + 6 * s * s)));
  }
  return MotionTable(times, {Vec3(1, 2, 3)}, {u});
}

TEST(motion_table, passes_through_its_rows_and_rests_outside) {
  const MotionTable t = MotionTable::read(written("x_mm,y_mm,z_mm,time_s,point\n1,2,3,0,0\n2,2,3,0.1,0\n2,1,3,0.3,0\n"));
  EXPECT_EQ(t.points(), 1);
  EXPECT_EQ(t.rest()[0], Vec3(1, 2, 3));
  EXPECT_EQ(t.displacement(0, -1), Vec3(0, 0, 0));
  EXPECT_LT((t.displacement(0, 0.1) - Vec3(1, 0, 0)).norm(), 1e-15);
  EXPECT_EQ(t.displacement(0, 0.5), Vec3(1, -1, 0));
  EXPECT_TRUE(t.changes(0, 0.01));
  EXPECT_FALSE(t.changes(0.3, 0.4));
}

TEST(motion_table, two_rows_make_a_cubic_step) {
  const MotionTable t({0, 1}, {Vec3::Zero()}, {{Vec3::Zero(), Vec3(1, 0, 0)}});
  for (const double s : {0.1, 0.5, 0.9}) EXPECT_NEAR(t.displacement(0, s).x(), s * s * (3 - 2 * s), 1e-15);
}

TEST(motion_table, velocity_is_continuous_and_nothing_overshoots) {
  const MotionTable t({0, 1, 2, 3}, {Vec3::Zero()}, {{Vec3::Zero(), Vec3(1, 0, 0), Vec3(1, 5, 0), Vec3(0, 5, 0)}});
  constexpr double h = 1e-6;
  for (double at = 0; at < 3; at += 0.01) {
    const Vec3 u = t.displacement(0, at);
    EXPECT_TRUE(u.x() > -1e-12 && u.x() < 1 + 1e-12 && u.y() > -1e-12 && u.y() < 5 + 1e-12) << at;
  }
  for (const double at : {1.0, 2.0}) {
    const Vec3 before = (t.displacement(0, at) - t.displacement(0, at - h)) / h, after = (t.displacement(0, at + h) - t.displacement(0, at)) / h;
    EXPECT_LT((after - before).norm(), 1e-4) << at;
  }
}

TEST(motion_table, forty_rows_follow_a_smooth_step) {
  const MotionTable t = smooth_step(41, 0.1);
  double worst = 0;
  for (double s = 0; s <= 1; s += 0.001) worst = std::max(worst, (t.displacement(0, 0.1 * s) - Vec3(2, -1, 0) * (s * s * s * (10 - 15 * s + 6 * s * s))).norm());
  std::printf("largest difference from the smooth step: %.2e of the movement\n", worst / std::sqrt(5.0));
  EXPECT_LT(worst / std::sqrt(5.0), 2e-4);
}

TEST(motion_table, what_is_written_is_read) {
  const auto file = written("");
  write_motion(file, {0, 0.5, 1}, {Vec3(1, 2, 3), Vec3(4, 5, 6)}, {{Vec3::Zero(), Vec3(1, 0, 0), Vec3(2, 0, 0)}, {Vec3::Zero(), Vec3(0, 1, 0), Vec3(0, 0, 1)}});
  const MotionTable t = MotionTable::read(file);
  EXPECT_EQ(t.points(), 2);
  EXPECT_LT((t.displacement(1, 1) - Vec3(0, 0, 1)).norm(), 1e-9);
  EXPECT_NEAR(t.largest(), 2, 1e-9);
}

TEST(motion_table, faults_name_line_and_column) {
  const std::string head = "point,time_s,x_mm,y_mm,z_mm\n";
  const struct {
    std::string text, message;
  } faults[] = {
      {"point,time,x_mm,y_mm,z_mm\n", "column 'time_s' is missing"},
      {head, "no rows"},
      {head + "0,0,1,2\n", "line 2: z_mm: '' is not a finite number"},
      {head + "0,0,1,2,nan\n", "line 2: z_mm: 'nan' is not a finite number"},
      {head + "0.5,0,1,2,3\n", "point 0.5 is no number"},
      {head + "0,0,1,2,3\n", "point 0 has one row"},
      {head + "0,0,1,2,3\n0,0,1,2,4\n", "line 3: time 0 s of point 0 does not grow"},
      {head + "0,0.1,1,2,3\n0,0.2,1,2,4\n", "starts at 0.1 s"},
      {head + "1,0,1,2,3\n1,1,1,2,4\n", "point 0 is missing"},
      {head + "0,0,1,2,3\n0,1,1,2,4\n1,0,1,2,3\n", "point 1 has 1 rows"},
      {head + "0,0,1,2,3\n0,1,1,2,4\n1,0,1,2,3\n1,2,1,2,3\n", "line 5: time 2 s differs"},
  };
  for (const auto& fault : faults) EXPECT_NE(error_of(fault.text).find(fault.message), std::string::npos) << fault.message << "\n" << error_of(fault.text);
  EXPECT_THROW(MotionTable::read("no/such.csv"), IoError);
}

TEST(motion_table, files_of_other_valves_and_units_are_named) {
  const MotionTable t({0, 0.1}, {Vec3(10, 0, -30), Vec3(-10, 0, -30)}, {{Vec3::Zero(), Vec3(0, 0, 5)}, {Vec3::Zero(), Vec3(0, 0, 5)}});
  const auto fault = [](const auto& check) -> std::string {
    try {
      check();
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_EQ(fault([&] { t.check_tips({Vec3(10, 3, -30), Vec3(-10, 0, -28)}, "p.csv"); }), "");
  EXPECT_NE(fault([&] { t.check_tips({Vec3(10, 0, -30)}, "p.csv"); }).find("p.csv: holds 2 points, the case has 1"), std::string::npos);
  EXPECT_NE(fault([&] { t.check_tips({Vec3(-10, 0, -30), Vec3(10, 0, -30)}, "p.csv"); }).find("20.0 mm from papillary tip 0"), std::string::npos);
  EXPECT_EQ(fault([&] { t.check_course("p.csv"); }), "");
  const MotionTable sudden({0, 1e-4}, t.rest(), {{Vec3::Zero(), Vec3(0, 0, 5)}, {Vec3::Zero(), Vec3(0, 0, 5)}});
  EXPECT_NE(fault([&] { sudden.check_course("p.csv"); }).find("moves at 50 m/s"), std::string::npos);
  const MotionTable early({-0.1, 0.1}, t.rest(), {{Vec3::Zero(), Vec3(0, 0, 5)}, {Vec3::Zero(), Vec3(0, 0, 5)}});
  EXPECT_NE(fault([&] { early.check_course("p.csv"); }).find("at 0 s point 0 has moved by 2.50 mm"), std::string::npos);
}

TEST(annulus_motion, nodes_follow_the_nearest_place_of_the_curve) {
  // A square annulus; its first corner moves by 4 mm, the others stay: half way along its edges the curve moves by 2 mm.
  const std::vector<Vec3> rest{{10, 10, 0}, {-10, 10, 0}, {-10, -10, 0}, {10, -10, 0}};
  std::vector<std::vector<Vec3>> u(4, {Vec3::Zero(), Vec3::Zero()});
  u[0][1] = Vec3(0, 0, 4);
  LeafletMesh mesh;
  mesh.points = {{10, 10, 0.3}, {0, 10, -0.3}, {-10, 0, 0}, {10, 5, 0}, {0, 0, 0}};
  mesh.on_annulus = {1, 1, 1, 1, 0};
  Tube tube;
  tube.axes << 0, 0, 1, 1, 0, 0, 0, 1, 0;  // e1 = z
  const AnnulusMotion motion(MotionTable({0, 1}, rest, u), mesh, tube, "file");
  ASSERT_EQ(motion.nodes(), (std::vector<int>{0, 1, 2, 3}));
  const double expected[] = {4e-3, 2e-3, 0, 3e-3};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_LT((motion.displacement(i, 1) - Vec3(expected[i], 0, 0)).norm(), 1e-12) << i;
  EXPECT_LT((motion.displacement(0, 0.5) - Vec3(2e-3, 0, 0)).norm(), 1e-12);
  mesh.points[0] = Vec3(10, 10, 5);
  EXPECT_THROW(AnnulusMotion(MotionTable({0, 1}, rest, u), mesh, tube, "file"), InputError);
}

TEST(tips, follow_their_file_besides_the_displacement) {
  Chordae chordae;
  chordae.points = {Vec3::Zero(), Vec3(0, 0, 10)};
  chordae.muscle_of_point = {0, -1};
  ChordaSegment segment;
  segment.a = 0, segment.b = 1, segment.rest_length = 10, segment.area = 1;
  chordae.segments = {segment};
  chordae.insertions = {{1, 0, 1.0}};
  ChordaeTension tension(chordae, 1, 1e6);
  Config config;
  config.set("papillary.motion=" + written("point,time_s,x_mm,y_mm,z_mm\n0,0,0,0,0\n0,0.1,0,3,0\n").string());
  config.set("papillary.displacement=[1 mm, 0 mm, 0 mm]");
  config.set("papillary.move_time=20 ms");
  const BoundaryMotion motion(config, chordae, Tube(), {Vec3::Zero()});
  EXPECT_TRUE(motion.is_active());
  std::vector<Vec3> tips{Vec3::Zero()};
  motion.apply(0.2, tension, tips);
  EXPECT_LT((tips[0] - Vec3(1e-3, 3e-3, 0)).norm(), 1e-12);
  motion.apply(0.05, tension, tips);
  EXPECT_LT((tips[0] - Vec3(1e-3, 1.5e-3, 0)).norm(), 1e-12);
  EXPECT_TRUE(motion.changes(0.05, 0.06));
  EXPECT_FALSE(motion.changes(0.11, 0.2));
  EXPECT_THROW(BoundaryMotion(config, chordae, Tube(), {Vec3::Zero(), Vec3::Zero()}), InputError);
}

}  // namespace
