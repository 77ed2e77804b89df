// SPDX-License-Identifier: BSD-3-Clause
#include "solver/coupling/film_drainage.h"

#include <gtest/gtest.h>

#include "solver/coupling/transfer.h"

namespace {

using mv::ContactSurface;
using mv::FilmDrainage;
using mv::FilmDrainageOptions;
using mv::FluidGrid;
using mv::SelfContact;
using Eigen::Vector3d;

constexpr double h = 1e-3, pressure = 16e3, threshold = 0.5e-3;

/// Two square sheets of 10 mm that face each other a gap apart, half way up a box of blood.
struct Sheets {
  FluidGrid grid;
  std::vector<double> rest, x, v, forces, unseen;  // forces: of contact alone at the start
  std::vector<char> is_fixed;
  std::vector<double> blood;
  ContactSurface surface;
  std::unique_ptr<SelfContact> contact;
  int side = 21;

  explicit Sheets(double gap) {
    grid.n = {16, 16, 16};
    grid.h = h;
    std::vector<std::array<int, 3>> triangles;
    for (int sheet = 0; sheet < 2; ++sheet) {
      const double z = 8e-3 + (sheet ? 0.5 : -0.5) * gap;
      for (int j = 0; j < side; ++j)
        for (int i = 0; i < side; ++i) rest.insert(rest.end(), {3e-3 + 0.5e-3 * i, 3e-3 + 0.5e-3 * j, z});
      for (int j = 0; j + 1 < side; ++j)
        for (int i = 0; i + 1 < side; ++i) {
          const int a = sheet * side * side + i + side * j, b = a + 1, c = a + side, d = c + 1;
          if (sheet == 0) triangles.insert(triangles.end(), {{a, b, d}, {a, d, c}});  // normal up
          else triangles.insert(triangles.end(), {{a, d, b}, {a, c, d}});
        }
    }
    x = rest;
    v.assign(x.size(), 0.0);
    is_fixed.assign(x.size() / 3, 0);
    blood.assign(grid.padded_size(), 0.0);
    surface = mv::contact_surface_from_triangles(rest, triangles);
    mv::ContactOptions options;
    options.threshold = threshold;
    options.thickness = 0;
    options.exclusion_radius = 1e-9;
    options.stiffness = pressure / (0.8 * threshold);
    contact = std::make_unique<SelfContact>(surface, options);
    unseen.assign(x.size(), 0.0);
    forces.assign(x.size(), 0.0);
    contact->evaluate(x, v, 0.0, forces);
  }
  double speed(std::size_t node, double dt = 1e-5) const { return (x[3 * node + 2] - rest[3 * node + 2]) / dt; }
  FilmDrainage drainage(FilmDrainageOptions options = {}) const {
    return FilmDrainage(surface, *contact, rest, is_fixed, grid, options);
  }
  void fill(double p) { std::fill(blood.begin(), blood.end(), p); }
  void slip(FilmDrainage& drainage, double dt = 1e-5) {
    std::vector<double> gaps;
    drainage.find_gaps(x, gaps);
    drainage.press(x, gaps, blood, pressure, forces, unseen);
    drainage.slip(x, gaps, dt);
  }
  std::size_t centre(int sheet) const { return static_cast<std::size_t>(sheet * side * side + side * (side / 2) + side / 2); }
};

TEST(FilmDrainage, drains_at_the_stated_speed_and_towards_each_other) {
  Sheets s(1.2 * h);
  FilmDrainageOptions options;
  FilmDrainage drainage = s.drainage(options);
  s.fill(0.5 * pressure);
  s.slip(drainage);
  const double speed = h / options.drainage_time * 0.5 * pressure / options.pressure_scale;
  EXPECT_NEAR(s.speed(s.centre(0)), speed, 1e-6 * speed);
  EXPECT_NEAR(s.speed(s.centre(1)), -speed, 1e-6 * speed);
  EXPECT_NEAR(s.x[3 * s.centre(0)], s.rest[3 * s.centre(0)], 1e-15);
}

TEST(FilmDrainage, rests_without_a_pressure_and_where_the_leaflets_carry_it_themselves) {
  Sheets still(1.2 * h);
  FilmDrainage none = still.drainage();
  still.fill(0.0);
  still.slip(none);
  EXPECT_EQ(still.x, still.rest);
  Sheets taut(1.2 * h);
  FilmDrainage drainage = taut.drainage();
  taut.fill(pressure);
  std::vector<double> areas(taut.surface.nodes.size());
  mv::current_tributary_areas(taut.surface, taut.x, areas);
  const std::size_t half = taut.x.size() / 6;
  for (std::size_t n = 0; n < areas.size(); ++n) taut.forces[3 * n + 2] = (n < half ? -1 : 1) * pressure * areas[n];
  taut.slip(drainage);
  EXPECT_NEAR(taut.speed(taut.centre(0)), 0.0, 1e-9);
  EXPECT_NEAR(taut.unseen[3 * taut.centre(0) + 2], 0.0, 1e-9 * pressure * areas[0]);
}

TEST(FilmDrainage, hands_the_films_pressure_to_the_face_that_contact_presses) {
  Sheets s(0.2 * threshold);
  FilmDrainage drainage = s.drainage();
  s.fill(pressure);
  s.slip(drainage);
  std::vector<double> areas(s.surface.nodes.size());
  mv::current_tributary_areas(s.surface, s.x, areas);
  const std::size_t middle = s.centre(0);
  EXPECT_NEAR(s.unseen[3 * middle + 2], pressure * areas[middle], 1e-6 * pressure * areas[middle]);
  EXPECT_NEAR(s.forces[3 * middle + 2] + s.unseen[3 * middle + 2], 0.0, 1e-6 * pressure * areas[middle]);
}

TEST(FilmDrainage, rests_beyond_its_reach) {
  Sheets s(2.6 * h);
  FilmDrainage drainage = s.drainage();
  s.fill(pressure);
  s.slip(drainage);
  EXPECT_EQ(s.x, s.rest);
}

TEST(FilmDrainage, rests_where_contact_carries_the_pressure_and_opens_where_it_carries_more) {
  Sheets rest(0.2 * threshold);  // the linear penalty of these tests carries the pressure at 0.8 of the threshold
  FilmDrainage drainage = rest.drainage();
  rest.fill(pressure);
  rest.slip(drainage);
  EXPECT_NEAR(rest.speed(rest.centre(0)), 0.0, 1e-6);
  Sheets pressed(0.1 * threshold);  // carries 1.125 times the pressure
  FilmDrainage opening = pressed.drainage();
  pressed.fill(pressure);
  pressed.slip(opening);
  EXPECT_LT(pressed.speed(pressed.centre(0)), -1e-3);
}

TEST(FilmDrainage, never_closes_faces_that_touch) {
  Sheets s(0.0);
  // The contact carries nothing here: the pressure difference is what pushes.
  s.contact->set_node_stiffness(std::vector<double>(s.surface.nodes.size(), 0.0));
  s.forces.assign(s.x.size(), 0.0);
  s.contact->evaluate(s.x, s.v, 0.0, s.forces);
  FilmDrainage drainage = s.drainage();
  s.fill(pressure);
  s.slip(drainage);
  EXPECT_LE(s.speed(s.centre(0)), 0.0);
  EXPECT_GE(s.speed(s.centre(1)), 0.0);
}

TEST(FilmDrainage, leaves_the_hinge_at_rest) {
  Sheets s(1.2 * h);
  for (int sheet = 0; sheet < 2; ++sheet)
    for (int j = 0; j < s.side; ++j) s.is_fixed[static_cast<std::size_t>(sheet * s.side * s.side + s.side * j)] = 1;
  FilmDrainage drainage = s.drainage();
  s.fill(pressure);
  s.slip(drainage);
  for (int i = 0; i <= 3; ++i) EXPECT_EQ(s.speed(static_cast<std::size_t>(s.side * 10 + i)), 0.0);  // within two cells
  EXPECT_GT(s.speed(static_cast<std::size_t>(s.side * 10 + 12)), 0.0);
}

}  // namespace
