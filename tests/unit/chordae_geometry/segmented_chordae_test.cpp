// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/chordae/segmented_chordae.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/chordae/insertion.h"
#include "geometry/chordae/leaflet_chart.h"
#include "geometry/chordae/leaflet_probe.h"
#include "geometry/core/errors.h"
#include "support/grid_leaflet.h"

namespace {

using namespace mv;
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

const LeafletMesh& valve() {
  static const LeafletMesh mesh = test::ring_valve();
  return mesh;
}
const LeafletChart& chart() {
  static const LeafletChart c(valve());
  return c;
}
Vec3 on_leaflet(double u, double share) { return chart().at({u, share * chart().height(u)}).position; }

struct Net {
  RawChordae raw;
  int point(const Vec3& x) {
    raw.points.push_back(x);
    raw.is_root.push_back(0);
    raw.is_leaflet_end.push_back(0);
    return static_cast<int>(raw.points.size()) - 1;
  }
  void line(int a, int b, double area = unknown) {
    raw.segments.push_back({a, b});
    raw.area.push_back(area);
    raw.rest_length.push_back(unknown);
    raw.kind.push_back(-1);
  }
};

// Root on the first tip, a branch point, two ends on the anterior border, one end in the anterior belly by a chorda of its own.
struct Y : Net {
  int root = point(Vec3(10, -2, -32)), branch = point(Vec3(9, 4, -26)), left = point(on_leaflet(24, 1.0)), right = point(on_leaflet(27, 1.0)), belly = point(on_leaflet(24, 0.55));
  Y() {
    line(left, branch, 0.2);
    line(branch, root, 0.4);
    line(branch, right, 0.2);
    line(root, belly, 1.0);
  }
};

Chordae attach(const RawChordae& raw, SegmentedOptions options = {}, SegmentedReport* report = nullptr) {
  if (!options.radius) options.radius = 3.0;
  return attach_chordae(valve(), test::ring_papillary(), {}, raw, options, report);
}

double reach(const Chordae& c, int point) {
  double far = 0;
  for (const Insertion& i : c.insertions)
    if (i.point == point) far = std::max(far, (valve().points[static_cast<std::size_t>(i.node)] - c.points[static_cast<std::size_t>(point)]).norm());
  return far;
}

std::string refusal(const RawChordae& raw, const SegmentedOptions& options = {}) {
  try {
    attach(raw, options);
  } catch (const InputError& e) {
    std::cout << e.what() << "\n";
    return e.what();
  }
  return "accepted";
}

TEST(SegmentedChordae, a_tree_stays_a_tree_with_its_lengths) {
  const Y y;
  SegmentedReport report;
  const Chordae c = attach(y.raw, {}, &report);
  EXPECT_EQ(report.roots, 1);
  EXPECT_EQ(report.ends, 3);
  EXPECT_EQ(report.branch_points, 1);
  EXPECT_EQ(report.loops, 0);
  ASSERT_EQ(c.segments.size(), 4u);
  EXPECT_TRUE(check_insertions(valve(), c).passed);
  for (std::size_t s = 0; s < 4; ++s) {
    const ChordaSegment& segment = c.segments[s];
    EXPECT_EQ(segment.muscle, 0);
    EXPECT_EQ(segment.leaflet, anterior);
    EXPECT_GE(segment.rest_length, (c.points[static_cast<std::size_t>(segment.a)] - c.points[static_cast<std::size_t>(segment.b)]).norm() - 1e-9);
  }
  // By their areas: trunk, branches, strut.
  const auto of_area = [&](double area) { return *std::find_if(c.segments.begin(), c.segments.end(), [&](const ChordaSegment& s) { return s.area == area; }); };
  EXPECT_EQ(of_area(0.4).kind, ChordaKind::primary);
  EXPECT_EQ(of_area(0.2).kind, ChordaKind::primary);
  EXPECT_EQ(of_area(1.0).kind, ChordaKind::strut);
  EXPECT_EQ(c.muscle_of_point[static_cast<std::size_t>(of_area(0.4).a)], 0);
  EXPECT_EQ(of_area(0.2).a, of_area(0.4).b);
  EXPECT_NEAR(of_area(0.4).rest_length, (y.raw.points[0] - y.raw.points[1]).norm(), 1e-12);
}

TEST(SegmentedChordae, spheres_have_R_without_and_half_R_with_a_branch) {
  const Chordae c = attach(Y().raw);
  for (const ChordaSegment& s : c.segments) {
    if (s.area == 1.0) {
      EXPECT_GT(reach(c, s.b), 2.4);
      EXPECT_LT(reach(c, s.b), 3.0);
    }
    if (s.area == 0.2) {
      EXPECT_LT(reach(c, s.b), 1.7);
    }
  }
}

TEST(SegmentedChordae, a_curved_run_becomes_one_segment_of_its_length_and_stiffness) {
  Net net;
  const Vec3 tip(-10, -2, -32), end = on_leaflet(10, 1.0);
  const int root = net.point(tip);
  int last = root;
  double length = 0, flexibility = 0;
  for (int k = 1; k <= 8; ++k) {
    const double t = k / 8.0;
    const int next = net.point(tip + t * (end - tip) + (k < 8 ? 2 * std::sin(t * 3.14) : 0.0) * Vec3::UnitX());
    const double area = k % 2 ? 0.2 : 0.8, piece = (net.raw.points.back() - net.raw.points[static_cast<std::size_t>(last)]).norm();
    length += piece;
    flexibility += piece / area;
    net.line(last, next, area);
    last = next;
  }
  const Chordae merged = attach(net.raw);
  ASSERT_EQ(merged.segments.size(), 1u);
  EXPECT_NEAR(merged.segments[0].rest_length, length, 1e-9);
  EXPECT_NEAR(merged.segments[0].area, length / flexibility, 1e-12);
  EXPECT_EQ(merged.segments[0].muscle, 1);
  EXPECT_GT(length, 1.005 * (end - tip).norm());
  SegmentedOptions slack;
  slack.slack = 1.1;
  EXPECT_NEAR(attach(net.raw, slack).segments[0].rest_length, 1.1 * length, 1e-9);
  SegmentedOptions whole;
  whole.merge_runs = false;
  EXPECT_EQ(attach(net.raw, whole).segments.size(), 8u);
}

TEST(SegmentedChordae, roots_stay_where_they_were_segmented_and_take_the_nearest_head) {
  Y y;
  y.raw.points[0] += Vec3(3, 0, 0);
  const Chordae c = attach(y.raw);
  const auto root = std::find(c.muscle_of_point.begin(), c.muscle_of_point.end(), 0) - c.muscle_of_point.begin();
  EXPECT_EQ(c.points[static_cast<std::size_t>(root)], Vec3(13, -2, -32));
}

TEST(SegmentedChordae, kinds_follow_the_place_of_the_end) {
  Net net;
  const int root = net.point(Vec3(10, -2, -32));
  net.line(root, net.point(on_leaflet(20, 0.98)), 0.3);
  net.line(root, net.point(on_leaflet(20, 0.5)), 0.3);
  net.line(root, net.point(on_leaflet(21, 0.15)), 0.3);
  net.line(root, net.point(on_leaflet(71.6, 0.5)), 0.9);
  SegmentedOptions options;
  options.radius = 2.0;
  const Chordae c = attach(net.raw, options);
  ASSERT_EQ(c.segments.size(), 4u);
  EXPECT_EQ(c.segments[0].kind, ChordaKind::primary);
  EXPECT_EQ(c.segments[1].kind, ChordaKind::secondary);
  EXPECT_EQ(c.segments[2].kind, ChordaKind::basal);
  EXPECT_EQ(c.segments[3].kind, ChordaKind::secondary);  // thick, but posterior
  EXPECT_EQ(c.segments[3].leaflet, posterior);
}

TEST(SegmentedChordae, gaps_are_joined_and_larger_ones_refused_or_dropped) {
  Y y;
  const int a = y.point(Vec3(5, 5, -20)), b = y.point(on_leaflet(20, 1.0)), c = y.point(Vec3(8.5, 4, -26));
  y.line(b, a);
  y.line(a, c);  // ends 0.5 mm from the branch point
  SegmentedReport report;
  EXPECT_EQ(attach(y.raw, {}, &report).segments.size(), 5u);
  EXPECT_EQ(report.joined_gaps, 1);
  y.raw.points[static_cast<std::size_t>(c)] = Vec3(0, 4, -12);
  EXPECT_NE(refusal(y.raw).find("chordae.file_defects"), std::string::npos);
  SegmentedOptions drop;
  drop.defects = NetworkDefects::drop;
  SegmentedReport dropped;
  EXPECT_EQ(attach(y.raw, drop, &dropped).segments.size(), 4u);
  EXPECT_EQ(dropped.dropped_segments, 2);
}

TEST(SegmentedChordae, loops_are_counted_and_refused_on_request) {
  Y y;
  const int a = y.point(Vec3(9, 0, -29)), b = y.point(Vec3(9.5, 2, -28));
  y.raw.segments[1] = {y.branch, a};
  y.line(a, y.root);
  y.line(a, b);
  y.line(b, y.branch);
  SegmentedReport report;
  attach(y.raw, {}, &report);
  EXPECT_EQ(report.loops, 1);
  SegmentedOptions refuse;
  refuse.refuse_loops = true;
  EXPECT_NE(refusal(y.raw, refuse).find("1 loops"), std::string::npos);
}

TEST(SegmentedChordae, defects_are_refused_with_place_and_remedy) {
  Net rootless;
  const int middle = rootless.point(Vec3(0, 5, -13));
  rootless.line(rootless.point(on_leaflet(16, 1.0)), middle);
  rootless.line(rootless.point(on_leaflet(24, 1.0)), middle);
  EXPECT_NE(refusal(rootless.raw).find("has no root"), std::string::npos);

  Y floating;
  floating.line(floating.point(on_leaflet(50, 1.0)), floating.point(Vec3(0, 0, -12)));
  EXPECT_NE(refusal(floating.raw).find("chordae.gap"), std::string::npos);

  Y far;
  far.raw.points[static_cast<std::size_t>(far.left)] += Vec3(0, 8, 0);
  EXPECT_NE(refusal(far.raw).find("chordae.end_reach"), std::string::npos);

  Y said;
  said.raw.is_leaflet_end[static_cast<std::size_t>(said.left)] = 1;
  said.raw.points[static_cast<std::size_t>(said.left)] += Vec3(0, 8, 0);
  EXPECT_NE(refusal(said.raw).find("leaflet end at"), std::string::npos);

  Y root;
  root.raw.is_root[0] = 1;
  root.raw.points[0] = Vec3(40, 0, -40);
  EXPECT_NE(refusal(root.raw).find("chordae.root_reach"), std::string::npos);

  Y metres;
  for (Vec3& x : metres.raw.points) x *= 1e-3;
  EXPECT_NE(refusal(metres.raw).find("chordae.file_unit"), std::string::npos);
}

TEST(LeafletProbe, knows_places_and_what_passes_through) {
  const LeafletProbe probe(valve());
  const auto place = probe.nearest(on_leaflet(18, 0.5) + 0.4 * Vec3::UnitY());
  EXPECT_NEAR(place.thickness, 1, 0.02);
  EXPECT_LT((place.position - on_leaflet(18, 0.5)).norm(), 0.45);
  EXPECT_EQ(place.region, anterior);
  // From inside the cone straight out through the wall, and along its axis.
  EXPECT_TRUE(probe.crossing(Vec3(0, 0, -5), Vec3(0, 30, -5), 0.1).has_value());
  EXPECT_FALSE(probe.crossing(Vec3(0, 0, -30), Vec3(0, 0, 10), 0.1).has_value());
  EXPECT_FALSE(probe.crossing(Vec3(0, 0, -5), on_leaflet(18, 0.4), 1.5).has_value());
}

}  // namespace
