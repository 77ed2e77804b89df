// SPDX-License-Identifier: BSD-3-Clause
// Every law in uniaxial and equibiaxial tension and compression and in simple shear: a block of distorted elements against closed forms.
// The block's mean nominal stress is what its boundary forces give: P = 1/V sum of f (x) X.
//   ctest -L verification -V -R Homogeneous
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

#include "verification/slab_tissue.h"
#include "verification/solid/closed_forms.h"
#include "verification/solid/equilibrium.h"

namespace mv::test {
namespace {

constexpr double size = 2e-3;        // m, of the block
constexpr double tolerance = 1e-7;   // of the largest stress: what Newton's residual and the tangent's differences leave
constexpr double smallest_scale = 1.0;  // Pa, stresses below are compared absolutely

/// Block of 2 x 2 x 2 cells whose inner nodes are out of place, so that elements differ.
BoxMesh block(int order, const Vec3& fibre) {
  BoxSpec spec;
  spec.cells = {2, 2, 2};
  spec.order = order;
  spec.fibre = fibre;
  spec.place = [](const Vec3& p) {
    const auto bump = [](double s) { return std::sin(std::numbers::pi * s); };
    return Vec3(size * (p + bump(p.x()) * bump(p.y()) * bump(p.z()) * Vec3(0.13, -0.09, 0.11)));
  };
  return box_mesh(spec);
}

Mat3 mean_nominal(const BoxMesh& box, std::span<const double> inner_forces) {
  Mat3 P = Mat3::Zero();
  for (int n = 0; n < box.node_count(); ++n) P -= node(inner_forces, n) * node(box.mesh.points, n).transpose();
  return P / (size * size * size);
}

/// Nodes for which `is_held` are prescribed at F X; symmetry planes at the near sides where `is_symmetric`.
Mat3 stress_of_block(const Material& m, int order, const Vec3& fibre, const Mat3& F, int driven) {
  const BoxMesh box = block(order, fibre);
  LeafletSolid solid(box.mesh, {m});
  std::vector<double> start = box.mesh.points;
  for (int n = 0; n < box.node_count(); ++n) Vec3::Map(start.data() + 3 * n) = F * node(box.mesh.points, n);
  Constraints constraints(start);
  for (int n = 0; n < box.node_count(); ++n) {
    std::vector<Vec3> normals;
    for (int axis = 0; axis < 3; ++axis) {
      const bool is_boundary = box.is_on(n, axis, 0) || box.is_on(n, axis, 1);
      if (driven == 3 && is_boundary) normals = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
      if (box.is_on(n, axis, 0) || (is_boundary && axis < driven)) normals.push_back(Vec3::Unit(axis));
    }
    constraints.free_except(n, normals);
  }
  const auto forces = [&](std::span<const double> x, std::span<double> f) { solid.forces(x, f); };
  const double force_scale = ground_shear_modulus(m) + 1e3;
  const Equilibrium e = solve(constraints, box.mesh, forces, size / 4, 1e-12 * force_scale * size * size);
  EXPECT_TRUE(e.is_converged) << name_of(m.law) << " residual " << e.residual;
  EXPECT_EQ(solid.statistics().controlled_fraction, 0.0);
  std::vector<double> f(e.x.size(), 0.0);
  solid.forces(e.x, f);
  return mean_nominal(box, f);
}

/// Largest relative difference of the running test.
double worst = 0;
void compare(const char* mode, const Material& m, int order, double amount, const char* what, double computed, double reference, double scale) {
  const double difference = (computed - reference) / std::max(scale, smallest_scale);
  std::printf("%-12s %-12s order %d at %6.3f: %-4s computed %12.5f Pa reference %12.5f Pa difference %+.1e\n", name_of(m.law).c_str(), mode,
              order, amount, what, computed, reference, difference);
  EXPECT_NEAR(computed, reference, tolerance * std::max(scale, smallest_scale)) << name_of(m.law) << " " << mode << " " << amount;
  worst = std::max(worst, std::abs(difference));
}

class Homogeneous : public ::testing::TestWithParam<Law> {
 protected:
  OneThread one_thread_;
  void SetUp() override { worst = 0; }
  Material material() const {
    Material m;
    m.law = GetParam();
    m.has_modified_fibre_invariant = true;  // as mvsolve sets it
    return m;
  }
  /// Inside the laws' exponent and stretch limits and below distortion control.
  std::vector<double> stretches(int driven) const {
    switch (GetParam()) {
      case Law::neo_hookean: return {driven == 1 ? 0.7 : 0.85, 0.9, 1.1, 1.25, driven == 1 ? 1.5 : 1.4};
      case Law::ogden: return {0.9, 0.97, 1.03, 1.1, 1.2};
      default: return {0.95, 1.02, 1.05, 1.08, 1.10};
    }
  }
  void run_driven(const Material& m, int driven, int fibre_axis, const char* mode) {
    for (int order : {1, 2})
      for (double l : stretches(driven)) {
        const HomogeneousState s = driven_state(m, l, driven, fibre_axis);
        Mat3 F = Mat3::Identity();
        F.diagonal() = s.stretches.cwiseQuotient(Vec3(1, driven == 2 ? 1 : 1.004, 0.997));  // the free sides start out of place
        const Mat3 P = stress_of_block(m, order, Vec3::Unit(fibre_axis), F, driven);
        const double scale = s.nominal.cwiseAbs().maxCoeff();
        compare(mode, m, order, l, "P_xx", P(0, 0), s.nominal[0], scale);
        compare(mode, m, order, l, "P_yy", P(1, 1), s.nominal[1], scale);
        EXPECT_NEAR(P(2, 2), 0.0, tolerance * std::max(scale, smallest_scale));
        if (order == 1) {
          const double off = s.nominal[0] - s.incompressible;
          std::printf("%-12s %-12s          at %6.3f: incompressible form %12.5f Pa, off by %+.2e of it (bulk %.0f kPa)\n", name_of(m.law).c_str(),
                      mode, l, s.incompressible, off / s.incompressible, 1e-3 * m.bulk);
        }
      }
  }
};

TEST_P(Homogeneous, uniaxial) {
  run_driven(material(), 1, 0, "uniaxial");
  if (GetParam() != Law::neo_hookean && GetParam() != Law::ogden) run_driven(material(), 1, 1, "across");
  std::printf("%s uniaxial: largest difference %.1e of the largest stress\n", name_of(GetParam()).c_str(), worst);
}
TEST_P(Homogeneous, equibiaxial) {
  run_driven(material(), 2, 0, "equibiaxial");
  std::printf("%s equibiaxial: largest difference %.1e of the largest stress\n", name_of(GetParam()).c_str(), worst);
}
TEST_P(Homogeneous, simple_shear) {
  for (bool is_modified : {true, false}) {
    Material m = material();
    m.has_modified_fibre_invariant = is_modified;
    for (int order : {1, 2})
      for (double shear : {0.05, 0.15, 0.25}) {
        Mat3 F = Mat3::Identity();
        F(0, 2) = shear;
        const Mat3 P = stress_of_block(m, order, Vec3::UnitZ(), F, 3), reference = simple_shear_nominal(m, shear);
        const double scale = reference.cwiseAbs().maxCoeff();
        const char* mode = is_modified ? "shear" : "shear, own I4";
        compare(mode, m, order, shear, "P_xz", P(0, 2), reference(0, 2), scale);
        compare(mode, m, order, shear, "P_zz", P(2, 2), reference(2, 2), scale);
        compare(mode, m, order, shear, "P_xx", P(0, 0), reference(0, 0), scale);
      }
  }
  std::printf("%s simple shear: largest difference %.1e of the largest stress\n", name_of(GetParam()).c_str(), worst);
}

INSTANTIATE_TEST_SUITE_P(Laws, Homogeneous, ::testing::Values(Law::neo_hookean, Law::m1, Law::m2, Law::m3, Law::ogden, Law::hgo, Law::isotropic_exponential),
                         [](const auto& law) { return name_of(law.param); });

}  // namespace
}  // namespace mv::test
