// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "geometry/core/errors.h"
#include "solver/time/boundary_motion.h"
#include "solver/time/preflight.h"

namespace {

using mv::Vec3;

/// One chorda of 10 mm and 1 mm2 from a tip at the origin to a leaflet end on node 0.
mv::Chordae one_chorda() {
  mv::Chordae chordae;
  chordae.points = {Vec3::Zero(), Vec3(0, 0, 10)};
  chordae.muscle_of_point = {0, -1};
  mv::ChordaSegment segment;
  segment.a = 0, segment.b = 1, segment.rest_length = 10, segment.area = 1;
  chordae.segments = {segment};
  chordae.insertions = {{1, 0, 1.0}};
  return chordae;
}

struct Motion : testing::Test {
  mv::Config config;
  mv::Chordae chordae = one_chorda();
  mv::ChordaeTension tension{chordae, 1, 1e6};   // stiffness E A / L = 100 N/m
  std::vector<double> x{0, 0, 0.011};            // stretched by 1 mm
  std::vector<Vec3> tips{Vec3::Zero()};
  mv::BoundaryMotion motion() const { return mv::BoundaryMotion(config, chordae, mv::Tube(), {Vec3::Zero()}); }
};

TEST_F(Motion, nothing_moves_unless_it_is_asked_for) {
  EXPECT_FALSE(motion().is_active());
  EXPECT_FALSE(motion().changes(0, 1));
}

TEST_F(Motion, tips_move_along_a_cosine_and_stay) {
  config.set("papillary.displacement=[0 mm, 0 mm, -10 mm]");
  config.set("papillary.move_start=50 ms");
  config.set("papillary.move_time=20 ms");
  const auto m = motion();
  EXPECT_TRUE(m.is_active());
  for (const auto& [time, z] : {std::pair{0.0, 0.0}, {0.05, 0.0}, {0.055, -0.01 * 0.5 * (1 - std::sqrt(0.5))}, {0.06, -0.005}, {0.07, -0.01}, {1.0, -0.01}}) {
    m.apply(time, tension, tips);
    EXPECT_NEAR(tips[0].z(), z, 1e-15) << time;
  }
  EXPECT_FALSE(m.changes(0.0, 0.05));
  EXPECT_TRUE(m.changes(0.05, 0.051));
  EXPECT_FALSE(m.changes(0.07, 0.08));
  // A rollback goes back in time.
  m.apply(0.01, tension, tips);
  EXPECT_EQ(tips[0].z(), 0.0);
}

TEST_F(Motion, a_tip_that_moves_in_no_time_is_there_in_the_next_step) {
  config.set("papillary.displacement=[0 mm, 0 mm, -10 mm]");
  config.set("papillary.move_time=0 s");
  motion().apply(0.0, tension, tips);
  EXPECT_EQ(tips[0].z(), 0.0);
  EXPECT_TRUE(motion().changes(0.0, 1e-5));
  motion().apply(1e-5, tension, tips);
  EXPECT_EQ(tips[0].z(), -0.01);
}

TEST_F(Motion, a_cut_chorda_carries_nothing_and_a_rollback_mends_it) {
  config.set("chordae.cut=[0]");
  config.set("chordae.cut_time=10 ms");
  const auto m = motion();
  std::vector<double> f(3, 0.0);
  m.apply(0.0, tension, tips);
  EXPECT_NEAR(tension.forces(x, tips, f), 0.5 * 100 * 1e-6, 1e-12);
  EXPECT_NEAR(f[2], -0.1, 1e-12);
  m.apply(0.011, tension, tips);
  f.assign(3, 0.0);
  EXPECT_EQ(tension.forces(x, tips, f), 0.0);
  EXPECT_EQ(f[2], 0.0);
  EXPECT_EQ(tension.tensions()[0], 0.0);
  EXPECT_EQ(tension.energy(x, tips), 0.0);
  m.apply(0.005, tension, tips);
  EXPECT_NEAR(tension.energy(x, tips), 0.5 * 100 * 1e-6, 1e-12);
}

TEST_F(Motion, a_cut_of_nothing_is_refused) {
  config.set("chordae.cut=[1]");
  EXPECT_THROW(motion(), mv::ConfigError);
}

TEST(SmallestDihedral, of_known_tetrahedra) {
  const Vec3 a(1, 1, 1), b(1, -1, -1), c(-1, 1, -1), d(-1, -1, 1);
  EXPECT_NEAR(mv::smallest_dihedral(a, c, b, d), std::acos(1.0 / 3) * 180 / M_PI, 1e-9);   // regular
  EXPECT_NEAR(mv::smallest_dihedral(a, b, c, d), -std::acos(1.0 / 3) * 180 / M_PI, 1e-9);  // inverted
  const Vec3 o = Vec3::Zero(), x = Vec3::UnitX(), y = Vec3::UnitY();
  EXPECT_NEAR(mv::smallest_dihedral(o, x, y, Vec3::UnitZ()), std::acos(std::sqrt(1.0 / 3)) * 180 / M_PI, 1e-9);   // cube's corner: 54.7 degrees
  EXPECT_EQ(mv::smallest_dihedral(o, x, y, Vec3(0.3, 0.3, 0)), 0.0);
  EXPECT_EQ(mv::smallest_dihedral(o, x, x, y), 0.0);
}

}  // namespace
