// SPDX-License-Identifier: BSD-3-Clause
#include "solver/contact/candidates.h"
#include "solver/contact/leaf_frames.h"
#include "solver/contact/near_pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "solver/contact/contact_kernel.h"
#include "solver/contact/self_contact.h"
#include "unit/contact/shapes.h"

namespace mv::test {
namespace {

constexpr double mm = 1e-3;

/// A thick sheet, randomly deformed and folded over itself.
struct Crumpled {
  TetMesh mesh = tet_box(24, 12, 2, 12 * mm, 6 * mm, 1 * mm);
  ContactSurface surface = extract_contact_surface(mesh.x, mesh.tets, 1, mesh.side, ContactFaces::both);
  std::vector<double> x;

  explicit Crumpled(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> shake(-0.05 * mm, 0.05 * mm);
    const double radius = 1.5 * mm;
    x = mesh.mapped([&](const Vec3& p) -> Vec3 {
      const double straight = 4 * mm, u = p[0] - straight, arc = std::numbers::pi * radius;
      const double inner = radius - p[2] + 0.2 * mm;
      Vec3 q;
      if (u < 0)
        q = {p[0], p[1], p[2]};
      else if (u < arc)
        q = {straight + inner * std::sin(u / radius), p[1], radius + 0.2 * mm - inner * std::cos(u / radius)};
      else
        q = {straight - (u - arc), p[1], radius + 0.2 * mm + inner};
      return q + Vec3(shake(random), shake(random), shake(random));
    });
  }
  Vec3 at(int surface_node) const { return Eigen::Map<const Vec3>(x.data() + 3 * surface.nodes[surface_node]); }
};

double distance(const Crumpled& c, int node, int f) {
  const auto& t = c.surface.triangles[f];
  const auto head = contact::make_head(c.at(t[0]), c.at(t[1]), c.at(t[2]));
  const auto facet = contact::make_facet(c.at(t[0]), c.at(t[1]), c.at(t[2]), head.area2);
  const Vec3 d = c.at(node) - facet.a;
  const double height = head.n.dot(d);
  return std::sqrt(contact::project(facet, d).lateral_squared + height * height);
}

TEST(CandidateSearch, finds_every_triangle_in_reach_that_could_come_to_face_the_node) {
  Crumpled c(1);
  CandidateSearch search(c.surface, 1.5 * mm, 1.5 * mm);
  long expected = 0, listed = 0, left_out = 0;
  const double turn = 0.2;
  for (double radius : {0.3 * mm, 1.1 * mm, 3 * mm}) {
    search.update(c.x, radius, turn);
    for (int n = 0; n < c.surface.node_count(); ++n) {
      const std::vector<int> list = search.triangles_of(n);
      EXPECT_TRUE(std::is_sorted(list.begin(), list.end()));
      EXPECT_EQ(std::adjacent_find(list.begin(), list.end()), list.end());
      listed += static_cast<long>(list.size());
      for (int f : list) EXPECT_FALSE(search.is_excluded(n, f));
      for (int f = 0; f < c.surface.triangle_count(); ++f) {
        if (search.is_excluded(n, f) || distance(c, n, f) > radius) continue;
        if (!std::binary_search(list.begin(), list.end(), f)) {
          // Both normals may turn before they face each other at all.
          for (int r = c.surface.ring_start[n]; r < c.surface.ring_start[n + 1]; ++r)
            EXPECT_GE(search.normals()[f].dot(search.normals()[c.surface.ring[r]]), 2 * turn);
          ++left_out;
        }
        ++expected;
      }
    }
  }
  EXPECT_GT(expected, 10000);
  EXPECT_LT(listed, 3 * expected);
  EXPECT_GT(left_out, expected / 10);
}

TEST(SurfaceFrames, are_those_of_the_triangles_and_project_as_one_by_one) {
  Crumpled c(2);
  // One triangle without area.
  const auto& flat = c.surface.triangles[17];
  for (int k = 0; k < 3; ++k) c.x[3 * static_cast<std::size_t>(c.surface.nodes[flat[2]]) + static_cast<std::size_t>(k)] = c.x[3 * static_cast<std::size_t>(c.surface.nodes[flat[1]]) + static_cast<std::size_t>(k)];
  CandidateSearch search(c.surface, 1.5 * mm, 1.5 * mm);
  std::vector<double> radius;
  for (int f = 0; f < c.surface.triangle_count(); ++f) radius.push_back(1e-6 * (f % 100));
  SurfaceFrames frames(c.surface, search.tree(), radius);
  frames.update(c.x);
  const auto& tree = search.tree();
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(-1, 1);
  int found = 0, flat_ones = 0;
  for (int slot = 0; slot < tree.slot_count(); ++slot) {
    const int f = tree.item(slot);
    if (f < 0) continue;
    ++found;
    const auto& t = c.surface.triangles[f];
    const auto at = [&](int n) { return Vec3(Vec3::Map(c.x.data() + 3 * c.surface.nodes[n])); };
    const contact::FacetHead head = contact::make_head(at(t[0]), at(t[1]), at(t[2]));
    const std::size_t leaf = static_cast<std::size_t>(slot) / BoxTree::width, lane = static_cast<std::size_t>(slot) % BoxTree::width;
    if (head.area2 < 1e-9 * mm * mm) {  // what direction rounding leaves has no meaning
      ++flat_ones;
      EXPECT_LT(frames.normal(f).area2, 1e-9 * mm * mm);
      continue;
    }
    EXPECT_LE((frames.n(slot) - head.n).norm(), 1e-13);
    EXPECT_LE((frames.normal(f).n - head.n).norm(), 1e-13);
    EXPECT_NEAR(frames.normal(f).area2, head.area2, 1e-13 * head.area2);
    EXPECT_LE((frames.e1(slot) - (at(t[1]) - at(t[0]))).norm(), 0);
    EXPECT_LE((frames.e2(slot) - (at(t[2]) - at(t[0]))).norm(), 0);
    EXPECT_NEAR(frames.heads()[leaf].size[lane], head.size + radius[static_cast<std::size_t>(f)], 1e-6 * head.size);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(frames.heads()[leaf].centre[k][lane], head.centre[static_cast<int>(k)], 1e-7 * (mm + head.centre.norm()));
    const contact::Facet facet = contact::make_facet(at(t[0]), at(t[1]), at(t[2]), head.area2);
    const LeafFrames& l = frames.frames(static_cast<int>(leaf));
    const int first = static_cast<int>(lane) / lanes * lanes, here = static_cast<int>(lane) - first;
    const auto of = [&](const LeafFrames::Eight& v) { return load(v.data() + first); };
    const Vec3 d = 2 * mm * Vec3(u(random), u(random), u(random));
    Pack d1{}, d2{};
    for (int k = 0; k < 3; ++k) {
      d1 += of(l.e1[static_cast<std::size_t>(k)]) * d[k];
      d2 += of(l.e2[static_cast<std::size_t>(k)]) * d[k];
    }
    const auto side_by_side = contact::project(of(l.g11), of(l.g12), of(l.g22), of(l.inverse_det), d1, d2);
    const auto alone = contact::project(facet, d);
    const double roundoff = 1e-10 * (1 + std::abs(alone.l1) + std::abs(alone.l2));
    EXPECT_NEAR(side_by_side.l1[here], alone.l1, roundoff);
    EXPECT_NEAR(side_by_side.l2[here], alone.l2, roundoff);
    EXPECT_NEAR(side_by_side.lateral_squared[here], alone.lateral_squared, 1e-9 * d.squaredNorm());
  }
  EXPECT_EQ(found, c.surface.triangle_count());
  EXPECT_GE(flat_ones, 1);
}

TEST(NearPairs, keep_all_that_is_seen_until_something_has_moved_too_far) {
  Crumpled c(1);
  CandidateSearch search(c.surface, 1.5 * mm, 1.5 * mm);
  search.update(c.x, 3 * mm, 0.2);
  const SightLimits limits{0.5 * mm, 0.9 * mm, 0.5};
  const double skin = 0.2 * mm, turn = 0.3, averaging = 0.2 * mm;
  const auto heads_of = [&](const std::vector<double>& x) {
    std::vector<contact::FacetHead> heads;
    const auto at = [&](int n) { return Vec3(Vec3::Map(x.data() + 3 * c.surface.nodes[n])); };
    for (const auto& t : c.surface.triangles) {
      heads.push_back(contact::make_head(at(t[0]), at(t[1]), at(t[2])));
      heads.back().size += averaging;
    }
    return heads;
  };
  const auto heads = heads_of(c.x);
  NearPairs near;
  std::vector<LeafHeads> leaves;
  gather_leaf_heads(search.tree(), [&](int f) { return &heads[static_cast<std::size_t>(f)]; }, leaves);
  near.update(c.surface, search, leaves, c.x, limits, 1e-6F * static_cast<float>(mm), skin, turn);
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  long seen = 0, new_in_sight = 0, listed = 0, left_out = 0;
  const auto sees = [&](const Vec3& p, const contact::FacetHead& head) {
    const Vec3 d = p - head.centre;
    const double height = head.n.dot(d), far = head.size + limits.widening * std::abs(height);
    return height > -limits.depth && height < limits.height && d.squaredNorm() - height * height <= far * far;
  };
  for (int trial = 0; trial < 20; ++trial) {
    auto x = c.x;
    for (std::size_t a = 0; a < x.size(); a += 3) {
      const Vec3 direction = Vec3(normal(random), normal(random), normal(random)).normalized();
      Vec3::Map(x.data() + a) += 0.499 * skin * direction;
    }
    const auto now = heads_of(x);
    for (int n = 0; n < c.surface.node_count(); ++n) {
      const auto list = near.triangles_of(n);
      if (trial == 0) listed += static_cast<long>(list.size());
      for (int f : search.triangles_of(n)) {
        const bool is_listed = std::binary_search(list.begin(), list.end(), f);
        left_out += trial == 0 && !is_listed;
        if (!((now[f].n - heads[f].n).norm() <= turn) || !sees(Vec3::Map(x.data() + 3 * c.surface.nodes[n]), now[f])) continue;
        EXPECT_TRUE(is_listed);
        ++seen;
        new_in_sight += !sees(c.at(n), heads[f]);
      }
    }
  }
  EXPECT_GT(seen, 10000);
  EXPECT_GT(new_in_sight, 500);  // what no list without margins would hold
  EXPECT_GT(left_out, listed / 4);
}

TEST(CandidateSearch, closest_point_agrees_with_dense_sampling) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int trial = 0; trial < 300; ++trial) {
    std::array<Vec3, 4> p;
    for (auto& q : p) q = Vec3(u(random), u(random), u(random));
    const auto head = contact::make_head(p[0], p[1], p[2]);
    const auto facet = contact::make_facet(p[0], p[1], p[2], head.area2);
    const auto q = contact::project(facet, p[3] - p[0]);
    const Vec3 foot = p[0] + q.l1 * facet.e1 + q.l2 * facet.e2, closest = p[0] + q.b1 * facet.e1 + q.b2 * facet.e2;
    EXPECT_NEAR(head.n.dot(foot - p[3]), -head.n.dot(p[3] - p[0]), 1e-12);
    EXPECT_NEAR((foot - p[3]).cross(head.n).norm(), 0, 1e-9);
    EXPECT_NEAR((foot - closest).squaredNorm(), q.lateral_squared, 1e-10 * (1 + (foot - closest).squaredNorm()));
    double best = std::numeric_limits<double>::infinity();
    constexpr int samples = 60;
    for (int i = 0; i <= samples; ++i) {
      for (int j = 0; i + j <= samples; ++j)
        best = std::min(best, (p[3] - p[0] - (i * facet.e1 + j * facet.e2) / samples).norm());
    }
    const double found = (p[3] - closest).norm();
    EXPECT_LE(found, best + 1e-12);
    EXPECT_GE(found, best - 3.0 / samples);
  }
}

TEST(CandidateSearch, excludes_neighbours_and_the_back_face_but_not_separate_pieces) {
  // Two thick sheets side by side at rest, 0.3 mm apart: nothing of one excludes the other, although it is near.
  TetMesh a = tet_box(6, 6, 2, 3 * mm, 3 * mm, 1 * mm);
  const TetMesh b = a;
  const int offset = static_cast<int>(a.x.size() / 3), elements = static_cast<int>(a.tets.size());
  for (std::size_t n = 0; n < b.side.size(); ++n) {
    const Vec3 p = b.point(static_cast<int>(n)) + Vec3(3.3 * mm, 0, 0);
    a.x.insert(a.x.end(), {p[0], p[1], p[2]});
    a.side.push_back(b.side[n]);
  }
  for (auto t : b.tets) {
    for (int k = 0; k < 4; ++k) t[k] += offset;
    a.tets.push_back(t);
  }
  ASSERT_EQ(static_cast<int>(a.tets.size()), 2 * elements);
  const auto s = extract_contact_surface(a.x, a.tets, 1, a.side, ContactFaces::both);
  const double radius = 1.5 * mm;
  CandidateSearch search(s, radius, radius);
  int through = 0, own = 0, other = 0;
  for (int n = 0; n < s.node_count(); ++n) {
    for (int f = 0; f < s.triangle_count(); ++f) {
      const auto& t = s.triangles[f];
      const Vec3 centre = (s.reference[t[0]] + s.reference[t[1]] + s.reference[t[2]]) / 3;
      const bool near = (centre - s.reference[n]).norm() < 0.999 * radius;
      const bool same = (s.nodes[n] < offset) == (s.nodes[t[0]] < offset);
      if ((centre - s.reference[n]).norm() > 1.001 * radius) {
        EXPECT_FALSE(search.is_excluded(n, f));
      }
      if (near && same) {
        EXPECT_TRUE(search.is_excluded(n, f));
        (std::abs(centre[2] - s.reference[n][2]) > 0.9 * mm ? through : own)++;
      }
      if (near && !same) {
        EXPECT_FALSE(search.is_excluded(n, f));
        ++other;
      }
    }
  }
  EXPECT_GT(through, 1000);
  EXPECT_GT(own, 1000);
  EXPECT_GT(other, 100);
}

TEST(ClosestGaps, agree_with_brute_force) {
  Crumpled c(3);
  ContactOptions options;
  SelfContact contact(c.surface, options);
  CandidateSearch rule(c.surface, contact.options().exclusion_radius, contact.options().exclusion_radius_through);
  std::vector<Vec3> normals(c.surface.nodes.size());
  current_node_normals(c.surface, c.x, normals);
  for (bool atrial_only : {false, true}) {
    for (double reach : {1.6 * mm, 4 * mm}) {
      ClosestGaps gaps;
      contact.closest_gaps(c.x, reach, atrial_only, gaps);
      int found = 0;
      for (int n = 0; n < c.surface.node_count(); ++n) {
        double best = reach;
        for (int f = 0; f < c.surface.triangle_count(); ++f) {
          if (atrial_only && (c.surface.triangle_side[f] != 1 || !c.surface.on_atrial_face[n])) continue;
          const auto& t = c.surface.triangles[f];
          const auto head = contact::make_head(c.at(t[0]), c.at(t[1]), c.at(t[2]));
          if (head.n.dot(normals[n]) >= facing_cosine ||
              head.n.dot(c.at(n) - head.centre) <= -contact.options().penetration_limit)
            continue;
          if (!rule.is_excluded(n, f)) best = std::min(best, distance(c, n, f));
        }
        if (best < reach) {
          EXPECT_NEAR(std::abs(gaps.gap[n]), best, 1e-12);
          EXPECT_NEAR((gaps.point[n] - c.at(n)).norm(), best, 1e-12);
          EXPECT_GE(gaps.triangle[n], 0);
          ++found;
        } else {
          EXPECT_EQ(gaps.triangle[n], -1);
          EXPECT_TRUE(std::isinf(gaps.gap[n]));
        }
      }
      EXPECT_GT(found, 50);
    }
  }
}

}  // namespace
}  // namespace mv::test
