// SPDX-License-Identifier: BSD-3-Clause
#include "solver/contact/surface.h"

#include <gtest/gtest.h>

#include <map>
#include <numeric>

#include "geometry/core/errors.h"
#include "unit/contact/shapes.h"

namespace mv::test {
namespace {

TetMesh quadratic_mesh(TetMesh m) {
  const int edge[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};
  std::map<std::pair<int, int>, int> mid;
  for (auto& t : m.tets) {
    for (int e = 0; e < 6; ++e) {
      const auto key = std::minmax(t[edge[e][0]], t[edge[e][1]]);
      auto found = mid.find(key);
      if (found == mid.end()) {
        const Vec3 p = 0.5 * (m.point(key.first) + m.point(key.second));
        found = mid.emplace(key, static_cast<int>(m.x.size() / 3)).first;
        m.x.insert(m.x.end(), {p[0], p[1], p[2]});
        m.side.push_back(m.side[key.first] == m.side[key.second] ? m.side[key.first] : 0);
      }
      t[4 + e] = found->second;
    }
  }
  return m;
}

double enclosed_volume(const ContactSurface& s) {
  double six = 0;
  for (const auto& t : s.triangles) six += s.reference[t[0]].dot(s.reference[t[1]].cross(s.reference[t[2]]));
  return six / 6;
}

double total_area(const ContactSurface& s) { return std::accumulate(s.reference_area.begin(), s.reference_area.end(), 0.0); }

TEST(ContactSurface, boundary_of_a_box_is_closed_outward_and_complete) {
  TetMesh m = tet_box(4, 3, 2, 2e-3, 1.5e-3, 1e-3);
  for (std::size_t k = 0; k < m.tets.size(); k += 3)
    std::swap(m.tets[k][0], m.tets[k][1]);  // element orientation must not matter
  const auto s = extract_contact_surface(m.x, m.tets, 1, m.side, ContactFaces::both);
  EXPECT_EQ(s.triangle_count(), 2 * 2 * (4 * 3 + 4 * 2 + 3 * 2));
  EXPECT_NEAR(enclosed_volume(s), 3e-9, 1e-20);
  // The border's nodes belong to the faces: of the rim only the share of its middle nodes is counted.
  double top = 0, bottom = 0, rim = 0;
  for (int n = 0; n < s.node_count(); ++n)
    (s.node_side[n] > 0 ? top : (s.node_side[n] < 0 ? bottom : rim)) += s.reference_area[n];
  EXPECT_NEAR(top, 3e-6, 1e-16);
  EXPECT_NEAR(bottom, 3e-6, 1e-16);
  EXPECT_NEAR(rim, 0.5 * 7e-6, 1e-16);
  std::map<std::pair<int, int>, int> half_edges;
  for (const auto& t : s.triangles) {
    for (int k = 0; k < 3; ++k) ++half_edges[{t[k], t[(k + 1) % 3]}];
  }
  for (const auto& [edge, count] : half_edges) {
    EXPECT_EQ(count, 1);
    EXPECT_EQ(half_edges.count({edge.second, edge.first}), 1u);
  }
  for (int n = 0; n < s.node_count(); ++n) {
    for (int r = s.ring_start[n]; r < s.ring_start[n + 1]; ++r) {
      const auto& t = s.triangles[s.ring[r]];
      EXPECT_TRUE(t[0] == n || t[1] == n || t[2] == n);
    }
  }
}

TEST(ContactSurface, inner_face_is_the_atrial_face_only) {
  const TetMesh m = tet_box(4, 3, 2, 2e-3, 1.5e-3, 1e-3);
  const auto s = extract_contact_surface(m.x, m.tets, 1, m.side, ContactFaces::inner);
  EXPECT_EQ(s.triangle_count(), 2 * 4 * 3);
  EXPECT_NEAR(total_area(s), 3e-6, 1e-18);
  for (const auto& t : s.triangles) {
    const Vec3 normal = (s.reference[t[1]] - s.reference[t[0]]).cross(s.reference[t[2]] - s.reference[t[0]]).normalized();
    EXPECT_NEAR(normal[2], 1.0, 1e-12);
  }
  for (int n : s.nodes) EXPECT_EQ(m.side[n], 1);
}

TEST(ContactSurface, quadratic_faces_become_four_triangles_with_their_mid_nodes) {
  const TetMesh m = quadratic_mesh(tet_box(3, 2, 2, 1.5e-3, 1e-3, 1e-3));
  const auto s = extract_contact_surface(m.x, m.tets, 2, {}, ContactFaces::both);
  EXPECT_EQ(s.triangle_count(), 4 * 2 * 2 * (3 * 2 + 3 * 2 + 2 * 2));
  EXPECT_NEAR(enclosed_volume(s), 1.5e-9, 1e-20);
  EXPECT_NEAR(total_area(s), 2 * (1.5 + 1.5 + 1.0) * 1e-6, 1e-16);
  EXPECT_EQ(s.node_count(), s.triangle_count() / 2 + 2);  // Euler, closed surface
}

TEST(ContactSurface, areas_and_normals_follow_the_configuration) {
  const TetMesh m = tet_box(4, 4, 2, 2e-3, 2e-3, 1e-3);
  const auto s = extract_contact_surface(m.x, m.tets, 1, m.side, ContactFaces::inner);
  const Eigen::AngleAxisd turn(0.7, Vec3(1, 2, -1).normalized());
  const auto x = m.mapped([&](const Vec3& p) -> Vec3 { return turn * Vec3(2 * p[0], 3 * p[1], p[2]); });
  std::vector<double> area(s.nodes.size());
  std::vector<Vec3> normals(s.nodes.size());
  current_tributary_areas(s, x, area);
  current_node_normals(s, x, normals);
  for (int n = 0; n < s.node_count(); ++n) {
    EXPECT_NEAR(area[n], 6 * s.reference_area[n], 1e-18);
    EXPECT_NEAR((normals[n] - turn * Vec3::UnitZ()).norm(), 0.0, 1e-12);
  }
}

TEST(ContactSurface, faces_at_some_nodes_are_those_of_the_whole_and_leave_the_others_alone) {
  const TetMesh m = tet_box(5, 4, 2, 2e-3, 2e-3, 1e-3);
  const auto s = extract_contact_surface(m.x, m.tets, 1, m.side, ContactFaces::both);
  const auto x = m.mapped([](const Vec3& p) -> Vec3 { return p + 0.3e-3 * Vec3(std::sin(2000 * p[1]), std::sin(3000 * p[2]), std::sin(2500 * p[0])); });
  std::vector<double> area(s.nodes.size()), some_area(s.nodes.size(), -1);
  std::vector<Vec3> normals(s.nodes.size()), some(s.nodes.size(), Vec3::Constant(7));
  current_tributary_areas(s, x, area);
  current_face_normals(s, x, normals);
  std::vector<int> which;
  for (int n = 0; n < s.node_count(); n += 3) which.push_back(n);
  current_faces_at(s, x, which, some, some_area);
  for (int n = 0; n < s.node_count(); ++n) {
    EXPECT_NEAR((some[n] - (n % 3 == 0 ? normals[n] : Vec3::Constant(7))).norm(), 0.0, 1e-14);
    EXPECT_NEAR(some_area[n], n % 3 == 0 ? area[n] : -1.0, 1e-14 * std::abs(some_area[n]));
  }
}

TEST(ContactSurface, refuses_meshes_it_cannot_use) {
  TetMesh m = tet_box(1, 1, 1, 1, 1, 1);
  EXPECT_THROW(extract_contact_surface(m.x, m.tets, 1, {}, ContactFaces::inner), InputError);
  std::vector<int> no_side(m.side.size(), 0);
  EXPECT_THROW(extract_contact_surface(m.x, m.tets, 1, no_side, ContactFaces::inner), InputError);
  auto wrong = m.tets;
  wrong[0][2] = 99;
  EXPECT_THROW(extract_contact_surface(m.x, wrong, 1, m.side, ContactFaces::both), InputError);
  auto three = m.tets;
  three.push_back(m.tets[0]);
  three.push_back(m.tets[0]);
  EXPECT_THROW(extract_contact_surface(m.x, three, 1, m.side, ContactFaces::both), InputError);
}

}  // namespace
}  // namespace mv::test
