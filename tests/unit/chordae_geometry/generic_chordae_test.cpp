// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/chordae/generic_chordae.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "geometry/core/errors.h"
#include "support/grid_leaflet.h"

namespace {

using namespace mv;

const LeafletMesh& valve() {
  static const LeafletMesh mesh = test::ring_valve();
  return mesh;
}
const LeafletChart& chart() {
  static const LeafletChart c(valve());
  return c;
}
Chordae make(const ChordaeOptions& options = {}) {
  return generic_chordae(valve(), test::ring_annulus(), test::ring_papillary(), options);
}

int count(const Chordae& c, ChordaKind kind, int leaflet = 0, int muscle = -1) {
  return static_cast<int>(std::count_if(c.segments.begin(), c.segments.end(), [&](const ChordaSegment& s) {
    return s.kind == kind && (leaflet == 0 || s.leaflet == leaflet) && (muscle < 0 || s.muscle == muscle);
  }));
}

TEST(LeafletChart, finds_two_commissures_and_two_notches) {
  EXPECT_NEAR(chart().period(), 107.2, 0.05);
  ASSERT_EQ(chart().junctions().size(), 4u);
  const std::vector<double> expected{0, 36, 36 + 71.2 / 3, 36 + 2 * 71.2 / 3};
  for (std::size_t k = 0; k < 4; ++k) {
    const auto& j = chart().junctions()[k];
    const Vec2 uv = chart().border()[static_cast<std::size_t>(j.border_index)].uv;
    EXPECT_NEAR(uv.x(), expected[k], 1e-6);
    EXPECT_NEAR(uv.y(), 6, 1e-6);
    EXPECT_EQ(j.is_commissure, k < 2);
  }
}

TEST(LeafletChart, mid_surface_lies_on_the_cone_half_way_between_the_faces) {
  const test::RingSpec r;
  const double radius = r.perimeter / (2 * std::numbers::pi), length = std::hypot(1.0, r.slope);
  for (const Vec2& uv : {Vec2(18, 10), Vec2(5, 4), Vec2(55, 8), Vec2(106.9, 3), Vec2(-0.3, 3), Vec2(107.2 + 18, 10)}) {
    const auto p = chart().at(uv);
    EXPECT_NEAR(p.position.z(), -uv.y() / length, 0.01);
    EXPECT_NEAR(p.position.head<2>().norm(), radius - uv.y() * r.slope / length, 0.02);
    EXPECT_NEAR(p.normal.z(), r.slope / length, 0.01);
  }
  EXPECT_NEAR(chart().height(18), 6 + 16.2, 0.01);
  EXPECT_NEAR(chart().height(-89.2), 6 + 16.2, 0.01);
}

TEST(LeafletChart, border_arc_and_place_agree) {
  const auto& border = chart().border();
  for (std::size_t i = 0; i < border.size(); i += 7)
    EXPECT_LT((chart().border_uv(border[i].arc) - border[i].uv).norm(), 1e-9);
  EXPECT_LT((chart().border_uv(border[5].arc - chart().border_length()) - border[5].uv).norm(), 1e-9);
}

TEST(GenericChordae, default_is_fourteen_primary_and_eight_secondary_half_on_each_muscle) {
  const Chordae c = make();
  EXPECT_EQ(count(c, ChordaKind::primary), 14);
  EXPECT_EQ(count(c, ChordaKind::secondary), 8);
  EXPECT_EQ(count(c, ChordaKind::secondary, anterior), 2);
  EXPECT_EQ(count(c, ChordaKind::secondary, posterior), 6);
  for (int m : {0, 1}) {
    EXPECT_EQ(count(c, ChordaKind::primary, 0, m), 7);
    EXPECT_EQ(count(c, ChordaKind::secondary, 0, m), 4);
  }
  EXPECT_TRUE(check_insertions(valve(), c).passed);
}

TEST(GenericChordae, hang_on_the_muscle_of_their_own_side) {
  const Chordae c = make();
  for (const ChordaSegment& s : c.segments) {
    const Vec3 end = c.points[static_cast<std::size_t>(s.b)];
    EXPECT_EQ(s.muscle, end.x() > 0 ? 0 : 1);
    EXPECT_EQ(c.muscle_of_point[static_cast<std::size_t>(s.a)], s.muscle);
  }
}

TEST(GenericChordae, arrangement_is_a_mirror_image_about_the_middle) {
  const Chordae c = make();
  for (const ChordaSegment& s : c.segments) {
    Vec3 mirrored = c.points[static_cast<std::size_t>(s.b)];
    mirrored.x() = -mirrored.x();
    double best = 1e9;
    for (const ChordaSegment& o : c.segments)
      if (o.muscle != s.muscle && o.kind == s.kind)
        best = std::min(best, (c.points[static_cast<std::size_t>(o.b)] - mirrored).norm());
    EXPECT_LT(best, 0.15);
  }
}

TEST(GenericChordae, every_commissure_and_notch_has_its_own_and_no_stretch_of_border_is_bare) {
  for (int primary : {4, 8, 11, 14, 20}) {
    ChordaeOptions options;
    options.primary = primary;
    const Chordae c = make(options);
    std::set<int> ends;  // one in the middle of a leaflet hangs on both muscles by two segments
    for (const ChordaSegment& s : c.segments)
      if (s.kind == ChordaKind::primary) ends.insert(s.b);
    EXPECT_EQ(static_cast<int>(ends.size()), primary);
    for (const auto& j : chart().junctions()) {
      const Vec3 place = chart().border()[static_cast<std::size_t>(j.border_index)].position;
      double best = 1e9;
      for (const ChordaSegment& s : c.segments)
        if (s.kind == ChordaKind::primary) best = std::min(best, (c.points[static_cast<std::size_t>(s.b)] - place).norm());
      EXPECT_LT(best, 1.3);
    }
    if (primary == 14) {
      EXPECT_LT(largest_border_gap(chart(), c), 1.25 * chart().border_length() / 14);
    }
  }
}

TEST(GenericChordae, removing_one_leaves_a_bare_stretch_and_the_rest_as_it_was) {
  const Chordae all = make();
  ChordaeOptions options;
  options.removed = {2};
  const Chordae c = make(options);
  EXPECT_EQ(count(c, ChordaKind::primary), 13);
  EXPECT_GT(largest_border_gap(chart(), c), 1.7 * chart().border_length() / 14);
  for (const ChordaSegment& s : c.segments) {
    const Vec3 end = c.points[static_cast<std::size_t>(s.b)];
    EXPECT_TRUE(std::any_of(all.segments.begin(), all.segments.end(), [&](const ChordaSegment& o) {
      return (all.points[static_cast<std::size_t>(o.b)] - end).norm() < 1e-12 && o.rest_length == s.rest_length;
    }));
  }
}

TEST(GenericChordae, insertions_stay_on_their_scallop_except_at_junctions) {
  // The sphere of a chorda on the flank of a scallop may not take nodes of the next scallop above the bottom of the notch.
  const Chordae c = make();
  const double scallop = 71.2 / 3;
  for (const ChordaSegment& s : c.segments) {
    if (s.kind != ChordaKind::primary || s.leaflet != posterior) continue;
    double u_end = 0, weight_elsewhere = 0;
    for (const Insertion& i : c.insertions)
      if (i.point == s.b) u_end += i.weight * valve().unfolded[static_cast<std::size_t>(i.node)].x();
    const double from_notch = std::abs(std::remainder(u_end - 36, scallop));
    if (from_notch < 2) continue;
    const int own = static_cast<int>(std::floor((u_end - 36) / scallop));
    for (const Insertion& i : c.insertions) {
      if (i.point != s.b) continue;
      const Vec2 uv = valve().unfolded[static_cast<std::size_t>(i.node)];
      if (static_cast<int>(std::floor((uv.x() - 36) / scallop + 1e-9)) != own && uv.y() > 7) weight_elsewhere += i.weight;
    }
    EXPECT_LT(weight_elsewhere, 1e-3);
  }
}

TEST(GenericChordae, rest_length_is_the_distance_to_the_closed_place_and_never_below_the_initial_one) {
  for (double slack : {0.5, 0.95, 1.0, 1.1}) {
    ChordaeOptions options;
    options.slack = slack;
    const Chordae c = make(options);
    int at_initial = 0;
    for (const ChordaSegment& s : c.segments) {
      const double initial = (c.points[static_cast<std::size_t>(s.a)] - c.points[static_cast<std::size_t>(s.b)]).norm();
      EXPECT_GE(s.rest_length, initial);
      EXPECT_LT(s.rest_length, 2.0 * initial);
      at_initial += s.rest_length == initial;
    }
    if (slack == 0.5) {
      EXPECT_EQ(at_initial, 22);
    }
    if (slack == 1.1) {
      EXPECT_EQ(at_initial, 0);
    }
  }
  const ClosedShape closed(chart(), -Vec3::UnitZ(), 5);
  const Chordae c = make();
  // Anterior strut: its place is known in closed form from the pattern.
  const ChordaSegment& strut = c.segments[14];
  EXPECT_EQ(strut.kind, ChordaKind::secondary);
  const double u = 18 - 0.24 * 36, v = 0.55 * test::ring_height({}, u);
  const Vec3 tip = test::ring_papillary().tips[static_cast<std::size_t>(strut.muscle)];
  EXPECT_NEAR(strut.rest_length, (closed.at({u, v}) - tip).norm(), 0.05);
}

TEST(GenericChordae, junction_slack_changes_only_commissures_and_notches) {
  ChordaeOptions options;
  options.junction_slack = 1.1;
  const Chordae a = make(), b = make(options);
  int changed = 0;
  for (std::size_t k = 0; k < a.segments.size(); ++k) {
    if (a.segments[k].rest_length == b.segments[k].rest_length) continue;
    EXPECT_NEAR(b.segments[k].rest_length / a.segments[k].rest_length, 1.1, 1e-9);
    EXPECT_EQ(a.segments[k].kind, ChordaKind::primary);
    ++changed;
  }
  EXPECT_EQ(changed, 4);
}

TEST(ClosedShape, keeps_lengths_along_each_meridian_and_joins_both_leaflets_at_the_belt) {
  const ClosedShape closed(chart(), -Vec3::UnitZ(), 5);
  for (double u : {4.0, 18.0, 30.0, 50.0, 71.6, 100.0}) {
    double length = 0;
    const double height = chart().height(u);
    for (int k = 0; k < 100; ++k)
      length += (closed.at({u, height * (k + 1) / 100}) - closed.at({u, height * k / 100})).norm();
    EXPECT_NEAR(length, height, 0.02 * height);
    EXPECT_LT((closed.at({u, 0}) - chart().at({u, 0}).position).norm(), 1e-9);
  }
  // The middles of both leaflets hang from the same line, below the annulus plane.
  const Vec3 a = closed.at({18, chart().height(18)}), p = closed.at({36 + 35.6, chart().height(36 + 35.6)});
  EXPECT_LT((a - p).head<2>().norm(), 0.1);
  EXPECT_LT(a.z(), -5);
  EXPECT_LT(p.z(), -5);
  EXPECT_NEAR(closed.fraction(18), 0.5, 1e-3);
  EXPECT_NEAR(closed.fraction(71.6), 0.5, 1e-3);
  EXPECT_TRUE(closed.is_anterior(18 + 107.2));
  EXPECT_FALSE(closed.is_anterior(-1));
}

TEST(GenericChordae, bifurcated_primaries_share_a_branch_point_and_use_half_the_radius) {
  ChordaeOptions options;
  options.bifurcated = true;
  const Chordae c = make(options);
  EXPECT_EQ(count(c, ChordaKind::primary), 14 * 3);
  EXPECT_TRUE(check_insertions(valve(), c).passed);
  const Chordae plain = make();
  const auto extent = [&](const Chordae& chordae, int point) {
    double largest = 0;
    for (const Insertion& i : chordae.insertions)
      if (i.point == point)
        largest = std::max(
            largest, (valve().points[static_cast<std::size_t>(i.node)] - chordae.points[static_cast<std::size_t>(point)]).norm());
    return largest;
  };
  EXPECT_LT(extent(c, c.segments[1].b), 0.75 * extent(plain, plain.segments[0].b));
  for (const ChordaSegment& s : c.segments) {
    const double initial = (c.points[static_cast<std::size_t>(s.a)] - c.points[static_cast<std::size_t>(s.b)]).norm();
    EXPECT_GE(s.rest_length, initial);
  }
}

TEST(GenericChordae, midline_chorda_hangs_on_both_muscles_by_half_the_area) {
  ChordaeOptions options;
  options.primary = 11;
  const Chordae c = make(options);
  std::map<int, std::vector<ChordaSegment>> by_end;
  for (const ChordaSegment& s : c.segments)
    by_end[s.b].push_back(s);
  int shared = 0;
  for (const auto& [end, segments] : by_end)
    if (segments.size() == 2) {
      ++shared;
      EXPECT_NE(segments[0].muscle, segments[1].muscle);
      EXPECT_DOUBLE_EQ(segments[0].area + segments[1].area, options.area_primary);
    }
  EXPECT_EQ(shared, 1);
}

TEST(GenericChordae, wrong_counts_and_inputs_are_refused) {
  ChordaeOptions options;
  options.primary = 3;
  EXPECT_THROW(make(options), ConfigError);
  options = {};
  options.removed = {22};
  EXPECT_THROW(make(options), ConfigError);
  options = {};
  options.slack = 0;
  EXPECT_THROW(make(options), ConfigError);
  options = {};
  options.primary = options.secondary = 0;
  EXPECT_TRUE(make(options).segments.empty());
  Papillary one = test::ring_papillary();
  one.tips.resize(1);
  EXPECT_THROW(generic_chordae(valve(), test::ring_annulus(), one, {}), InputError);
  EXPECT_THROW(LeafletChart(test::flat_patch(10, 10, 1)), InputError);
  EXPECT_THROW(LeafletChart(LeafletMesh{}), InputError);
}

}  // namespace
