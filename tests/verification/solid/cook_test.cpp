// SPDX-License-Identifier: BSD-3-Clause
// Cook's membrane, compressible neo-Hookean: linear and quadratic tetrahedra of solver/solid, slab with free faces (as the published table,
// see cook_reference.h) and in plane strain.
//   ctest -L verification -V -R Cook                                                                     the short tables
//   build/tests/verification_solid --gtest_also_run_disabled_tests --gtest_filter='Cook.*refined*'      finer
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "verification/slab_tissue.h"
#include "verification/solid/cook_reference.h"
#include "verification/solid/equilibrium.h"

namespace mv::test {
namespace {

constexpr double mm = 1e-3;

// deal.II code gallery, quasi-static finite-strain compressible elasticity (Pelteret & McBride 2016, doi 10.5281/zenodo.1228964), its README.
struct Published {
  int n;
  double q1, q2;  // mm
};
constexpr Published published[] = {{2, 8.72, 13.83}, {4, 12.02, 14.22}, {8, 13.61, 14.30}, {16, 14.13, 14.32}, {32, 14.28, 14.33}, {64, 14.32, 14.33}};
constexpr double printed_digit = 0.005;  // mm, half a unit of the last place
constexpr double published_tip = 14.33;  // mm

/// Tip displacements (m) with n x 1 x n cells of six tetrahedra. Free faces: half the slab, its middle plane one of symmetry.
CookTip cook_tip_of_tetrahedra(const CookSpec& spec, Faces faces, int n, int order) {
  const bool is_free = faces == Faces::free;
  const double depth = is_free ? spec.depth / 2 : spec.depth, force = is_free ? spec.force / 2 : spec.force;
  BoxSpec box_spec;
  box_spec.cells = {n, 1, n};
  box_spec.order = order;
  box_spec.place = [&](const Vec3& p) { return Vec3(48 * mm * p.x(), depth * p.y(), mm * (44 * p.x() + p.z() * (44 - 28 * p.x()))); };
  const BoxMesh box = box_mesh(box_spec);
  Material m;
  m.law = Law::neo_hookean;
  m.neo_mu = spec.shear;
  m.bulk = spec.bulk();
  LeafletSolid solid(box.mesh, {m});
  Constraints constraints(box.mesh.points);
  const auto normals = [&](int i) {
    std::vector<Vec3> held;
    if (box.is_on(i, 0, 0)) held = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
    if (box.is_on(i, 1, 0)) held.push_back(Vec3::UnitY());
    return held;
  };
  if (is_free) {
    for (int i = 0; i < box.node_count(); ++i) constraints.free_except(i, normals(i));
  } else {
    constraints.plane_strain(box, normals);
  }
  std::vector<double> load(box.mesh.points.size(), 0.0);
  add_traction(box.faces_on(0, 1), force / (16 * mm * depth) * Vec3::UnitZ(), box.mesh.points, load);
  constexpr int steps = 5;
  Equilibrium e;
  for (int step = 1; step <= steps; ++step) {
    const auto forces = [&](std::span<const double> x, std::span<double> f) {
      solid.forces(x, f);
      for (std::size_t i = 0; i < f.size(); ++i) f[i] += load[i] * step / steps;
    };
    e = solve(constraints, box.mesh, forces, std::min(depth, 16 * mm / n), 1e-8 * spec.force / n, std::move(e.q));
    EXPECT_TRUE(e.is_converged) << "n " << n << " order " << order << " residual " << e.residual;
  }
  const auto rise = [&](int k) {
    const int i = box.node_at({2 * n, 2, k});
    return node(e.x, i).z() - node(box.mesh.points, i).z();
  };
  return {rise(2 * n), rise(n)};
}

class Cook : public ::testing::Test {
 protected:
  OneThread one_thread_;
  CookSpec spec_;

  /// Prints and returns the errors (mm), coarsest first: at the corner for free faces, in the middle for plane strain.
  std::vector<double> table(Faces faces, int order, const std::vector<int>& sizes, double reference) {
    const bool is_free = faces == Faces::free;
    std::vector<double> errors;
    for (int n : sizes) {
      const CookTip tip = cook_tip_of_tetrahedra(spec_, faces, n, order);
      const double computed = (is_free ? tip.corner : tip.middle) / mm;
      errors.push_back(computed - reference);
      std::printf("Cook %s, %s tetrahedra %2d x %2d: tip %.4f mm reference %.4f difference %+.4f (%+.2f %%)", is_free ? "free faces" : "plane strain",
                  order == 1 ? "linear   " : "quadratic", n, n, computed, reference, errors.back(), 100 * errors.back() / reference);
      if (is_free) std::printf(", to the published 14.33 %+.2f %%", 100 * (computed / published_tip - 1));
      if (errors.size() > 1) std::printf(", order %.2f", observed_order(errors[errors.size() - 2], errors.back()));
      std::printf("\n");
      std::fflush(stdout);
    }
    return errors;
  }
  /// Of the solver's law by the independent hexahedra Q2 (mm).
  double reference(Faces faces, int n) const {
    const CookTip tip = cook_tip_of_hexahedra(spec_, VolumetricEnergy::solver, faces, n, 2);
    return (faces == Faces::free ? tip.corner : tip.middle) / mm;
  }
  void compare_with_published(int q1_up_to, int q2_up_to) {
    for (const Published& p : published) {
      if (p.n <= q1_up_to) {
        const double q1 = cook_tip_of_hexahedra(spec_, VolumetricEnergy::published, Faces::free, p.n, 1).corner / mm;
        std::printf("Cook hexahedra Q1 %2d: %.4f mm published %.2f difference %+.4f\n", p.n, q1, p.q1, q1 - p.q1);
        EXPECT_NEAR(q1, p.q1, 1.01 * printed_digit);
      }
      if (p.n <= q2_up_to) {
        const double q2 = cook_tip_of_hexahedra(spec_, VolumetricEnergy::published, Faces::free, p.n, 2).corner / mm;
        std::printf("Cook hexahedra Q2 %2d: %.4f mm published %.2f difference %+.4f\n", p.n, q2, p.q2, q2 - p.q2);
        EXPECT_NEAR(q2, p.q2, 1.01 * printed_digit);
      }
      std::fflush(stdout);
    }
  }
};

// The independent code must print the published table before it may serve as reference.
TEST_F(Cook, independent_hexahedra_print_the_published_table) { compare_with_published(16, 4); }

// kappa/2 (ln J)^2 and kappa/4 (J^2 - 1 - 2 ln J) agree to the second order of J - 1 and not beyond.
TEST_F(Cook, volumetric_energies_differ_by_a_quarter_of_a_per_cent) {
  const double ours = reference(Faces::held, 16);
  const double theirs = cook_tip_of_hexahedra(spec_, VolumetricEnergy::published, Faces::held, 16, 2).middle / mm;
  std::printf("Cook plane strain, Q2 16: (ln J)^2 %.4f mm, published energy %.4f mm, difference %+.4f mm (%+.3f %%)\n", ours, theirs, ours - theirs,
              100 * (ours - theirs) / theirs);
  EXPECT_NEAR(ours, theirs, 0.005 * theirs);
}

TEST_F(Cook, slab_with_free_faces_reaches_the_published_tip) {
  const double exact = reference(Faces::free, 8);
  const auto linear = table(Faces::free, 1, {8, 16, 32}, exact);
  EXPECT_GT(observed_order(linear[1], linear[2]), 1.4);
  EXPECT_LT(std::abs(linear.back()), 0.03 * exact);
  const auto quadratic = table(Faces::free, 2, {2, 4, 8}, exact);
  EXPECT_LT(std::abs(quadratic.back()), 0.01 * exact);
  EXPECT_NEAR(exact + quadratic.back(), published_tip, 0.01 * published_tip);
}

TEST_F(Cook, plane_strain_linear_tetrahedra_converge) {
  const double exact = reference(Faces::held, 32);
  const auto errors = table(Faces::held, 1, {4, 8, 16, 32}, exact);
  EXPECT_LT(std::abs(errors.back()), 0.03 * exact);  // triangles of constant strain in bending: 2.3 % at 32 x 32
  EXPECT_GT(observed_order(errors[2], errors[3]), 1.5);
}

TEST_F(Cook, plane_strain_quadratic_tetrahedra_converge) {
  const double exact = reference(Faces::held, 32);
  const auto errors = table(Faces::held, 2, {2, 4, 8, 16}, exact);
  EXPECT_LT(std::abs(errors.back()), 0.003 * exact);
  EXPECT_LT(std::abs(errors[3]), 0.5 * std::abs(errors[2]));  // the clamped corner is singular: no higher order
}

TEST_F(Cook, DISABLED_refined) {
  compare_with_published(32, 16);
  const double free_tip = reference(Faces::free, 16);
  const auto free_linear = table(Faces::free, 1, {8, 16, 32, 64}, free_tip);
  EXPECT_LT(std::abs(free_linear.back()), 0.01 * free_tip);
  const auto free_quadratic = table(Faces::free, 2, {2, 4, 8, 16}, free_tip);
  EXPECT_LT(std::abs(free_quadratic.back()), 0.005 * free_tip);
  const double exact = reference(Faces::held, 64);
  const auto linear = table(Faces::held, 1, {4, 8, 16, 32, 64}, exact);
  EXPECT_LT(std::abs(linear.back()), 0.01 * exact);
  const auto quadratic = table(Faces::held, 2, {2, 4, 8, 16, 32}, exact);
  EXPECT_LT(std::abs(quadratic.back()), 0.001 * exact);
}

}  // namespace
}  // namespace mv::test
