// SPDX-License-Identifier: BSD-3-Clause
#include "solver/time/stress_areas.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "support/grid_leaflet.h"

namespace mv {
namespace {

double mean_u(const LeafletMesh& mesh, const std::vector<int>& elements) {
  double sum = 0;
  for (int e : elements) sum += mesh.unfolded[static_cast<std::size_t>(mesh.tets[static_cast<std::size_t>(e)][0])].x();
  return sum / static_cast<double>(elements.size());
}

TEST(StressAreas, of_a_flat_leaflet_are_the_stated_shares) {
  const double width = 30, height = 20;
  const LeafletMesh mesh = test::flat_patch(width, height, 0.5);
  const StressAreas areas = find_stress_areas(mesh, {});
  const double all = static_cast<double>(mesh.tets.size());
  EXPECT_NEAR(static_cast<double>(areas.belly.size()) / all, 0.35 / 3, 0.01);
  EXPECT_NEAR(static_cast<double>(areas.trigone[0].size()) / all, 0.15 * 0.22, 0.005);
  EXPECT_NEAR(static_cast<double>(areas.trigone[1].size()) / all, 0.15 * 0.22, 0.005);
  EXPECT_NEAR(mean_u(mesh, areas.belly), 15, 0.3);
  EXPECT_NEAR(mean_u(mesh, areas.trigone[0]), 0.125 * width, 0.3);
  EXPECT_NEAR(mean_u(mesh, areas.trigone[1]), 0.875 * width, 0.3);
  // The papillary tips name the trigones: the first is the one on tip 0's side.
  const StressAreas turned = find_stress_areas(mesh, {Vec3(30, 0, -20), Vec3(0, 0, -20)});
  EXPECT_EQ(turned.trigone[0], areas.trigone[1]);
}

TEST(StressAreas, lie_on_the_anterior_leaflet_although_it_crosses_the_patterns_seam) {
  test::RingSpec ring;
  LeafletMesh mesh = test::ring_valve(ring);
  const StressAreas straight = find_stress_areas(mesh, test::ring_papillary().tips);
  ASSERT_GT(straight.belly.size(), 50u);
  ASSERT_GT(straight.trigone[0].size(), 10u);
  for (int e : straight.belly) EXPECT_EQ(mesh.region[static_cast<std::size_t>(e)], anterior);
  EXPECT_NEAR(mean_u(mesh, straight.belly), ring.anterior_radius, 0.5);
  // The same valve unrolled from the middle of the anterior leaflet.
  for (Vec2& uv : mesh.unfolded) uv.x() = std::fmod(uv.x() - ring.anterior_radius + 2 * ring.perimeter, ring.perimeter);
  const StressAreas shifted = find_stress_areas(mesh, test::ring_papillary().tips);
  const auto as_set = [](const std::vector<int>& v) { return std::set<int>(v.begin(), v.end()); };
  auto common = [&](const std::vector<int>& a, const std::vector<int>& b) {
    const auto sa = as_set(a);
    double count = 0;
    for (int e : b) count += sa.count(e);
    return count / static_cast<double>(std::max(a.size(), b.size()));
  };
  EXPECT_GT(common(straight.belly, shifted.belly), 0.98);
  EXPECT_GT(common(straight.trigone[0], shifted.trigone[0]), 0.95);
  EXPECT_GT(common(straight.trigone[1], shifted.trigone[1]), 0.95);
}

TEST(StressAreas, mean_is_weighted_by_volume_and_nan_without_elements) {
  const LeafletMesh mesh = test::flat_patch(4, 4, 1);
  std::vector<double> values(mesh.tets.size(), 3.0);
  EXPECT_DOUBLE_EQ(mean_over(mesh, {0, 1, 2}, values), 3);
  EXPECT_TRUE(std::isnan(mean_over(mesh, {}, values)));
  EXPECT_TRUE(find_stress_areas(LeafletMesh(), {}).belly.empty());
}

}  // namespace
}  // namespace mv
