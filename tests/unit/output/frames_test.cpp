// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <fstream>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "solver/output/carried_annulus.h"
#include "solver/output/frame_reader.h"
#include "solver/output/frame_writer.h"
#include "support/synthetic_results.h"

namespace fs = std::filesystem;
using namespace mv;

namespace {

class Frames : public testing::Test {
 protected:
  void SetUp() override {
    results_ =
        fs::temp_directory_path() / ("mv_frames_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(results_);
    frame_.origin = Vec3(10, 20, 30);
    frame_.axes = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  }
  void TearDown() override { fs::remove_all(results_); }

  FrameWriter make_writer(double resume_time = -1) const {
    return FrameWriter(results_, valve_.mesh, valve_.chordae, valve_.annulus, frame_, resume_time);
  }
  /// Rest positions in the solver's frame, m.
  std::vector<double> solver_positions() const {
    std::vector<double> out;
    for (const Vec3& x : valve_.mesh.points) {
      const Vec3 s = 1e-3 * (frame_.axes * (x - frame_.origin));
      out.insert(out.end(), s.data(), s.data() + 3);
    }
    return out;
  }
  void write_at(FrameWriter& writer, double time) const {
    const auto x = solver_positions();
    LeafletsState state;
    state.time = time;
    state.positions = x;
    writer.write_leaflets(state);
  }

  fs::path results_;
  SolverFrame frame_;
  test::SyntheticValve valve_ = test::make_synthetic_valve({.columns = 24, .rows = 4});
};

TEST_F(Frames, leaflets_come_back_in_millimetres_of_the_world) {
  FrameWriter writer = make_writer();
  auto x = solver_positions();
  const Vec3 push(1e-3, 0, 0);  // solver frame
  for (std::size_t i = 0; i < x.size(); i += 3) x[i] += push.x();
  const std::size_t np = valve_.mesh.points.size(), nt = valve_.mesh.tets.size();
  std::vector<double> force(3 * np, 0.0), pressure(np, 2500.0), stress(nt, 4e5);
  force[0] = 2;
  LeafletsState state;
  state.time = 0.0125;
  state.positions = x;
  state.contact_forces = force;
  state.contact_pressures = pressure;
  state.von_mises = stress;
  const LeafletsFrame frame = read_leaflets_frame(writer.write_leaflets(state));
  EXPECT_DOUBLE_EQ(frame.time, 0.0125);
  ASSERT_EQ(frame.mesh.points.size(), np);
  const Vec3 moved = frame_.axes.transpose() * Vec3(1, 0, 0);
  for (std::size_t i = 0; i < np; ++i) {
    EXPECT_LT((frame.mesh.points[i] - valve_.mesh.points[i] - moved).norm(), 1e-9);
    EXPECT_LT((frame.displacement[i] - moved).norm(), 1e-5);
  }
  EXPECT_LT((frame.contact_force[0] - 2 * frame_.axes.transpose() * Vec3::UnitX()).norm(), 1e-6);
  EXPECT_NEAR(frame.contact_pressure[5], 2.5, 1e-6);
  EXPECT_NEAR(frame.von_mises[7], 400, 1e-3);
  EXPECT_EQ(frame.mesh.tets, valve_.mesh.tets);
  EXPECT_EQ(frame.mesh.region, valve_.mesh.region);
  EXPECT_EQ(frame.mesh.side, valve_.mesh.side);
  EXPECT_EQ(frame.mesh.on_annulus, valve_.mesh.on_annulus);
  // The held nodes were pushed along: the annulus is where they are.
  EXPECT_LT((frame.annulus_normal - valve_.annulus.normal).norm(), 1e-9);
  EXPECT_LT((frame.annulus_origin - valve_.annulus.origin - moved).norm(), 1e-9);
}

TEST_F(Frames, annulus_at_rest_stays_to_the_last_digit_and_turns_with_its_nodes) {
  FrameWriter writer = make_writer();
  write_at(writer, 0);
  const Annulus rest = carried_annulus(valve_.annulus, valve_.mesh, valve_.mesh.points);
  EXPECT_EQ(rest.origin, valve_.annulus.origin);
  EXPECT_EQ(rest.normal, valve_.annulus.normal);
  EXPECT_EQ(rest.points, valve_.annulus.points);
  const Eigen::AngleAxisd turn(0.2, valve_.annulus.axis_major);
  std::vector<Vec3> turned = valve_.mesh.points;
  for (Vec3& p : turned) p = valve_.annulus.origin + turn * (p - valve_.annulus.origin);
  const Annulus now = carried_annulus(valve_.annulus, valve_.mesh, turned);
  EXPECT_LT((now.normal - turn * valve_.annulus.normal).norm(), 0.02);
  EXPECT_GT((now.normal - valve_.annulus.normal).norm(), 0.15);
  EXPECT_LT((now.origin - valve_.annulus.origin).norm(), 0.1);
}

TEST_F(Frames, quadratic_elements_keep_their_ten_nodes) {
  valve_ = test::make_synthetic_valve({.order = 2, .columns = 12, .rows = 2});
  FrameWriter writer = make_writer();
  write_at(writer, 0);
  const LeafletsFrame frame = read_leaflets_frame(results_ / "frames/leaflets_0000.vtu");
  EXPECT_EQ(frame.mesh.order, 2);
  EXPECT_EQ(frame.mesh.tets, valve_.mesh.tets);
}

TEST_F(Frames, fluid_grid_keeps_its_place_when_the_tube_is_turned) {
  FrameWriter writer = make_writer();
  FluidState state;
  state.time = 0.03;
  state.grid = {Vec3(0.001, 0.002, 0.003), {4, 3, 2}, 0.0005};
  state.velocity = [](int i, int j, int k) { return Vec3(i, j, k); };
  state.pressure = [](int i, int, int) { return 133.322387415 * i; };
  state.is_blood = [](int i, int, int) { return i > 0; };
  const FluidFrame frame = read_fluid_frame(writer.write_fluid(state));
  EXPECT_LT((frame.lower - (frame_.origin + frame_.axes.transpose() * Vec3(1, 2, 3))).norm(), 1e-9);
  EXPECT_LT((frame.axes - frame_.axes).norm(), 1e-12);
  EXPECT_DOUBLE_EQ(frame.spacing, 0.5);
  EXPECT_EQ(frame.cells, (std::array<int, 3>{4, 3, 2}));
  const std::size_t cell = 3 + 4 * (2 + 3 * 1);  // i = 3, j = 2, k = 1
  EXPECT_LT((frame.velocity[cell] - frame_.axes.transpose() * Vec3(3, 2, 1)).norm(), 1e-5);
  EXPECT_NEAR(frame.pressure[cell], 3, 1e-5);
  EXPECT_EQ(frame.inside[cell], 1);
  EXPECT_EQ(frame.inside[0], 0);
  const std::string xml = read_file(results_ / "frames/fluid_0000.vti");
  EXPECT_NE(xml.substr(0, 600).find("Direction="), std::string::npos);
}

TEST_F(Frames, chordae_come_back_with_tensions_and_roots) {
  FrameWriter writer = make_writer();
  std::vector<double> x;
  for (const Vec3& p : valve_.chordae.points) {
    const Vec3 s = 1e-3 * (frame_.axes * (p - frame_.origin));
    x.insert(x.end(), s.data(), s.data() + 3);
  }
  std::vector<double> tension(valve_.chordae.segments.size(), 0.25);
  const ChordaeFrame frame = read_chordae_frame(writer.write_chordae({0.01, x, tension}));
  ASSERT_EQ(frame.segments.size(), valve_.chordae.segments.size());
  EXPECT_LT((frame.points[0] - valve_.chordae.points[0]).norm(), 1e-9);
  EXPECT_EQ(frame.muscle_of_point, valve_.chordae.muscle_of_point);
  EXPECT_EQ(frame.kind[0], ChordaKind::primary);
  EXPECT_NEAR(frame.tension[3], 0.25, 1e-6);
}

TEST_F(Frames, collection_lists_every_frame_in_seconds) {
  FrameWriter writer = make_writer();
  for (double t : {0.0, 0.01, 0.02}) write_at(writer, t);
  const auto entries = read_pvd(results_ / "leaflets.pvd");
  ASSERT_EQ(entries.size(), 3u);
  EXPECT_DOUBLE_EQ(entries[2].time, 0.02);
  EXPECT_EQ(entries[2].file, "frames/leaflets_0002.vtu");
  for (const PvdEntry& e : entries) EXPECT_TRUE(fs::exists(results_ / e.file));
  for (const auto& item : fs::recursive_directory_iterator(results_))
    EXPECT_EQ(item.path().string().find(".tmp"), std::string::npos);
}

TEST_F(Frames, resuming_drops_what_came_after_the_checkpoint) {
  {
    FrameWriter writer = make_writer();
    for (double t : {0.0, 0.01, 0.02, 0.03}) write_at(writer, t);
  }
  const std::string kept = read_file(results_ / "frames/leaflets_0001.vtu");
  FrameWriter writer = make_writer(0.01);
  EXPECT_EQ(read_pvd(results_ / "leaflets.pvd").size(), 2u);
  EXPECT_FALSE(fs::exists(results_ / "frames/leaflets_0002.vtu"));
  EXPECT_EQ(read_file(results_ / "frames/leaflets_0001.vtu"), kept);
  write_at(writer, 0.02);
  EXPECT_EQ(read_pvd(results_ / "leaflets.pvd").back().file, "frames/leaflets_0002.vtu");
}

TEST_F(Frames, the_same_instant_written_twice_is_one_frame) {
  FrameWriter writer = make_writer();
  write_at(writer, 0.01);
  write_at(writer, 0.01);
  EXPECT_EQ(read_pvd(results_ / "leaflets.pvd").size(), 1u);
}

TEST_F(Frames, a_fresh_run_clears_frames_but_nothing_else) {
  {
    FrameWriter writer = make_writer();
    write_at(writer, 0);
  }
  std::ofstream(results_ / "frames/leaflets_notes.vtu") << "mine";
  make_writer();
  EXPECT_FALSE(fs::exists(results_ / "frames/leaflets_0000.vtu"));
  EXPECT_FALSE(fs::exists(results_ / "leaflets.pvd"));
  EXPECT_TRUE(fs::exists(results_ / "frames/leaflets_notes.vtu"));
}

TEST_F(Frames, the_same_state_gives_the_same_bytes) {
  FrameWriter writer = make_writer();
  write_at(writer, 0);
  const std::string first = read_file(results_ / "frames/leaflets_0000.vtu");
  FrameWriter again = make_writer();
  write_at(again, 0);
  EXPECT_EQ(read_file(results_ / "frames/leaflets_0000.vtu"), first);
}

TEST_F(Frames, damaged_and_missing_files_are_named) {
  FrameWriter writer = make_writer();
  write_at(writer, 0);
  const fs::path file = results_ / "frames/leaflets_0000.vtu";
  fs::resize_file(file, fs::file_size(file) / 2);
  EXPECT_THROW(read_leaflets_frame(file), InputError);
  EXPECT_THROW(read_leaflets_frame(results_ / "frames/absent.vtu"), IoError);
  EXPECT_THROW(read_fluid_frame(file), InputError);
  EXPECT_THROW(read_fluid_frame(results_ / "absent.vti"), IoError);
  std::ofstream(results_ / "leaflets.pvd") << "<VTKFile><Coll";
  EXPECT_THROW(read_pvd(results_ / "leaflets.pvd"), InputError);
  EXPECT_TRUE(read_pvd(results_ / "absent.pvd").empty());
}

TEST_F(Frames, a_place_that_cannot_be_written_is_an_io_error) {
  std::ofstream(results_) << "a file where the folder should be";
  EXPECT_THROW(make_writer(), IoError);
}

TEST_F(Frames, sizes_that_do_not_match_are_our_bug) {
  FrameWriter writer = make_writer();
  std::vector<double> x(3);
  LeafletsState state;
  state.positions = x;
  EXPECT_THROW(writer.write_leaflets(state), std::logic_error);
}

}  // namespace
