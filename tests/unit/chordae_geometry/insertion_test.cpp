// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/chordae/insertion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "geometry/core/errors.h"
#include "support/grid_leaflet.h"

namespace {

using namespace mv;

Vec3 position(const LeafletMesh& m, int node) { return m.points[static_cast<std::size_t>(node)]; }

double total(const InfluenceSphere& s) {
  double sum = 0;
  for (const auto& w : s.weights)
    sum += w.second;
  return sum;
}

TEST(InfluenceSphere, total_force_and_moment_about_the_end_are_preserved) {
  const LeafletMesh mesh = test::flat_patch(20, 14, 0.5);
  const LeafletGraph graph(mesh);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> x(2, 18), y(1, 14), r(2, 5), shift(-0.3, 0.3), f(-1, 1);
  for (int trial = 0; trial < 30; ++trial) {
    const double radius = r(random);
    const Vec3 target(x(random), y(random), 0);
    const InfluenceSphere plain = influence_sphere(graph, target, radius);
    const Vec3 end = plain.end + Vec3(shift(random), shift(random), 0.3 * shift(random));
    const InfluenceSphere sphere = influence_sphere(graph, target, radius, end);
    EXPECT_NEAR(total(sphere), 1.0, 1e-13);
    EXPECT_LT((sphere.end - end).norm(), 1e-9);
    const Vec3 force(f(random), f(random), f(random));
    Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
    for (const auto& [node, w] : sphere.weights) {
      EXPECT_GT(w, 0);
      sum += w * force;
      moment += (position(mesh, node) - sphere.end).cross(w * force);
    }
    EXPECT_LT((sum - force).norm(), 1e-13);
    EXPECT_LT(moment.norm(), 1e-12);
  }
}

TEST(InfluenceSphere, holds_all_nodes_within_the_radius_on_both_faces_and_between) {
  const LeafletMesh mesh = test::flat_patch(20, 14, 0.5);
  const LeafletGraph graph(mesh);
  const Vec3 target(10, 7, 0);
  const InfluenceSphere sphere = influence_sphere(graph, target, 3.0);
  std::set<int> used;
  std::set<int> sides;
  for (const auto& w : sphere.weights) {
    used.insert(w.first);
    sides.insert(mesh.side[static_cast<std::size_t>(w.first)]);
  }
  EXPECT_EQ(sides, (std::set<int>{ventricular, between, atrial}));
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    const double d = (mesh.points[i] - target).norm();
    if (d < 0.97 * 3.0) {
      EXPECT_TRUE(used.count(static_cast<int>(i))) << d;
    }
    if (d >= 3.0) {
      EXPECT_FALSE(used.count(static_cast<int>(i))) << d;
    }
  }
}

TEST(InfluenceSphere, weight_over_volume_decreases_gradually_with_distance) {
  const LeafletMesh mesh = test::flat_patch(20, 14, 0.5);
  const LeafletGraph graph(mesh);
  const double radius = 4;
  const auto reached = graph.within(Vec3(10, 7, 0), radius);
  const InfluenceSphere sphere = influence_sphere(graph, Vec3(10, 7, 0), radius);
  std::map<int, double> weight(sphere.weights.begin(), sphere.weights.end());
  std::vector<std::pair<double, double>> profile;
  for (const auto& r : reached)
    profile.emplace_back(r.distance, weight[r.node] / graph.nodal_volume(r.node));
  std::sort(profile.begin(), profile.end());
  ASSERT_GT(profile.size(), 100u);
  const double peak = profile.front().second;
  for (std::size_t i = 1; i < profile.size(); ++i) {
    EXPECT_LE(profile[i].second, profile[i - 1].second * (1 + 1e-12) + 1e-12 * peak);
    const double s = 1 - std::pow(profile[i].first / radius, 2);
    const double s0 = 1 - std::pow(profile.front().first / radius, 2);
    EXPECT_NEAR(profile[i].second / peak, s * s / (s0 * s0), 1e-9);
  }
  EXPECT_LT(profile.back().second, 0.02 * peak);
}

TEST(InfluenceSphere, distance_along_the_leaflet_is_close_to_the_straight_one_on_a_flat_patch) {
  const LeafletMesh mesh = test::flat_patch(20, 20, 0.5);
  const LeafletGraph graph(mesh);
  const Vec3 target(10.1, 9.8, 0);
  const auto reached = graph.within(target, 8);
  ASSERT_GT(reached.size(), 1000u);
  for (const auto& r : reached) {
    const double exact = (position(mesh, r.node) - target).norm();
    EXPECT_GE(r.distance, exact - 1e-9);
    EXPECT_LE(r.distance, (exact > 6 * 0.5 ? 1.03 : 1.045) * exact + 1e-9);
  }
}

TEST(InfluenceSphere, distance_follows_a_bent_leaflet) {
  // Half cylinder of radius 2: opposite sides are 4 apart through space, pi 2 along the leaflet.
  test::GridSpec g;
  g.columns = 64;
  g.rows = 20;
  const double radius = 2;
  g.pattern = [](int i, int j) { return Vec2(i * 2 * std::numbers::pi / 64, 0.3 * j); };
  g.place = [=](Vec2 p, double w) {
    const double a = p.x() / radius;
    return Vec3((radius + 0.2 * w) * std::cos(a), (radius + 0.2 * w) * std::sin(a), p.y());
  };
  g.normal = [=](Vec2 p) { return Vec3(std::cos(p.x() / radius), std::sin(p.x() / radius), 0); };
  const LeafletMesh mesh = test::grid_leaflet(g);
  const LeafletGraph graph(mesh);
  const auto reached = graph.within(Vec3(radius, 0, 3), 7);
  double farthest = 0;
  for (const auto& r : reached)
    if (std::abs(mesh.unfolded[static_cast<std::size_t>(r.node)].y() - 3) < 1e-9 &&
        mesh.side[static_cast<std::size_t>(r.node)] == between)
      farthest = std::max(farthest, r.distance);
  // Through space the far side is 4 away. The shortest way through the thick wall follows its inner face, of radius 1.9.
  EXPECT_GT(farthest, 0.99 * std::numbers::pi * (radius - 0.1));
  EXPECT_LT(farthest, 1.03 * std::numbers::pi * radius);
}

TEST(InfluenceSphere, never_reaches_across_a_slit) {
  const double spacing = 0.5;
  const LeafletMesh mesh = test::slit_patch(20, 14, 4, spacing);
  const LeafletGraph graph(mesh);
  const InfluenceSphere sphere = influence_sphere(graph, Vec3(9.7, 12, 0), 5);
  for (const auto& w : sphere.weights)
    EXPECT_LT(position(mesh, w.first).x(), 10.0);
  // The other side is well within the radius in space, and reached round the bottom of the slit when the path is short enough.
  const auto near_floor = graph.within(Vec3(9.7, 5, 0), 5);
  const auto other =
      std::count_if(near_floor.begin(), near_floor.end(), [&](const auto& r) { return position(mesh, r.node).x() > 10.0; });
  EXPECT_GT(other, 20);
  for (const auto& r : near_floor)
    if (position(mesh, r.node).x() > 10.2 && position(mesh, r.node).y() > 4.5) {
      EXPECT_GT(r.distance, 0.9 * (5 - 4 + position(mesh, r.node).y() - 4));
    }
}

TEST(InfluenceSphere, quadratic_meshes_use_the_nodes_in_the_middle_of_edges) {
  const LeafletMesh linear = test::flat_patch(8, 8, 1.0);
  LeafletMesh mesh = linear;
  mesh.order = 2;
  std::map<std::pair<int, int>, int> middle;
  constexpr std::array<std::array<int, 2>, 6> edges{{{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};
  for (auto& tet : mesh.tets)
    for (std::size_t k = 0; k < 6; ++k) {
      const int a = tet[static_cast<std::size_t>(edges[k][0])], b = tet[static_cast<std::size_t>(edges[k][1])];
      const auto [it, is_new] = middle.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<int>(mesh.points.size()));
      if (is_new) {
        mesh.points.push_back(0.5 * (position(mesh, a) + position(mesh, b)));
        mesh.side.push_back(mesh.side[static_cast<std::size_t>(a)] == mesh.side[static_cast<std::size_t>(b)]
                                ? mesh.side[static_cast<std::size_t>(a)]
                                : 0);
      }
      tet[k + 4] = it->second;
    }
  const LeafletGraph graph(mesh);
  const InfluenceSphere sphere = influence_sphere(graph, Vec3(4, 4, 0), 2.5);
  const auto extra = std::count_if(sphere.weights.begin(), sphere.weights.end(),
                                   [&](const auto& w) { return w.first >= static_cast<int>(linear.points.size()); });
  EXPECT_GT(extra, 100);
  EXPECT_NEAR(total(sphere), 1, 1e-13);
  double volume = 0;
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    volume += graph.nodal_volume(static_cast<int>(i));
  EXPECT_NEAR(volume, 64.0, 1e-9);
}

TEST(InfluenceSphere, weights_stay_positive_when_the_end_is_moved_to_the_border) {
  const LeafletMesh mesh = test::flat_patch(20, 14, 0.5);
  const LeafletGraph graph(mesh);
  const Vec3 target(10, 14, 0);
  for (double inset : {0.1, 0.2, 0.3, 0.4}) {
    const InfluenceSphere sphere = influence_sphere(graph, target, 5, Vec3(target - Vec3(0, inset * 5, 0)));
    EXPECT_NEAR(sphere.end.y(), 14 - inset * 5, 1e-9);
    for (const auto& w : sphere.weights)
      EXPECT_GT(w.second, 0);
    EXPECT_GT(sphere.weights.size(), 100u);
  }
}

TEST(InfluenceSphere, refuses_empty_and_one_faced_spheres_and_ends_outside) {
  const LeafletMesh mesh = test::flat_patch(20, 14, 0.5);
  const LeafletGraph graph(mesh);
  EXPECT_THROW(influence_sphere(graph, Vec3(10, 7, 5), 3), InputError);      // no node
  EXPECT_THROW(influence_sphere(graph, Vec3(10, 7, 0.5), 0.6), InputError);  // atrial face and the middle only
  EXPECT_THROW(influence_sphere(graph, Vec3(10, 7, 0), 0), InputError);
  EXPECT_THROW(influence_sphere(graph, Vec3(10, 14, 0), 4, Vec3(10, 14.5, 0)), InputError);
  EXPECT_NO_THROW(influence_sphere(graph, Vec3(10, 7, 0.5), 1.3));
}

TEST(InfluenceRadius, is_half_the_border_share_unless_the_leaflet_is_low) {
  EXPECT_DOUBLE_EQ(influence_radius(140, 14, 20), 5.0);
  EXPECT_DOUBLE_EQ(influence_radius(140, 14, 6), 4.5);
}

TEST(CheckInsertions, finds_a_wrong_sum_a_wrong_place_and_a_missing_end) {
  const LeafletMesh mesh = test::flat_patch(20, 14, 0.5);
  const LeafletGraph graph(mesh);
  const InfluenceSphere sphere = influence_sphere(graph, Vec3(10, 10, 0), 3);
  Chordae good;
  good.points = {Vec3(10, 10, -20), sphere.end};
  good.muscle_of_point = {0, -1};
  good.segments.push_back({0, 1, ChordaKind::primary, 0, anterior, 20, 0.4});
  for (const auto& [node, w] : sphere.weights)
    good.insertions.push_back({1, node, w});
  EXPECT_TRUE(check_insertions(mesh, good).passed);
  Chordae bad = good;
  bad.insertions[3].weight *= 1.01;
  EXPECT_FALSE(check_insertions(mesh, bad).passed);
  bad = good;
  bad.points[1].x() += 1e-6;
  EXPECT_FALSE(check_insertions(mesh, bad).passed);
  EXPECT_EQ(check_insertions(mesh, bad).first_bad_point, 1);
  bad = good;
  bad.insertions.clear();
  EXPECT_FALSE(check_insertions(mesh, bad).passed);
  bad = good;
  bad.insertions[0].node = 1 << 20;
  EXPECT_FALSE(check_insertions(mesh, bad).passed);
}

}  // namespace
