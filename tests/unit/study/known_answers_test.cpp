// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/known_answers.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "solver/study/sheet.h"

namespace mv {
namespace {

TEST(TubeStart, series_starts_from_rest_and_ends_as_poiseuille_flow) {
  const double g = 40, r = 0.01, rho = 1060, mu = 0.02;
  // Inviscid at first: the core is accelerated by G / rho.
  const double early = 1e-3 * r * r * rho / mu;
  EXPECT_NEAR(tube_start(g, r, rho, mu, early).axial_velocity, g / rho * early, 1e-3 * g / rho * early);
  const TubeStart late = tube_start(g, r, rho, mu, 5 * r * r * rho / mu);
  EXPECT_NEAR(late.axial_velocity, g * r * r / (4 * mu), 1e-9);
  EXPECT_NEAR(late.flow, std::numbers::pi * g * std::pow(r, 4) / (8 * mu), 1e-12);
}

TEST(TubeStart, errors_fall_with_the_cells_across) {
  const StudyTable table = tube_start_table(true);
  ASSERT_EQ(table.rows.size(), 2u);
  for (std::size_t q = 0; q < table.quantities.size(); ++q)
    std::printf("%s: computed %.6g (%g mm) %.6g (%g mm), reference %.6g %s\n", table.quantities[q].name.c_str(), table.rows[0].values[q], table.rows[0].mesh.fluid_mm, table.rows[1].values[q],
                table.rows[1].mesh.fluid_mm, table.quantities[q].reference, table.quantities[q].unit.c_str());
  for (std::size_t q = 0; q < 2; ++q) EXPECT_LT(table.rows[1].errors[q], 5);
  EXPECT_LT(table.rows[1].errors[1], 0.6 * table.rows[0].errors[1]);
}

TEST(Sheet, mesh_fills_the_sheet_and_is_held_on_its_four_sides) {
  for (int order : {1, 2}) {
    SheetShape shape;
    shape.solid_mm = 4;
    shape.order = order;
    const LeafletMesh mesh = sheet_mesh(shape);
    double volume = 0;
    for (const auto& tet : mesh.tets) {
      auto x = [&](std::size_t n) { return mesh.points[static_cast<std::size_t>(tet[n])]; };
      const double v = (x(1) - x(0)).cross(x(2) - x(0)).dot(x(3) - x(0)) / 6;
      EXPECT_GT(v, 0);
      volume += v;
      const std::size_t middle = order == 2 ? 4 : 0;
      EXPECT_LT((x(middle) - (order == 2 ? Vec3(0.5 * (x(0) + x(1))) : x(0))).norm(), 1e-12);
    }
    EXPECT_NEAR(volume, shape.width_mm * shape.depth_mm * shape.thickness_mm, 1e-9);
    long held = 0, atrial_points = 0;
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
      held += mesh.on_annulus[i];
      atrial_points += mesh.side[i] == atrial;
    }
    const long points = order == 2 ? 13 * 11 : 7 * 6, inner = order == 2 ? 11 * 9 : 5 * 4, planes = order == 2 ? 5 : 3;
    EXPECT_EQ(atrial_points, points);
    EXPECT_EQ(held, planes * (points - inner));
  }
}

TEST(Sheet, bulging_and_leak_come_nearer_to_the_answer_on_the_finer_of_two_coarse_grids) {
  // The kernel is 16 and 12 mm wide here, the sheet 20 mm: errors are large, and must fall.
  const StudyTable table = sheet_table(true);
  ASSERT_EQ(table.rows.size(), 2u);
  for (const StudyRow& row : table.rows) {
    ASSERT_TRUE(row.has_values) << row.failure;
    std::printf("%s: bulging computed %.4g ml, reference %.4g ml; leak computed %.3g ml/s, reference 0; stress computed %.4g kPa, reference %.4g kPa\n", row.what.c_str(), row.values[0],
                table.quantities[0].reference, row.values[1], row.values[2], table.quantities[2].reference);
  }
  const auto &coarse = table.rows[0].values, &fine = table.rows[1].values;
  const double reference = table.quantities[0].reference;
  EXPECT_LT(std::abs(fine[0] - reference), 0.9 * std::abs(coarse[0] - reference));
  EXPECT_LT(std::abs(fine[1]), std::abs(coarse[1]));
  EXPECT_GT(fine[0], 0.5 * reference);
}

}  // namespace
}  // namespace mv
