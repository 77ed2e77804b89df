// SPDX-License-Identifier: BSD-3-Clause
#include "fibers/nematic.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <complex>
#include <limits>
#include <numeric>
#include <random>

#include "geometry/core/errors.h"
#include "support/grid_leaflet.h"

namespace {

using namespace mv;
constexpr double degree = std::numbers::pi / 180;

std::vector<int> all_elements(const LeafletMesh& m) {
  std::vector<int> e(m.tets.size());
  std::iota(e.begin(), e.end(), 0);
  return e;
}

Vec3 centroid(const LeafletMesh& m, int e) {
  Vec3 x = Vec3::Zero();
  for (std::size_t i = 0; i < 4; ++i)
    x += 0.25 * m.points[static_cast<std::size_t>(m.tets[static_cast<std::size_t>(e)][i])];
  return x;
}

// Angle between two directions without sign, radians.
double between_directions(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), std::abs(a.dot(b))); }

Vec3 in_plane(double angle) { return Vec3(std::cos(angle), std::sin(angle), 0); }

TEST(Nematic, a_constant_direction_is_reproduced_everywhere) {
  const LeafletMesh mesh = test::flat_patch(10, 8, 0.5);
  for (double angle : {0.0, 35.0, 90.0, 151.0}) {
    std::vector<GivenDirection> given;
    for (std::size_t i = 0; i < mesh.points.size(); ++i)
      if (mesh.on_annulus[i]) given.push_back({static_cast<int>(i), in_plane(angle * degree), 1});
    const NematicField field = diffuse_directions(mesh, all_elements(mesh), given);
    for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
      EXPECT_LT(between_directions(field.directions[e], in_plane(angle * degree)), 1e-9);
      EXPECT_NEAR(field.order[e], 1, 1e-9);
    }
  }
}

TEST(Nematic, between_two_given_directions_z_is_linear) {
  const LeafletMesh mesh = test::flat_patch(10, 4, 0.5);
  const double turn = 70 * degree;
  std::vector<GivenDirection> given;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    if (mesh.points[i].x() < 1e-9) given.push_back({static_cast<int>(i), in_plane(0), 1});
    if (mesh.points[i].x() > 10 - 1e-9) given.push_back({static_cast<int>(i), in_plane(turn), 1});
  }
  const NematicField field = diffuse_directions(mesh, all_elements(mesh), given);
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
    const double s = centroid(mesh, static_cast<int>(e)).x() / 10;
    const std::complex<double> z = (1 - s) + s * std::polar(1.0, 2 * turn);
    EXPECT_LT(between_directions(field.directions[e], in_plane(0.5 * std::arg(z))), 1e-9);
    EXPECT_NEAR(field.order[e], std::abs(z), 1e-9);
  }
}

TEST(Nematic, takes_the_short_way_as_a_direction_without_sign) {
  // 170 and 10 degrees are 20 degrees apart: half way lies 0, not 90.
  const LeafletMesh mesh = test::flat_patch(10, 4, 0.5);
  std::vector<GivenDirection> given;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    if (mesh.points[i].x() < 1e-9) given.push_back({static_cast<int>(i), in_plane(170 * degree), 1});
    if (mesh.points[i].x() > 10 - 1e-9) given.push_back({static_cast<int>(i), in_plane(10 * degree), 1});
  }
  const NematicField field = diffuse_directions(mesh, all_elements(mesh), given);
  for (const Vec3& f : field.directions)
    EXPECT_LT(between_directions(f, Vec3::UnitX()), 10.001 * degree);
}

TEST(Nematic, negating_given_directions_changes_no_bit) {
  const LeafletMesh mesh = test::ring_valve();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> angle(0, 3);
  std::vector<GivenDirection> given, flipped;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    if (!mesh.on_annulus[i]) continue;
    const Vec3 d(std::cos(angle(random)), std::sin(angle(random)), 0.3);
    given.push_back({static_cast<int>(i), d, 1});
    flipped.push_back({static_cast<int>(i), random() % 2 ? Vec3(-d) : d, 1});
  }
  const NematicField a = diffuse_directions(mesh, all_elements(mesh), given),
                     b = diffuse_directions(mesh, all_elements(mesh), flipped);
  for (std::size_t e = 0; e < mesh.tets.size(); ++e)
    EXPECT_EQ(a.directions[e], b.directions[e]);
}

TEST(Nematic, on_a_cylinder_a_helix_stays_a_helix) {
  // Parallel transport: the angle to the axis is kept although the direction turns through 90 degrees in space.
  test::GridSpec g;
  g.columns = 60;
  g.rows = 12;
  const double radius = 17;
  g.pattern = [](int i, int j) { return Vec2(i * 0.5, j * 0.5); };
  g.place = [=](Vec2 p, double w) {
    const double a = p.x() / radius;
    return Vec3((radius + w) * std::cos(a), (radius + w) * std::sin(a), p.y());
  };
  g.normal = [=](Vec2 p) {
    const double a = p.x() / radius;
    return Vec3(std::cos(a), std::sin(a), 0);
  };
  const LeafletMesh mesh = test::grid_leaflet(g);
  const auto helix = [](const Vec3& x, double angle) {
    const Vec3 around = Vec3(-x.y(), x.x(), 0).normalized();
    return Vec3(std::cos(angle) * around + std::sin(angle) * Vec3::UnitZ());
  };
  std::vector<GivenDirection> given;
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    if (mesh.unfolded[i].x() < 1e-9) given.push_back({static_cast<int>(i), helix(mesh.points[i], 40 * degree), 1});
  const NematicField field = diffuse_directions(mesh, all_elements(mesh), given);
  double largest = 0;
  for (std::size_t e = 0; e < mesh.tets.size(); ++e)
    largest = std::max(largest, between_directions(field.directions[e], helix(centroid(mesh, static_cast<int>(e)), 40 * degree)));
  EXPECT_LT(largest, 1 * degree);
  EXPECT_GT(field.order_min, 0.999);
}

TEST(Nematic, stays_between_the_given_angles) {
  // The grid has no obtuse dihedral angle, so the discrete maximum principle holds.
  const LeafletMesh mesh = test::flat_patch(12, 9, 0.5);
  std::vector<GivenDirection> given;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    if (mesh.on_annulus[i]) given.push_back({static_cast<int>(i), in_plane((5 + mesh.points[i].x()) * degree), 1});
    if (mesh.on_free_edge[i] && std::abs(mesh.points[i].x() - 6) < 2)
      given.push_back({static_cast<int>(i), in_plane(80 * degree), 1});
  }
  const NematicField field = diffuse_directions(mesh, all_elements(mesh), given);
  double low = 180, high = 0;
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
    double angle = std::atan2(field.directions[e].y(), field.directions[e].x()) / degree;
    angle -= 180 * std::floor(angle / 180);
    low = std::min(low, angle);
    high = std::max(high, angle);
    EXPECT_LE(field.order[e], 1 + 1e-9);
  }
  EXPECT_GE(low, 5 - 1e-6);
  EXPECT_LE(high, 80 + 1e-6);
  EXPECT_GT(high - low, 60);
}

// Flat ring, x direction on the inner circle, radial on the outer one: z = ln(R/r)/ln(R/q) + exp(2 i theta) (r^2 - q^4/r^2)/(R^2
// - q^4/R^2).
double ring_angle_error(int columns) {
  const double inner = 4, outer = 10;
  test::GridSpec g;
  g.columns = columns;
  g.rows = columns / 6;
  g.layers = 2;
  g.is_periodic = true;
  g.pattern = [=](int i, int j) { return Vec2(2 * std::numbers::pi * i / columns, inner + (outer - inner) * j / (columns / 6)); };
  g.place = [](Vec2 p, double w) { return Vec3(p.y() * std::cos(p.x()), p.y() * std::sin(p.x()), w); };
  g.normal = [](Vec2) { return Vec3::UnitZ(); };
  const LeafletMesh mesh = test::grid_leaflet(g);
  std::vector<GivenDirection> given;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    if (mesh.on_annulus[i]) given.push_back({static_cast<int>(i), Vec3::UnitX(), 1});
    if (mesh.on_free_edge[i]) given.push_back({static_cast<int>(i), Vec3(mesh.points[i].x(), mesh.points[i].y(), 0), 1});
  }
  const NematicField field = diffuse_directions(mesh, all_elements(mesh), given);
  double sum = 0;
  int count = 0;
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
    const Vec3 x = centroid(mesh, static_cast<int>(e));
    const double r = x.head<2>().norm(), theta = std::atan2(x.y(), x.x());
    const auto ring = [&](double s) { return s * s - std::pow(inner, 4) / (s * s); };
    const std::complex<double> z = std::log(outer / r) / std::log(outer / inner) + std::polar(ring(r) / ring(outer), 2 * theta);
    if (std::abs(z) < 0.3) continue;  // around the two places where the direction is undefined
    sum += std::pow(between_directions(field.directions[e], in_plane(0.5 * std::arg(z))), 2);
    ++count;
  }
  return std::sqrt(sum / count);
}

TEST(Nematic, angles_converge_with_second_order) {
  const double coarse = ring_angle_error(24), medium = ring_angle_error(48), fine = ring_angle_error(96),
               finest = ring_angle_error(192);
  RecordProperty("error_finest_degree", std::to_string(finest / degree));
  EXPECT_GT(std::log2(coarse / medium), 1.7);
  EXPECT_GT(std::log2(medium / fine), 1.8);
  EXPECT_GT(std::log2(fine / finest), 1.8);
  EXPECT_LT(finest, 0.1 * degree);
}

TEST(Nematic, contradicting_directions_are_reported_by_the_order) {
  const LeafletMesh mesh = test::flat_patch(10, 4, 0.5);
  std::vector<GivenDirection> given;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    if (mesh.points[i].x() < 1e-9) given.push_back({static_cast<int>(i), in_plane(0), 1});
    if (mesh.points[i].x() > 10 - 1e-9) given.push_back({static_cast<int>(i), in_plane(90 * degree), 1});
  }
  const NematicField field = diffuse_directions(mesh, all_elements(mesh), given);
  EXPECT_LT(field.order_min, 0.1);
  for (const Vec3& f : field.directions)
    EXPECT_NEAR(f.norm(), 1, 1e-12);
}

TEST(Nematic, refuses_what_leaves_the_field_undefined) {
  LeafletMesh mesh = test::flat_patch(4, 4, 1);
  const auto elements = all_elements(mesh);
  EXPECT_THROW(diffuse_directions(mesh, elements, {}), InputError);
  EXPECT_THROW(diffuse_directions(mesh, elements, {{0, Vec3::UnitZ(), 1}}), InputError);
  EXPECT_THROW(diffuse_directions(mesh, elements, {{0, Vec3::Zero(), 1}}), InputError);
  EXPECT_THROW(diffuse_directions(mesh, elements, {{100000, Vec3::UnitX(), 1}}), InputError);
  LeafletMesh apart = test::slit_patch(9, 4, 0, 1);  // the slit reaches the annulus: two parts
  EXPECT_THROW(diffuse_directions(apart, all_elements(apart), {{0, Vec3::UnitX(), 1}}), InputError);
  mesh.sheet_normal[5] = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_THROW(diffuse_directions(mesh, elements, {{0, Vec3::UnitX(), 1}}), InputError);
  mesh.sheet_normal.clear();
  EXPECT_THROW(diffuse_directions(mesh, elements, {{0, Vec3::UnitX(), 1}}), InputError);
}

}  // namespace
