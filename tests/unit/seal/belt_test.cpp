// SPDX-License-Identifier: BSD-3-Clause
// The contact belt on a flat map with a known band.

#include "solver/seal/belt.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "geometry/core/errors.h"

namespace mv {
namespace {

/// Posterior leaflet u 0..60, anterior u 60..100, v 0..20, points 0.5 mm apart.
BeltInput map_with(const std::function<bool(double, double)>& contact) {
  BeltInput in;
  const double s = 0.5;
  const auto leaf = [&](double u0, double u1, int region) {
    const int ni = static_cast<int>(std::lround((u1 - u0) / s)), nj = 40, first = static_cast<int>(in.unfolded.size());
    for (int j = 0; j <= nj; ++j)
      for (int i = 0; i <= ni; ++i) {
        const double u = u0 + s * i, v = s * j;
        in.unfolded.emplace_back(u, v);
        in.in_contact.push_back(contact(u, v));
      }
    for (int j = 0; j < nj; ++j)
      for (int i = 0; i < ni; ++i) {
        const int a = first + j * (ni + 1) + i;
        in.triangles.push_back({a, a + 1, a + ni + 2});
        in.triangles.push_back({a, a + ni + 2, a + ni + 1});
        in.region.insert(in.region.end(), 2, region);
      }
  };
  leaf(0, 60, posterior);
  leaf(60, 100, anterior);
  return in;
}

bool band(double, double v) { return v > 9.9 && v < 15.1; }

TEST(Belt, full_band_is_continuous_and_has_its_width) {
  const BeltResult r = measure_belt(map_with(band));
  EXPECT_TRUE(r.continuous);
  EXPECT_TRUE(r.interruptions.empty());
  ASSERT_EQ(r.leaflets.size(), 2u);
  // Points at v = 10 .. 15 in contact; the triangles beyond them count by a third or two: half a cell on either side.
  EXPECT_NEAR(r.width_mean_mm, 5.5, 1e-9);
  EXPECT_NEAR(r.contact_area_mm2, 550, 1e-6);
  EXPECT_EQ(r.leaflets[0].largest_gap_mm, 0);
}

TEST(Belt, punched_gap_interrupts_one_leaflet_and_is_located) {
  const BeltResult r = measure_belt(map_with([](double u, double v) { return band(u, v) && !(u > 20.1 && u < 22.9); }));
  EXPECT_FALSE(r.continuous);
  EXPECT_FALSE(r.leaflets[0].continuous);
  EXPECT_TRUE(r.leaflets[1].continuous);
  ASSERT_EQ(r.interruptions.size(), 1u);
  const BeltInterruption& gap = r.interruptions[0];
  EXPECT_EQ(gap.region, posterior);
  EXPECT_NEAR(gap.u_from, 20, 1e-9);
  EXPECT_NEAR(gap.u_to, 23, 1e-9);
  EXPECT_NEAR(gap.width_mm, 3 - (0.5 + 0.5 + std::sqrt(0.5)) / 3, 1e-9);
}

TEST(Belt, gap_not_wider_than_the_spacing_does_not_interrupt) {
  const auto one_point = [](double u, double v) { return band(u, v) && std::abs(u - 30) > 0.1; };
  EXPECT_TRUE(measure_belt(map_with(one_point)).continuous);
  const auto three_points = [](double u, double v) { return band(u, v) && std::abs(u - 30) > 0.6; };
  EXPECT_FALSE(measure_belt(map_with(three_points)).continuous);
  EXPECT_TRUE(measure_belt(map_with(three_points), {.spacing_mm = 1.5}).continuous);
}

TEST(Belt, way_around_a_hole_in_the_band_counts) {
  const auto ring = [](double u, double v) { return band(u, v) && !(std::hypot(u - 30, v - 12.5) < 1.8); };
  EXPECT_TRUE(measure_belt(map_with(ring)).continuous);
}

TEST(Belt, steps_in_v_interrupt_although_every_u_is_covered) {
  const auto stair = [](double u, double v) { return u < 80 ? v > 2.9 && v < 5.1 : v > 9.9 && v < 12.1; };
  const BeltResult r = measure_belt(map_with(stair));
  EXPECT_TRUE(r.leaflets[0].continuous);
  EXPECT_FALSE(r.leaflets[1].continuous);
  ASSERT_EQ(r.interruptions.size(), 1u);
  EXPECT_NEAR(r.interruptions[0].u_from, 80, 0.6);
  EXPECT_NEAR(std::abs(r.interruptions[0].v_to - r.interruptions[0].v_from), 5, 1e-9);
}

TEST(Belt, must_reach_both_commissures) {
  const auto short_band = [](double u, double v) { return band(u, v) && u > 5 && u < 95; };
  const BeltResult r = measure_belt(map_with(short_band));
  EXPECT_FALSE(r.leaflets[0].continuous);
  EXPECT_FALSE(r.leaflets[1].continuous);
  ASSERT_EQ(r.interruptions.size(), 2u);
  EXPECT_NEAR(r.interruptions[0].u_from, 0, 1e-9);
  EXPECT_NEAR(r.interruptions[0].u_to, 5.5, 1e-9);
  EXPECT_NEAR(r.interruptions[1].u_to, 100, 1e-9);
  const auto nearly = [](double u, double v) { return band(u, v) && u > 1.4 && u < 98.6; };
  EXPECT_TRUE(measure_belt(map_with(nearly)).continuous);
}

TEST(Belt, without_contact_there_is_no_belt) {
  const BeltResult r = measure_belt(map_with([](double, double) { return false; }));
  EXPECT_FALSE(r.continuous);
  EXPECT_EQ(r.contact_area_mm2, 0);
  EXPECT_EQ(r.interruptions.size(), 2u);
}

TEST(Belt, current_area_follows_the_deformed_points) {
  BeltInput in = map_with(band);
  for (const Vec2& p : in.unfolded) in.current.emplace_back(2 * p.x(), 1.5 * p.y(), 3);
  const BeltResult r = measure_belt(in);
  EXPECT_NEAR(r.contact_area_mm2, 3 * 550, 1e-6);
  EXPECT_NEAR(r.width_mean_mm, 5.5, 1e-9);
}

TEST(Belt, sizes_that_do_not_match_are_refused) {
  BeltInput in = map_with(band);
  in.in_contact.pop_back();
  EXPECT_THROW(measure_belt(in), InputError);
}

}  // namespace
}  // namespace mv
