// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/volume/leaflet_tets.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <set>

#include "geometry/annulus/annulus_fit.h"
#include "geometry/core/errors.h"
#include "geometry/generic/generic_valve.h"
#include "geometry/volume/gates.h"
#include "support/real_annulus.h"

namespace {

using mv::Vec3;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Flat square sheet of n x n cells of size h in the plane z = 0, atrial side +z.
mv::MidSurface sheet(int n, double h) {
  mv::MidSurface s;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) {
      s.points.push_back({h * i, h * j, 0});
      s.unfolded.push_back({h * i, h * j});
      s.normals.push_back(Vec3::UnitZ());
      s.on_annulus.push_back(j == 0);
      s.on_free_edge.push_back(j == n);
    }
  auto index = [&](int i, int j) { return i * (n + 1) + j; };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      s.triangles.push_back({index(i, j), index(i + 1, j), index(i + 1, j + 1)});
      s.triangles.push_back({index(i, j), index(i + 1, j + 1), index(i, j + 1)});
    }
  s.region.assign(s.triangles.size(), mv::anterior);
  s.axis = Vec3(0, -1, 0);
  return s;
}

TEST(Thicken, thickness_per_point_gives_its_own_volume_in_two_layers) {
  mv::MidSurface s = sheet(6, 0.5);
  for (const Vec3& p : s.points) s.thickness.push_back(0.4 + 0.3 * p.x());  // 0.4 to 1.3 mm
  const mv::LeafletMesh m = mv::thicken(s, {7.0, 2, 1});                    // the uniform value is not used
  const mv::Gate boundary = mv::gate_boundary(m), volume = mv::gate_volumes(m), count = mv::gate_layers(m, 2);
  EXPECT_TRUE(boundary.passed && volume.passed && count.passed) << boundary.message << volume.message << count.message;
  double total = 0;
  for (const auto& t : m.tets) {
    const Vec3 &a = m.points[at(t[0])], &b = m.points[at(t[1])], &c = m.points[at(t[2])], &d = m.points[at(t[3])];
    total += (b - a).dot((c - a).cross(d - a)) / 6;
  }
  EXPECT_NEAR(total, 9 * 0.85, 1e-12);  // area times mean thickness: exact, the faces are planes
  for (std::size_t i = 0; i < s.points.size(); ++i) {
    EXPECT_NEAR(m.points[i].z(), 0.5 * s.thickness[i], 1e-15);
    EXPECT_NEAR(m.points[i + 2 * s.points.size()].z(), -0.5 * s.thickness[i], 1e-15);
  }
  s.thickness.assign(s.points.size(), 0.8);
  EXPECT_EQ(mv::thicken(s, {7.0, 2, 2}).points, mv::thicken(sheet(6, 0.5), {0.8, 2, 2}).points) << "uniform is uniform, to the bit";
  s.thickness[3] = 0;
  EXPECT_THROW(mv::thicken(s, {1.0, 2, 1}), mv::InputError);
  s.thickness.pop_back();
  EXPECT_THROW(mv::thicken(s, {1.0, 2, 1}), mv::InputError);
}

TEST(Thicken, flat_sheet_fills_its_box_with_conforming_layers) {
  for (int layers : {1, 2, 3, 5})
    for (int order : {1, 2}) {
      const mv::LeafletMesh m = mv::thicken(sheet(4, 0.5), {1.0, layers, order});
      EXPECT_EQ(m.tets.size(), at(32 * 3 * layers));
      const mv::Gate boundary = mv::gate_boundary(m), volume = mv::gate_volumes(m), count = mv::gate_layers(m, layers);
      EXPECT_TRUE(boundary.passed) << boundary.message;
      EXPECT_TRUE(volume.passed) << volume.message;
      EXPECT_TRUE(count.passed) << count.message;
      double total = 0;
      for (const auto& t : m.tets) {
        const Vec3 &a = m.points[at(t[0])], &b = m.points[at(t[1])], &c = m.points[at(t[2])], &d = m.points[at(t[3])];
        total += (b - a).dot((c - a).cross(d - a)) / 6;
      }
      EXPECT_NEAR(total, 4.0, 1e-12);
      // The interior faces are shared by exactly two elements: the boundary is the box's surface and nothing else.
      EXPECT_EQ(mv::extract_boundary(m).triangles.size(), at(2 * 32 + 16 * 2 * layers));
    }
}

TEST(Thicken, sides_flags_and_directions) {
  const mv::LeafletMesh m = mv::thicken(sheet(3, 0.5), {1.0, 2, 1});
  for (std::size_t i = 0; i < m.points.size(); ++i) {
    EXPECT_EQ(m.side[i], m.points[i].z() > 0.25 ? mv::atrial : m.points[i].z() < -0.25 ? mv::ventricular : mv::between);
    EXPECT_EQ(m.on_annulus[i] != 0, m.points[i].y() == 0);
    EXPECT_EQ(m.on_free_edge[i] != 0, m.points[i].y() == 1.5);
    EXPECT_EQ(m.unfolded[i], m.points[i].head<2>());
  }
  for (std::size_t e = 0; e < m.tets.size(); ++e) {
    EXPECT_EQ(m.sheet_normal[e], Vec3::UnitZ());
    EXPECT_LT((m.fibre[e] - Vec3(-1, 0, 0)).norm(), 1e-12);  // axis x normal
    double z = 0;
    for (std::size_t k = 0; k < 4; ++k) z += m.points[at(m.tets[e][k])].z() / 4;
    EXPECT_EQ(m.layer[e], z > 0 ? 0 : 1);
  }
}

TEST(Thicken, quadratic_midpoints_lie_halfway_in_vtk_order_and_are_shared) {
  const mv::GenericValve valve = mv::build_generic_valve({}, 2.0);
  const mv::LeafletMesh linear = mv::thicken(valve.mid_surface, {1.0, 2, 1}), m = mv::thicken(valve.mid_surface, {1.0, 2, 2});
  constexpr std::array<std::array<std::size_t, 2>, 6> edges{{{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};
  std::set<std::pair<int, int>> unique;
  const double perimeter = valve.mid_surface.perimeter;
  for (const auto& t : m.tets)
    for (std::size_t e = 0; e < 6; ++e) {
      const int a = t[edges[e][0]], b = t[edges[e][1]], c = t[4 + e];
      unique.insert({std::min(a, b), std::max(a, b)});
      EXPECT_EQ(m.points[at(c)], 0.5 * (m.points[at(a)] + m.points[at(b)]));
      const double du = std::remainder(m.unfolded[at(a)].x() - m.unfolded[at(c)].x(), perimeter);
      EXPECT_LT(std::abs(du), 2.0 * 3);  // the midpoint does not jump across the pattern
      const bool both_atrial = m.side[at(a)] == mv::atrial && m.side[at(b)] == mv::atrial;
      EXPECT_EQ(m.side[at(c)] == mv::atrial, both_atrial);
    }
  EXPECT_EQ(m.points.size(), linear.points.size() + unique.size());
  EXPECT_EQ(m.on_annulus.size(), m.points.size());
  EXPECT_EQ(m.unfolded.size(), m.points.size());
}

TEST(Thicken, wrong_input_is_refused) {
  EXPECT_THROW(mv::thicken(sheet(2, 1), {0, 2, 1}), mv::ConfigError);
  EXPECT_THROW(mv::thicken(sheet(2, 1), {1, 0, 1}), mv::ConfigError);
  EXPECT_THROW(mv::thicken(sheet(2, 1), {1, 2, 3}), mv::ConfigError);
  mv::MidSurface s = sheet(2, 1);
  s.triangles[0][0] = 99;
  EXPECT_THROW(mv::thicken(s, {}), mv::InputError);
  s = sheet(2, 1);
  s.normals.pop_back();
  EXPECT_THROW(mv::thicken(s, {}), mv::InputError);
}

void expect_all_gates(const mv::GenericValve& valve, double spacing, double thickness) {
  const mv::LeafletMesh m = mv::thicken(valve.mid_surface, {thickness, 2, 1});
  mv::GateLimits limits;
  limits.fluid_spacing = 2 * std::max(spacing, 0.5 * thickness);  // two layers set the distance through the thickness
  const mv::GateReport report = mv::check_leaflets(m, limits);
  EXPECT_TRUE(report.passed()) << report.failures();
  const mv::BoundarySurface boundary = mv::extract_boundary(m);
  // Volume of a thin layer: area times thickness up to the curvature term.
  double area = 0;
  for (const auto& t : valve.mid_surface.triangles) {
    const auto& p = valve.mid_surface.points;
    area += 0.5 * (p[at(t[1])] - p[at(t[0])]).cross(p[at(t[2])] - p[at(t[0])]).norm();
  }
  double volume = 0;
  for (const auto& t : boundary.triangles) volume += m.points[at(t[0])].dot(m.points[at(t[1])].cross(m.points[at(t[2])])) / 6;
  EXPECT_NEAR(volume, area * thickness, 0.01 * volume);
}

struct Case {
  double spacing, strip, notch, anterior_height, slope;
  int scallops;
};
class LeafletSweep : public ::testing::TestWithParam<Case> {};

TEST_P(LeafletSweep, passes_every_gate_with_dihedral_angles_above_ten_degrees) {
  const Case c = GetParam();
  mv::GenericValveParameters p;
  p.strip_height = c.strip;
  p.notch_radius = c.notch;
  p.anterior_height = c.anterior_height;
  p.inward_slope = c.slope;
  p.posterior_scallops = c.scallops;
  expect_all_gates(mv::build_generic_valve(p, c.spacing), c.spacing, 1.0);
}

INSTANTIATE_TEST_SUITE_P(Parameters, LeafletSweep,
                         ::testing::Values(Case{0.4, 6, 1, 0.9, 0.35, 3}, Case{0.5, 6, 1, 0.9, 0.35, 3},
                                           Case{0.7, 3, 1, 0.9, 0.35, 3}, Case{0.7, 8, 1, 0.9, 0.35, 3},
                                           Case{1.0, 3, 1, 0.9, 0.35, 3}, Case{1.0, 8, 1, 0.9, 0.35, 3},
                                           Case{1.0, 6, 0.3, 0.9, 0.35, 3}, Case{1.0, 6, 1, 1.4, 0.35, 3},
                                           Case{1.0, 6, 1, 0.9, 0.0, 3}, Case{1.0, 6, 1, 0.9, 0.8, 2},
                                           Case{1.0, 6, 1, 0.9, 0.35, 4}, Case{1.5, 3, 1, 0.9, 0.35, 3},
                                           Case{1.5, 6, 1, 0.9, 0.35, 1}, Case{2.0, 3, 1, 0.9, 0.35, 3},
                                           Case{2.0, 6, 1, 0.9, 0.35, 3}, Case{2.0, 8, 1, 0.9, 0.35, 3}));

TEST(LeafletMesh, real_annulus_passes_every_gate) {
  const auto folder = mv::test::real_annulus_folder();
  if (!folder) GTEST_SKIP() << "SKIPPED: no normal_1 data in configs/data or ../shared/data";
  const auto curve = mv::clean_closed_curve(mv::read_points_csv(*folder / "normal_1_annulus_mm.csv"));
  mv::NormalHints hints;
  hints.papillary_points = mv::read_points_csv(*folder / "normal_1_papillary_insertions_mm.csv");
  const mv::Annulus annulus = mv::fit_annulus(mv::smooth_closed_curve(curve, 10), hints);
  const mv::AnteriorDirection anterior = mv::find_anterior_direction(annulus, hints.papillary_points);
  for (double spacing : {0.5, 1.0, 2.0})
    expect_all_gates(mv::build_generic_valve({}, spacing, annulus, anterior.direction), spacing, 1.0);
}

}  // namespace
