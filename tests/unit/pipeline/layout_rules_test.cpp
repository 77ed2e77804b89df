// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/layout_rules.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "geometry/chordae/generic_chordae.h"
#include "support/grid_leaflet.h"

namespace {

using namespace mv;

struct Scene {
  LeafletMesh mesh = test::ring_valve();
  LeafletChart chart{mesh};
  Annulus annulus = test::ring_annulus();
  Chordae chordae = generic_chordae(mesh, annulus, test::ring_papillary(), {});
  LayoutObservation seen;

  // Both borders near x = 0 in one line at y = 0, `anterior_depth` and `posterior_depth` below the annulus plane.
  Scene(double anterior_depth, double posterior_depth, double tension) {
    seen.points = mesh.points;
    std::vector<int> region(mesh.points.size(), 0);
    for (std::size_t e = 0; e < mesh.tets.size(); ++e)
      for (std::size_t k = 0; k < 4; ++k) region[static_cast<std::size_t>(mesh.tets[e][k])] = mesh.region[e];
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
      const double share = mesh.unfolded[i].y() / chart.height(mesh.unfolded[i].x());
      seen.points[i].y() *= 1 - share;
      seen.points[i].z() = -share * (region[i] == anterior ? anterior_depth : posterior_depth);
    }
    seen.tension.assign(chordae.segments.size(), tension);
    seen.holes = {{"between A2 and P2", Vec3(0, 0, -8), 4}};
    seen.area = 4;
  }
  std::vector<LayoutChange> propose() const { return propose_changes(mesh, chart, annulus, chordae, seen, seen.holes[0]); }
};

TEST(LayoutRules, a_prolapsing_border_is_pulled_down_first) {
  const Scene scene(4, 10, 0.2);
  auto changes = scene.propose();
  ASSERT_FALSE(changes.empty());
  EXPECT_EQ(changes[0].leaflet, anterior);
  if (changes[0].action == LayoutChange::add) changes.erase(changes.begin());  // where the nearest chorda is far
  ASSERT_FALSE(changes.empty());
  EXPECT_EQ(changes[0].action, LayoutChange::shorten);
  EXPECT_EQ(changes[0].leaflet, anterior);
  EXPECT_NEAR(changes[0].amount, 2.0, 1e-9);  // half of 6 mm, at most 2
  for (int s : changes[0].segments) EXPECT_EQ(scene.chordae.segments[static_cast<std::size_t>(s)].leaflet, anterior);
  const auto other = Scene(10, 4, 0.2).propose();
  ASSERT_FALSE(other.empty());
  EXPECT_EQ(other[0].leaflet, posterior);
}

TEST(LayoutRules, taut_chordae_at_equal_depth_are_lengthened_slack_ones_shortened) {
  const auto taut = Scene(8, 8, 0.2).propose();
  ASSERT_FALSE(taut.empty());
  EXPECT_EQ(taut[0].action, LayoutChange::lengthen);
  const auto slack = Scene(8, 8, 0.0).propose();
  ASSERT_FALSE(slack.empty());
  EXPECT_EQ(slack[0].action, LayoutChange::shorten);
  EXPECT_EQ(slack[0].leaflet, 0);
}

TEST(LayoutRules, a_border_without_a_chorda_near_gets_one) {
  Scene scene(4, 10, 0.2);
  std::erase_if(scene.chordae.segments, [](const ChordaSegment& s) { return s.leaflet == anterior && s.kind == ChordaKind::primary; });
  scene.seen.tension.resize(scene.chordae.segments.size());
  const auto changes = scene.propose();
  ASSERT_FALSE(changes.empty());
  EXPECT_EQ(changes[0].action, LayoutChange::add);
  EXPECT_EQ(changes[0].leaflet, anterior);
  const Vec2 uv = scene.chart.border_uv(changes[0].arc);
  EXPECT_NEAR(uv.x(), 18, 3);  // the middle of the anterior leaflet
}

TEST(LayoutRules, no_chorda_starts_stretched_by_more_than_15_percent) {
  Scene scene(4, 10, 0.2);
  LayoutChange change;
  for (int s = 0; s < static_cast<int>(scene.chordae.segments.size()); ++s) change.segments.push_back(s);
  change.amount = 100;
  EXPECT_TRUE(change_lengths(scene.chordae, change));
  for (const ChordaSegment& s : scene.chordae.segments) {
    const double initial = (scene.chordae.points[static_cast<std::size_t>(s.a)] - scene.chordae.points[static_cast<std::size_t>(s.b)]).norm();
    EXPECT_NEAR(s.rest_length, initial / 1.15, 1e-9);
  }
  EXPECT_FALSE(change_lengths(scene.chordae, change));
  change.action = LayoutChange::lengthen;
  change.amount = 1.5;
  EXPECT_TRUE(change_lengths(scene.chordae, change));
  EXPECT_NEAR(scene.chordae.segments[0].rest_length, (scene.chordae.points[static_cast<std::size_t>(scene.chordae.segments[0].a)] - scene.chordae.points[static_cast<std::size_t>(scene.chordae.segments[0].b)]).norm() / 1.15 + 1.5, 1e-9);
}

TEST(LayoutRules, names_tell_changes_apart) {
  const Scene scene(4, 10, 0.2);
  const auto changes = scene.propose();
  for (std::size_t i = 0; i < changes.size(); ++i)
    for (std::size_t j = i + 1; j < changes.size(); ++j) EXPECT_NE(changes[i].name(), changes[j].name());
}

}  // namespace
