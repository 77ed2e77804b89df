// SPDX-License-Identifier: BSD-3-Clause
// Number, place, area and name of holes on solids whose holes are known.

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cmath>
#include <ctime>

#include "solver/seal/seal.h"
#include "unit/seal/seal_shapes.h"

namespace mv {
namespace {

using namespace test;
constexpr double pi = std::numbers::pi;

void expect_area(double area, double expected, double share) { EXPECT_NEAR(area, expected, share * expected) << area / expected; }

TEST(Holes, round_hole_has_its_area_and_place) {
  for (double radius : {0.6, 1.0, 2.0, 5.0})
    for (double shift : {0.0, 0.09}) {
      const Vec2 centre(1 + shift, -2 + 0.7 * shift);
      const SealResult r = find_seal(in_tube(ring_plate(radius, 15.2, 1.0, centre), circle(15)), 0.4);
      ASSERT_EQ(r.holes.size(), 1u) << radius;
      expect_area(r.hole_area_mm2, pi * radius * radius, 0.07);
      EXPECT_NEAR(r.holes[0].width_mm, 2 * radius, 0.06);
      EXPECT_LT((r.holes[0].place - Vec3(centre.x(), centre.y(), 0)).norm(), 0.4) << radius;
      EXPECT_TRUE(r.warnings.empty()) << r.warnings[0];
    }
}

TEST(Holes, round_hole_in_a_tilted_plate) {
  for (double degrees : {20.0, 40.0}) {
    const double slope = std::tan(degrees * pi / 180);
    const auto map = [=](const Vec3& p) {
      return Vec3(p.x() * std::cos(degrees * pi / 180) - p.z() * std::sin(degrees * pi / 180), p.y(),
                  p.x() * std::sin(degrees * pi / 180) + p.z() * std::cos(degrees * pi / 180));
    };
    const SealResult r = find_seal(
        in_tube(ring_plate(2, 22, 1.0, {0.4, 0.3}, map), circle(15), [=](const Vec2& p) { return slope * p.x(); }), 0.5);
    ASSERT_EQ(r.holes.size(), 1u);
    expect_area(r.hole_area_mm2, 4 * pi, 0.1);
    EXPECT_NEAR(r.smallest.value_mm, 4.0, 0.06);
  }
}

TEST(Holes, hole_through_a_thick_plate) {
  const SealResult r = find_seal(in_tube(ring_plate(1.5, 15.2, 6.0, {3.1, 0}), circle(15)), 0.4);
  ASSERT_EQ(r.holes.size(), 1u);
  expect_area(r.hole_area_mm2, 2.25 * pi, 0.05);
}

TEST(Holes, slit_of_known_width) {
  for (double width : {0.3, 0.5, 0.8})
    for (double shift : {0.0, 0.06}) {
      // Cells of the slit are `width` wide: a plate of bars, 8 long.
      const auto xy = [=](int i, int j) {
        const std::vector<double> x{-10.5, -0.5 * width, 0.5 * width, 10.5};
        return Vec2(x[static_cast<std::size_t>(i)] + shift, 0.5 * (j - 21));
      };
      const Solid plate = extrude(
          3, 42, false, xy, [](int i, int j) { return i != 1 || j < 13 || j >= 29; }, 1.0);
      const SealResult r = find_seal(in_tube(plate, rectangle(20, 20)), 0.2);
      ASSERT_EQ(r.holes.size(), 1u) << width;
      EXPECT_NEAR(r.smallest.value_mm, width, 0.03);
      expect_area(r.hole_area_mm2, 8 * width, 0.12);
      EXPECT_TRUE(find_seal(in_tube(plate, rectangle(20, 20)), width + 0.05).sealed);
    }
}

TEST(Holes, two_holes_are_two_with_their_own_areas) {
  const auto keep = [](int i, int j) {
    const bool first = i >= 10 && i < 14 && j >= 8 && j < 12;   // 2 x 2 mm
    const bool second = i >= 15 && i < 21 && j >= 8 && j < 14;  // 3 x 3 mm, half a millimetre further
    return !first && !second;
  };
  const SealResult r = find_seal(in_tube(cell_plate(42, 42, 0.5, keep, 1.0), rectangle(20, 20)), 0.4);
  ASSERT_EQ(r.holes.size(), 2u);
  expect_area(r.holes[0].area_mm2, 9, 0.08);
  expect_area(r.holes[1].area_mm2, 4, 0.08);
  EXPECT_LT((r.holes[0].place - Vec3(-1.5, -5, 0)).norm(), 0.5);
  EXPECT_LT((r.holes[1].place - Vec3(-4.5, -5.5, 0)).norm(), 0.5);
  EXPECT_NEAR(r.holes[0].width_mm, 3, 0.06);
  EXPECT_NEAR(r.holes[1].width_mm, 2, 0.06);
}

TEST(Holes, only_holes_as_wide_as_the_threshold_count) {
  const auto keep = [](int i, int j) {
    return !(i >= 8 && i < 10 && j >= 20 && j < 22) && !(i >= 24 && i < 28 && j >= 20 && j < 24);
  };
  const SealInput in = in_tube(cell_plate(42, 42, 0.5, keep, 1.0), rectangle(20, 20));  // 1 x 1 and 2 x 2 mm
  EXPECT_EQ(find_seal(in, 0.9).holes.size(), 2u);
  EXPECT_EQ(find_seal(in, 1.2).holes.size(), 1u);
  EXPECT_EQ(find_seal(in, 2.1).holes.size(), 0u);
}

TEST(Holes, curved_gap_between_plug_and_ring) {
  for (double gap : {0.3, 0.8}) {
    Solid s = ring_plate(
        6 + gap, 15.2, 5.0, {0, 0}, [](const Vec3& p) { return p; }, 12, 240);
    s.add(ring_plate(
        0, 6, 5.0, {0, 0}, [](const Vec3& p) { return p; }, 12, 240));
    const SealResult r = find_seal(in_tube(s, circle(15)), 0.2);
    ASSERT_EQ(r.holes.size(), 1u) << gap;
    EXPECT_NEAR(r.smallest.value_mm, gap, 0.04);
    expect_area(r.hole_area_mm2, pi * ((6 + gap) * (6 + gap) - 36), 0.12);
  }
}

TEST(Holes, gap_between_two_leaflets_is_one_hole_along_the_coaptation) {
  for (double gap : {0.6, 1.0}) {
    SealInput in = two_leaflets(gap, 0.2, 0.04);
    for (Vec3& p : in.annulus) p.z() += 5;  // keeps the ring, which narrows the slit at its ends, away from it
    const SealResult r = find_seal(in, 0.4);
    ASSERT_EQ(r.holes.size(), 1u) << gap;
    expect_area(r.hole_area_mm2, 20 * gap / std::hypot(1.0, 0.2), 0.1);
    EXPECT_NEAR(r.holes[0].place.y(), 0, 0.5);
    EXPECT_NEAR(r.holes[0].width_mm, gap / std::hypot(1.0, 0.2), 0.04);
  }
}

TEST(Holes, domes_closed_and_with_a_hole) {
  const auto dome = [](const Vec3& p) {
    const double r2 = p.x() * p.x() + p.y() * p.y();
    return Vec3(p.x(), p.y(), p.z() + 8 * (1 - r2 / 225));
  };
  const auto rim = [](const Vec2&) { return 0.0; };
  EXPECT_TRUE(find_seal(in_tube(ring_plate(0, 15.1, 1.5, {0, 0}, dome), circle(15), rim), 0.1).sealed);
  const SealResult r = find_seal(in_tube(ring_plate(1.5, 15.1, 1.5, {0, 0}, dome), circle(15), rim), 0.5);
  ASSERT_EQ(r.holes.size(), 1u);
  expect_area(r.hole_area_mm2, 2.25 * pi, 0.08);
  EXPECT_NEAR(r.holes[0].place.z(), 8, 0.8);
}

TEST(Holes, open_funnel_has_the_area_of_its_mouth) {
  // A skirt hanging from the annulus (radius 15) down to an inner radius of 9.5 at z = -12, one millimetre thick.
  const auto skirt = [](const Vec3& p) {
    const double s = p.x() / 12, a = p.y();
    const double r = 15.2 - 5.2 * s + p.z();
    return Vec3(r * std::cos(a), r * std::sin(a), -p.x());
  };
  const Solid s = extrude(
      24, 96, true, [](int i, int j) { return Vec2(0.5 * i, 2 * pi * j / 96); }, [](int, int) { return true; }, 1.0, skirt);
  const SealResult r = find_seal(in_tube(s, circle(15)), 1.0);
  EXPECT_FALSE(r.sealed);
  ASSERT_EQ(r.holes.size(), 1u);
  expect_area(r.hole_area_mm2, pi * 9.5 * 9.5, 0.1);
  EXPECT_NEAR(r.smallest.value_mm, 19.0, 0.3);
  EXPECT_NEAR(r.holes[0].place.z(), -12, 1.5);
}

TEST(Holes, names_follow_the_map_and_the_anterolateral_side) {
  // Disc with the anterior leaflet at y > 2; u runs along x: posterior 0..57, anterior 57..87, both against x. Anterolateral is
  // +x.
  const auto named = [](const Vec2& hole) {
    SealInput in = in_tube(ring_plate(0.8, 15.2, 1.0, hole), circle(15));
    for (const Vec3& p : in.points) {
      const bool front = p.y() > 2;
      in.region.push_back(front ? anterior : posterior);
      const double s = std::clamp((15.2 - p.x()) / 30.4, 0.0, 1.0);
      in.unfolded.emplace_back(front ? 57 + 30 * s : 57 * (1 - s), 0);
    }
    in.anterolateral = Vec3(1, 0, 0);
    const SealResult r = find_seal(in, 0.5, {.spacing_mm = 0.4});
    EXPECT_EQ(r.holes.size(), 1u);
    return r.holes.at(0).location;
  };
  EXPECT_EQ(named({9, -5}), "P1");
  EXPECT_EQ(named({0, -8}), "P2");
  EXPECT_EQ(named({-9, -5}), "P3");
  EXPECT_EQ(named({0, 8}), "A2");
  EXPECT_EQ(named({9, 7}), "A1");
  EXPECT_EQ(named({0, 2}), "between A2 and P2");
  EXPECT_EQ(named({13.2, 1}), "anterolateral commissure");
  EXPECT_EQ(named({-13.2, 1}), "posteromedial commissure");
}

TEST(Holes, valve_sized_tube_stays_within_time_and_memory) {
  // 44 x 36 mm ellipse, a bag 25 mm deep with edges of about half a millimetre, without and with a hole of 3 x 3 mm in plan.
  std::vector<Vec2> section;
  for (const Vec2& p : circle(1, 160)) section.emplace_back(22 * p.x(), 18 * p.y());
  const auto depth = [](double x, double y) { return 25 * (1 - x * x / 484 - y * y / 324); };
  const auto bag = [&](const Vec3& p) { return Vec3(p.x(), p.y(), 2 * p.z() - depth(p.x(), p.y())); };
  for (bool hole : {false, true}) {
    const auto keep = [&](int i, int j) {
      const double x = 0.4 * (i - 56.5), y = 0.4 * (j - 46.5);
      return depth(x, y) > -2.5 && !(hole && x > 1 && x < 4 && y > -2 && y < 1);
    };
    const Solid solid = cell_plate(114, 94, 0.4, keep, 1.0, bag);
    const std::clock_t start = std::clock();
    const SealResult r = find_seal(in_tube(solid, section), 0.5);
    const double cpu = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    EXPECT_EQ(r.sealed, !hole);
    EXPECT_GT(r.voxels, 2'000'000);
    EXPECT_LT(cpu, 20);
    std::printf("%ld voxels, %zu triangles, hole %d: %.2f s of processor, %.2f s, %zu holes\n", r.voxels, solid.triangles.size(),
                hole, cpu, r.seconds, r.holes.size());
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::printf("largest memory of this process: %ld MB\n", usage.ru_maxrss / 1024);
  EXPECT_LT(usage.ru_maxrss / 1024, 500);
}

}  // namespace
}  // namespace mv
