// SPDX-License-Identifier: BSD-3-Clause
#include "solver/output/contact_map.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <map>

#include "support/synthetic_results.h"

namespace fs = std::filesystem;
using namespace mv;

namespace {

ContactMap map_of(const test::SyntheticValve& valve) {
  return make_contact_map(valve.mesh, valve.contact_pressure, std::vector<double>(3 * valve.mesh.points.size(), 1e-3), valve.gap);
}

double area_of(const ContactMap& map) {
  double area = 0;
  for (const auto& t : map.triangles) {
    const Vec2 a = map.points[static_cast<std::size_t>(t[1])] - map.points[static_cast<std::size_t>(t[0])];
    const Vec2 b = map.points[static_cast<std::size_t>(t[2])] - map.points[static_cast<std::size_t>(t[0])];
    area += std::abs(a.x() * b.y() - a.y() * b.x()) / 2;
  }
  return area;
}

TEST(ContactMapTest, boundary_is_closed_and_points_out) {
  for (int order : {1, 2}) {
    const auto valve = test::make_synthetic_valve({.order = order, .columns = 20, .rows = 4});
    const FaceTriangles faces = boundary_faces(valve.mesh);
    std::map<std::pair<int, int>, int> edges;
    double volume = 0;
    for (const auto& t : faces.triangles) {
      for (std::size_t k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
      const auto x = [&](int k) -> const Vec3& {
        return valve.mesh.points[static_cast<std::size_t>(t[static_cast<std::size_t>(k)])];
      };
      volume += x(0).dot(x(1).cross(x(2))) / 6;
    }
    for (const auto& [edge, count] : edges) {
      EXPECT_EQ(count, 1);
      EXPECT_TRUE(edges.contains({edge.second, edge.first}));
    }
    double solid = 0;
    for (const auto& t : valve.mesh.tets) {
      const auto x = [&](int k) -> const Vec3& {
        return valve.mesh.points[static_cast<std::size_t>(t[static_cast<std::size_t>(k)])];
      };
      solid += (x(1) - x(0)).cross(x(2) - x(0)).dot(x(3) - x(0)) / 6;
    }
    EXPECT_NEAR(volume, solid, 1e-9 * solid) << "order " << order;
  }
}

TEST(ContactMapTest, covers_the_flat_pattern_once_without_triangles_across_it) {
  const auto valve = test::make_synthetic_valve({.columns = 192, .rows = 10});
  const ContactMap map = map_of(valve);
  // strip plus half ellipses: anterior radius 18, three scallops on the rest
  const double scallop = (valve.perimeter - 36) / 6;
  const double expected = 6 * valve.perimeter + M_PI / 2 * (18 * 18 * 0.9 + 3 * scallop * scallop * 0.75);
  EXPECT_NEAR(area_of(map), expected, 0.02 * expected);
  for (const auto& t : map.triangles)
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_LT(
          std::abs(map.points[static_cast<std::size_t>(t[k])].x() - map.points[static_cast<std::size_t>(t[(k + 1) % 3])].x()), 2);
  double u_max = 0;
  for (const Vec2& p : map.points) u_max = std::max(u_max, p.x());
  EXPECT_NEAR(u_max, valve.perimeter, 0.05);
}

TEST(ContactMapTest, quadratic_faces_cover_the_same_area) {
  const double linear = area_of(map_of(test::make_synthetic_valve({.columns = 40, .rows = 6})));
  const double quadratic = area_of(map_of(test::make_synthetic_valve({.order = 2, .columns = 40, .rows = 6})));
  EXPECT_NEAR(quadratic, linear, 1e-3 * linear);
}

TEST(ContactMapTest, comes_back_from_its_file) {
  const auto valve = test::make_synthetic_valve({.columns = 24, .rows = 4});
  ContactMap map = map_of(valve);
  map.in_belt.assign(map.points.size(), 0);
  map.in_belt[3] = 1;
  const fs::path file = fs::temp_directory_path() / ("mv_contact_map_test_" + std::to_string(::getpid()) + ".vtp");
  write_contact_map(file, map);
  const ContactMap back = read_contact_map(file);
  EXPECT_EQ(back.triangles, map.triangles);
  EXPECT_EQ(back.contact_pressure, map.contact_pressure);
  EXPECT_EQ(back.contact_force, map.contact_force);
  EXPECT_EQ(back.region, map.region);
  EXPECT_EQ(back.mesh_point, map.mesh_point);
  EXPECT_EQ(back.in_belt, map.in_belt);
  int without_partner = 0;
  for (std::size_t i = 0; i < map.gap.size(); ++i) {
    if (std::isnan(map.gap[i])) {
      EXPECT_TRUE(std::isnan(back.gap[i]));
      ++without_partner;
    } else {
      EXPECT_EQ(back.gap[i], map.gap[i]);
    }
  }
  EXPECT_GT(without_partner, 0);
  fs::remove(file);
}

}  // namespace
