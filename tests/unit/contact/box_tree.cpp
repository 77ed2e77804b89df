// SPDX-License-Identifier: BSD-3-Clause
#include "solver/contact/box_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "geometry/core/parallel.h"

namespace mv::test {
namespace {

using Vec3 = Eigen::Vector3d;
using Box = BoxTree::Box;

struct Cloud {
  std::vector<Vec3> points, normals;
  std::vector<Box> boxes;

  Cloud(int count, unsigned seed, double scale) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-1, 1);
    const auto vector = [&] { return Vec3(unit(random), unit(random), unit(random)); };
    for (int i = 0; i < count; ++i) {
      points.push_back(scale * vector());
      normals.push_back(i % 17 == 0 ? Vec3(Vec3::Zero()) : Vec3(vector().normalized()));
      // Elsewhere than at rest: the tree may be slow then, never wrong.
      const Eigen::Array3f centre = (Vec3(points.back()[1], points.back()[0], 0.3 * points.back()[2]) + 0.2 * scale * vector()).cast<float>().array();
      const Eigen::Array3f half = (0.05 * scale * vector()).cwiseAbs().cast<float>().array();
      boxes.push_back({centre - half, centre + half});
    }
  }
};

bool overlap(const Box& a, const Box& b) { return (a.lower <= b.upper).all() && (a.upper >= b.lower).all(); }

TEST(BoxTree, finds_what_comparing_all_finds) {
  for (int count : {1, 7, 8, 9, 63, 64, 65, 513, 5000}) {
    const Cloud cloud(count, 3, 0.02);
    BoxTree tree(cloud.points, cloud.normals, 0.01);
    tree.fit([&](int i) { return cloud.boxes[static_cast<std::size_t>(i)]; });
    ASSERT_EQ(tree.leaf_count(), (count + 7) / 8);
    std::vector<int> times(static_cast<std::size_t>(count), 0);
    for (int slot = 0; slot < tree.slot_count(); ++slot)
      if (tree.item(slot) >= 0) ++times[static_cast<std::size_t>(tree.item(slot))];
    EXPECT_EQ(std::count(times.begin(), times.end(), 1), count);
    for (int q = 0; q < std::min(count, 40); ++q) {
      const Box& query = cloud.boxes[static_cast<std::size_t>(q)];
      for (int first : {0, tree.leaf_count() / 3, tree.leaf_count() - 1}) {
        std::vector<int> expected, found;
        for (int slot = first * BoxTree::width; slot < tree.slot_count(); ++slot)
          if (tree.item(slot) >= 0 && overlap(cloud.boxes[static_cast<std::size_t>(tree.item(slot))], query)) expected.push_back(slot);
        int last_leaf = -1;
        tree.for_leaves(query, first, [&](int leaf) {
          EXPECT_GT(leaf, last_leaf);
          last_leaf = leaf;
          EXPECT_TRUE(overlap(tree.leaf_box(leaf), query));
          for (int lane = 0; lane < BoxTree::width; ++lane)
            if (tree.overlapping(leaf, query) >> lane & 1U) found.push_back(leaf * BoxTree::width + lane);
        });
        EXPECT_EQ(found, expected) << count << " items, query " << q << ", first leaf " << first;
      }
    }
  }
}

TEST(BoxTree, leaves_keep_to_one_face_of_a_thin_sheet) {
  // Two faces of a sheet, 0.4 apart, points 1 apart: by distance alone a leaf would take from both.
  std::vector<Vec3> points, normals;
  for (int side : {-1, 1})
    for (int i = 0; i < 32; ++i)
      for (int j = 0; j < 32; ++j) {
        points.emplace_back(i, j, 0.2 * side);
        normals.emplace_back(0, 0, side);
      }
  const auto mixed = [&](double length) {
    const BoxTree tree(points, normals, length);
    int count = 0;
    for (int leaf = 0; leaf < tree.leaf_count(); ++leaf)
      for (int lane = 1; lane < BoxTree::width; ++lane) count += normals[static_cast<std::size_t>(tree.item(8 * leaf + lane))] != normals[static_cast<std::size_t>(tree.item(8 * leaf))];
    return count;
  };
  EXPECT_EQ(mixed(2), 0);
  EXPECT_GT(mixed(0), 100);
}

TEST(BoxTree, visits_few_leaves_where_items_have_kept_their_neighbours) {
  std::vector<Vec3> points;
  for (int i = 0; i < 64; ++i)
    for (int j = 0; j < 64; ++j) points.emplace_back(i, j, 0);
  const std::vector<Vec3> normals(points.size(), Vec3(0, 0, 1));
  BoxTree tree(points, normals, 2);
  // Rolled up.
  tree.fit([&](int i) {
    const Vec3& p = points[static_cast<std::size_t>(i)];
    const Eigen::Array3f c(static_cast<float>(20 * std::sin(p[0] / 20)), static_cast<float>(p[1]), static_cast<float>(20 * std::cos(p[0] / 20)));
    return Box{c - 0.5F, c + 0.5F};
  });
  long visited = 0;
  for (int leaf = 0; leaf < tree.leaf_count(); ++leaf) tree.for_leaves(tree.leaf_box(leaf), 0, [&](int) { ++visited; });
  std::printf("%ld leaves visited for %d\n", visited, tree.leaf_count());
  EXPECT_LT(visited, 14L * tree.leaf_count());
}

TEST(BoxTree, nothing_depends_on_the_thread_count) {
  const Cloud cloud(3000, 5, 1);
  const int before = thread_count();
  std::vector<std::vector<int>> answers;
  for (int threads : {1, 2, 3}) {
    set_thread_count(threads);
    BoxTree tree(cloud.points, cloud.normals, 0.5);
    tree.fit([&](int i) { return cloud.boxes[static_cast<std::size_t>(i)]; });
    answers.emplace_back();
    for (int slot = 0; slot < tree.slot_count(); ++slot) answers.back().push_back(tree.item(slot));
    for (const Box& query : cloud.boxes) tree.for_leaves(query, 0, [&](int leaf) { answers.back().push_back(leaf); });
  }
  set_thread_count(before);
  EXPECT_EQ(answers[0], answers[1]);
  EXPECT_EQ(answers[0], answers[2]);
}

}  // namespace
}  // namespace mv::test
