// SPDX-License-Identifier: BSD-3-Clause
#include "solver/solid/leaflet_solid.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <numeric>

#include "geometry/core/errors.h"
#include "geometry/core/parallel.h"
#include "unit/solid/samples.h"

using namespace mv;
using namespace mv::solid_test;

namespace {

LeafletSolid make_solid(Law law, bool is_quadratic, int n = 3) {
  Material first = material_of(law), second = first;
  second.bulk *= 1.5;
  return LeafletSolid(block_mesh(n, n, 2, 0.5e-3, is_quadratic), {first, second});
}

Mat3 moderate() { return (Mat3() << 1.06, 0.05, 0.02, -0.03, 0.97, 0.04, 0.01, -0.02, 1.02).finished(); }

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}
double norm(const std::vector<double>& a) { return std::sqrt(dot(a, a)); }

/// Shape functions of the tetrahedron and their barycentric derivatives, written independently of the library.
std::vector<Vec3> shape_gradients(int nodes, const Eigen::Vector4d& L) {
  const Vec3 dL[4] = {{-1, -1, -1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  std::vector<Vec3> d;
  for (int a = 0; a < 4; ++a) d.push_back(nodes == 4 ? dL[a] : Vec3((4 * L[a] - 1) * dL[a]));
  const int edges[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};
  for (int e = 0; nodes == 10 && e < 6; ++e)
    d.push_back(4 * (L[edges[e][0]] * dL[edges[e][1]] + L[edges[e][1]] * dL[edges[e][0]]));
  return d;
}

/// The slow obvious assembly: element by element, point by point, with the single-point law.
double plain_forces(const LeafletSolid& solid, const std::vector<double>& x, std::vector<double>& f, long& controlled) {
  const SolidMesh& mesh = solid.mesh();
  const int N = mesh.nodes_per_tet, points = N == 10 ? 4 : 1;
  const double near = (5 - std::sqrt(5.0)) / 20;
  double energy = 0;
  controlled = 0;
  for (long e = 0; e < solid.element_count(); ++e) {
    bool is_controlled = false;
    for (int q = 0; q < points; ++q) {
      Eigen::Vector4d L = Eigen::Vector4d::Constant(N == 10 ? near : 0.25);
      if (N == 10) L[q] = 1 - 3 * near;
      const std::vector<Vec3> dN = shape_gradients(N, L);
      Mat3 reference = Mat3::Zero(), current = Mat3::Zero();
      for (int a = 0; a < N; ++a) {
        reference += node(mesh.points, mesh.tets[e * N + a]) * dN[a].transpose();
        current += node(x, mesh.tets[e * N + a]) * dN[a].transpose();
      }
      const Mat3 inverse = reference.inverse();
      const double weight = reference.determinant() / (6.0 * points);
      const Vec3 fibre(mesh.fibres[3 * e], mesh.fibres[3 * e + 1], mesh.fibres[3 * e + 2]);
      const StressPoint p = evaluate(solid.materials()[mesh.material[e]], current * inverse, fibre);
      energy += weight * p.energy;
      is_controlled = is_controlled || p.is_controlled;
      for (int a = 0; a < N; ++a) {
        const Vec3 force = -weight * p.first_piola * inverse.transpose() * dN[a];
        for (int i = 0; i < 3; ++i) f[3 * mesh.tets[e * N + a] + i] += force[i];
      }
    }
    controlled += is_controlled;
  }
  return energy;
}

TEST(leaflet_solid, block_kernels_agree_with_plain_assembly) {
  for (Law law : all_laws)
    for (bool is_quadratic : {false, true}) {
      LeafletSolid solid = make_solid(law, is_quadratic);
      for (double noise : {8e-6, 2e-4}) {   // the second one inverts some elements and calls distortion control
        const std::vector<double> x = deformed(solid.mesh(), moderate(), noise, 5);
        std::vector<double> f(x.size(), 0.0), expected(x.size(), 0.0);
        long controlled = 0;
        const double energy = solid.forces(x, f), expected_energy = plain_forces(solid, x, expected, controlled);
        EXPECT_NEAR(energy, expected_energy, 1e-11 * expected_energy) << name_of(law);
        double difference = 0;
        for (std::size_t i = 0; i < f.size(); ++i) difference = std::max(difference, std::abs(f[i] - expected[i]));
        EXPECT_LT(difference, 1e-10 * norm(expected)) << name_of(law) << is_quadratic;
        EXPECT_EQ(controlled > 0, noise > 1e-4);
        EXPECT_EQ(solid.statistics().controlled_fraction, static_cast<double>(controlled) / static_cast<double>(solid.element_count()));
      }
    }
}

TEST(leaflet_solid, forces_are_added_and_vanish_in_the_reference_state) {
  for (bool is_quadratic : {false, true}) {
    LeafletSolid solid = make_solid(Law::m1, is_quadratic);
    std::vector<double> f(solid.mesh().points.size(), 7.0);
    EXPECT_NEAR(solid.forces(solid.mesh().points, f), 0, 1e-18);
    for (double v : f) EXPECT_NEAR(v, 7.0, 1e-12);
    EXPECT_NEAR(solid.statistics().J_min, 1, 1e-12);
    EXPECT_NEAR(solid.statistics().J_max, 1, 1e-12);
    EXPECT_EQ(solid.statistics().controlled_fraction, 0);
  }
}

/// An affine boundary displacement must give the homogeneous stress: no force on inner nodes, and energy density times volume.
TEST(leaflet_solid, patch_test_linear_and_quadratic) {
  for (Law law : all_laws)
    for (bool is_quadratic : {false, true}) {
      SolidMesh mesh = block_mesh(3, 3, 3, 1e-3, is_quadratic);
      Samples samples(3);
      for (std::size_t e = 0; e < mesh.material.size(); ++e) {
        mesh.material[e] = 0;
        for (int i = 0; i < 3; ++i) mesh.fibres[3 * e + i] = i == 1;
      }
      // corner nodes inside are moved so that no two elements are alike; midpoints follow
      const std::vector<double> regular = mesh.points;
      auto is_inner = [&](long n) {
        const Vec3 p = node(regular, n);
        return p.minCoeff() > 1e-9 && p.maxCoeff() < 3e-3 - 1e-9;
      };
      for (long n = 0; n < 64; ++n)
        for (int i = 0; i < 3 && is_inner(n); ++i) mesh.points[3 * n + i] += 1e-4 * samples.normal();
      const int edges[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};
      for (std::size_t e = 0; is_quadratic && e < mesh.material.size(); ++e)
        for (int s = 0; s < 6; ++s)
          for (int i = 0; i < 3; ++i)
            mesh.points[3 * mesh.tets[10 * e + 4 + s] + i] = 0.5 * (mesh.points[3 * mesh.tets[10 * e + edges[s][0]] + i] +
                                                                    mesh.points[3 * mesh.tets[10 * e + edges[s][1]] + i]);
      LeafletSolid solid(mesh, {material_of(law)});
      const Mat3 F = moderate();
      const std::vector<double> x = deformed(mesh, F, 0, 1);
      std::vector<double> f(x.size(), 0.0);
      const double volume = 27e-9;
      const double energy = solid.forces(x, f), density = energy_density(material_of(law), F, Vec3::UnitY());
      EXPECT_NEAR(energy, density * volume, 1e-11 * density * volume);
      EXPECT_NEAR(solid.statistics().volume, F.determinant() * volume, 1e-12 * volume);
      int inner = 0;
      double largest = 0;
      for (double v : f) largest = std::max(largest, std::abs(v));
      for (long n = 0; n < solid.node_count(); ++n)
        if (is_inner(n)) {
          ++inner;
          EXPECT_LT(node(f, n).norm(), 1e-11 * largest) << name_of(law);
        }
      EXPECT_GE(inner, 8);
      // the side x = 3 mm carries P e_x times its area
      Vec3 side = Vec3::Zero();
      for (long n = 0; n < solid.node_count(); ++n)
        if (regular[3 * n] > 3e-3 - 1e-9 && regular[3 * n + 1] > 1e-9 && regular[3 * n + 1] < 3e-3 - 1e-9 &&
            regular[3 * n + 2] > 1e-9 && regular[3 * n + 2] < 3e-3 - 1e-9)
          side += node(f, n);
      const Vec3 traction = first_piola(material_of(law), F, Vec3::UnitY()).col(0);
      EXPECT_LT(side.cross(traction).norm(), 1e-9 * side.norm() * traction.norm());
      EXPECT_LT(side.dot(traction), 0);
    }
}

TEST(leaflet_solid, forces_sum_to_zero_force_and_moment) {
  for (Law law : all_laws)
    for (bool is_quadratic : {false, true}) {
      LeafletSolid solid = make_solid(law, is_quadratic);
      const std::vector<double> x = deformed(solid.mesh(), moderate(), 3e-5, 2);
      std::vector<double> f(x.size(), 0.0);
      solid.forces(x, f);
      Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
      double scale = 0;
      for (long n = 0; n < solid.node_count(); ++n) {
        force += node(f, n);
        moment += node(x, n).cross(node(f, n));
        scale += node(f, n).norm();
      }
      EXPECT_GT(scale, 1e-6);
      EXPECT_LT(force.norm(), 1e-12 * scale);
      EXPECT_LT(moment.norm(), 1e-14 * scale);   // lever arms are millimetres
    }
}

TEST(leaflet_solid, forces_are_slope_of_energy) {
  for (Law law : all_laws)
    for (bool is_quadratic : {false, true}) {
      LeafletSolid solid = make_solid(law, is_quadratic);
      Samples samples(4);
      const std::vector<double> x = deformed(solid.mesh(), moderate(), 8e-6, 2);
      std::vector<double> f(x.size(), 0.0), unused(x.size());
      solid.forces(x, f);
      for (int n = 0; n < 5; ++n) {
        std::vector<double> direction(x.size()), y(x.size());
        for (double& d : direction) d = samples.normal();
        const double h = 5e-9;
        auto energy_at = [&](double s) {
          for (std::size_t i = 0; i < x.size(); ++i) y[i] = x[i] + s * direction[i];
          return solid.forces(y, unused);
        };
        const double slope = (8 * (energy_at(h) - energy_at(-h)) - (energy_at(2 * h) - energy_at(-2 * h))) / (12 * h);
        EXPECT_NEAR(-dot(f, direction), slope, 2e-7 * norm(f) * norm(direction)) << name_of(law) << is_quadratic;
      }
    }
}

TEST(leaflet_solid, results_do_not_depend_on_thread_count) {
  const int threads = thread_count();
  for (Law law : {Law::m1, Law::ogden})
    for (bool is_quadratic : {false, true}) {
      LeafletSolid solid = make_solid(law, is_quadratic, 12);
      const std::vector<double> x = deformed(solid.mesh(), moderate(), 1e-4, 2);
      std::vector<double> f[3], k[3];
      double energy[3], step[3], J_min[3];
      for (int run = 0; run < 3; ++run) {
        set_thread_count(run + 1);
        f[run].assign(x.size(), 0.0);
        k[run].assign(x.size(), 0.0);
        energy[run] = solid.forces(x, f[run]);
        J_min[run] = solid.statistics().J_min;
        solid.forces_directional(x, f[run], k[run]);
        step[run] = solid.critical_step(x);
      }
      set_thread_count(threads);
      for (int run = 1; run < 3; ++run) {
        EXPECT_EQ(f[0], f[run]);
        EXPECT_EQ(k[0], k[run]);
        EXPECT_EQ(energy[0], energy[run]);
        EXPECT_EQ(step[0], step[run]);
        EXPECT_EQ(J_min[0], J_min[run]);
      }
    }
}

TEST(leaflet_solid, directional_stiffness_is_symmetric_and_linear) {
  for (Law law : all_laws)
    for (bool is_quadratic : {false, true}) {
      LeafletSolid solid = make_solid(law, is_quadratic);
      Samples samples(6);
      const std::vector<double> x = deformed(solid.mesh(), moderate(), 1e-5, 2);
      std::vector<double> v(x.size()), w(x.size()), Kv(x.size()), Kw(x.size()), K3v(x.size());
      for (double& c : v) c = samples.normal();
      for (double& c : w) c = samples.normal();
      solid.forces_directional(x, v, Kv);
      std::vector<double> at_x(x.size(), 0.0), one_sided(x.size());
      solid.forces(x, at_x);
      solid.forces_directional(x, at_x, v, one_sided);
      double error = 0, size = 0;
      for (std::size_t a = 0; a < x.size(); ++a) error += std::pow(one_sided[a] - Kv[a], 2), size += Kv[a] * Kv[a];
      EXPECT_LT(std::sqrt(error), 1e-3 * std::sqrt(size)) << "forward difference";
      solid.forces_directional(x, w, Kw);
      EXPECT_NEAR(dot(w, Kv), dot(v, Kw), 1e-6 * norm(v) * norm(Kw)) << name_of(law) << is_quadratic;
      for (double& c : v) c *= 3;
      solid.forces_directional(x, v, K3v);
      for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(K3v[i], 3 * Kv[i], 1e-6 * norm(Kv));
      // against a wider difference of the force
      std::vector<double> plus = x, minus = x, f_plus(x.size(), 0.0), f_minus(x.size(), 0.0);
      const double h = 1e-8;
      for (std::size_t i = 0; i < x.size(); ++i) plus[i] += h * w[i], minus[i] -= h * w[i];
      solid.forces(plus, f_plus);
      solid.forces(minus, f_minus);
      for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(Kw[i], (f_minus[i] - f_plus[i]) / (2 * h), 1e-4 * norm(Kw));
    }
}

TEST(leaflet_solid, no_rigid_motion_has_stiffness_in_the_reference_state) {
  LeafletSolid solid = make_solid(Law::m1, true);
  const std::vector<double>& x = solid.mesh().points;
  std::vector<double> v(x.size()), w(x.size()), Kv(x.size()), Kw(x.size());
  Samples samples(1);
  for (long n = 0; n < solid.node_count(); ++n) {
    const Vec3 rotation = Vec3(0.3, -0.5, 0.8).cross(node(x, n)) + Vec3(1e-3, 2e-3, 0);
    for (int i = 0; i < 3; ++i) v[3 * n + i] = rotation[i], w[3 * n + i] = 1e-3 * samples.normal();
  }
  solid.forces_directional(x, v, Kv);
  solid.forces_directional(x, w, Kw);
  EXPECT_LT(norm(Kv), 1e-6 * norm(Kw));
}

TEST(leaflet_solid, lumped_masses_are_positive_and_sum_to_the_total) {
  for (bool is_quadratic : {false, true}) {
    SolidMesh mesh = block_mesh(4, 3, 2, 0.5e-3, is_quadratic);
    Material light, heavy;
    light.density = 1000;
    heavy.density = 1100;
    LeafletSolid solid(mesh, {light, heavy});
    const double volume = 24 * std::pow(0.5e-3, 3);
    const auto sum = [](const std::vector<double>& a) { return std::accumulate(a.begin(), a.end(), 0.0); };
    EXPECT_NEAR(sum(solid.node_volumes()), volume, 1e-12 * volume);
    EXPECT_NEAR(sum(solid.element_volumes()), volume, 1e-12 * volume);
    EXPECT_NEAR(sum(solid.node_masses()), 1050 * volume, 1e-9 * volume);
    for (double m : solid.node_masses()) EXPECT_GT(m, 0);
    EXPECT_EQ(solid.mesh().tets.size() / mesh.nodes_per_tet, static_cast<std::size_t>(solid.element_count()));
  }
}

/// HRZ shares against the consistent mass integrated with a rule of high degree (collapsed Gauss points).
TEST(leaflet_solid, quadratic_mass_shares_are_those_of_the_consistent_diagonal) {
  const double g[4] = {0.06943184420297371, 0.33000947820757187, 0.6699905217924281, 0.9305681557970263};
  const double w[4] = {0.17392742256872693, 0.32607257743127307, 0.32607257743127307, 0.17392742256872693};
  double corner = 0, middle = 0;
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < 4; ++b)
      for (int c = 0; c < 4; ++c) {
        const double u = g[a], v = g[b] * (1 - u), t = g[c] * (1 - u - v);
        const double weight = w[a] * w[b] * (1 - u) * w[c] * (1 - u - v);
        corner += weight * std::pow(u * (2 * u - 1), 2);
        middle += weight * std::pow(4 * u * v, 2);
        (void)t;
      }
  const double total = 4 * corner + 6 * middle;
  SolidMesh mesh;
  mesh.nodes_per_tet = 10;
  mesh.points = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, .5, 0, 0, .5, .5, 0, 0, .5, 0, 0, 0, .5, .5, 0, .5, 0, .5, .5};
  mesh.tets = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
  mesh.fibres = {1, 0, 0};
  mesh.material = {0};
  LeafletSolid solid(mesh, {Material{}});
  for (int n = 0; n < 10; ++n) EXPECT_NEAR(solid.node_volumes()[n], (n < 4 ? corner : middle) / total / 6, 1e-12);
}

/// 2 / sqrt(largest eigenvalue of M_e^-1 K_e) of every element, from a dense matrix built column by column.
TEST(leaflet_solid, critical_step_is_that_of_the_dense_element_matrices) {
  for (Law law : {Law::m1, Law::neo_hookean, Law::ogden})
    for (bool is_quadratic : {false, true}) {
      const LeafletSolid solid_all = make_solid(law, is_quadratic, 2);
      const SolidMesh& mesh = solid_all.mesh();
      const int N = mesh.nodes_per_tet;
      const std::vector<double> x = deformed(mesh, moderate(), 2e-5, 7);
      LeafletSolid whole = make_solid(law, is_quadratic, 2);
      std::vector<double> steps(static_cast<std::size_t>(whole.element_count()));
      const double smallest = whole.critical_step(x, steps);
      double dense_smallest = 1;
      for (long e = 0; e < whole.element_count(); ++e) {
        SolidMesh one;
        one.nodes_per_tet = N;
        std::vector<double> xe;
        for (int a = 0; a < N; ++a) {
          const int n = mesh.tets[e * N + a];
          one.tets.push_back(a);
          one.points.insert(one.points.end(), mesh.points.begin() + 3 * n, mesh.points.begin() + 3 * n + 3);
          xe.insert(xe.end(), x.begin() + 3 * n, x.begin() + 3 * n + 3);
        }
        one.fibres.assign(mesh.fibres.begin() + 3 * e, mesh.fibres.begin() + 3 * e + 3);
        one.material = {mesh.material[e]};
        LeafletSolid single(one, whole.materials());
        Eigen::MatrixXd A(3 * N, 3 * N);
        for (int i = 0; i < 3 * N; ++i) {
          std::vector<double> unit(3 * N, 0.0), column(3 * N);
          unit[i] = 1;
          single.forces_directional(xe, unit, column);
          for (int j = 0; j < 3 * N; ++j)
            A(j, i) = column[j] / std::sqrt(single.node_masses()[i / 3] * single.node_masses()[j / 3]);
        }
        const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(0.5 * (A + A.transpose())).eigenvalues();
        const double dense = 2 / std::sqrt(values.cwiseAbs().maxCoeff());
        dense_smallest = std::min(dense_smallest, dense);
        EXPECT_GT(steps[e], 0.999 * dense) << name_of(law) << is_quadratic;
        EXPECT_LT(steps[e], 1.10 * dense) << name_of(law) << is_quadratic;
      }
      EXPECT_NEAR(smallest, dense_smallest, 0.05 * dense_smallest);
    }
}

/// Explicit central differences about a state of tension: bounded just below the estimate, growing well above the assembled
/// limit.
TEST(leaflet_solid, critical_step_keeps_explicit_integration_stable) {
  for (bool is_quadratic : {false, true}) {
    LeafletSolid solid = make_solid(Law::neo_hookean, is_quadratic, 2);
    const double critical = solid.critical_step(solid.mesh().points);
    auto final_energy = [&](double dt) {
      std::vector<double> x = deformed(solid.mesh(), Mat3::Identity(), 1e-8, 3), v(x.size(), 0.0), f(x.size());
      double energy = 0;
      for (int n = 0; n < 400; ++n) {
        std::fill(f.begin(), f.end(), 0.0);
        energy = solid.forces(x, f);
        for (std::size_t i = 0; i < x.size(); ++i) v[i] += dt * f[i] / solid.node_masses()[i / 3], x[i] += dt * v[i];
      }
      return energy;
    };
    std::vector<double> f(solid.mesh().points.size(), 0.0);
    const double start = solid.forces(deformed(solid.mesh(), Mat3::Identity(), 1e-8, 3), f);
    EXPECT_LT(final_energy(0.9 * critical), 5 * start);
    EXPECT_FALSE(final_energy(3.0 * critical) < 100 * start);   // grows, or is not a number any more
  }
}

TEST(leaflet_solid, bad_meshes_are_refused_by_name) {
  const SolidMesh good = block_mesh(1, 1, 1, 1e-3, false);
  auto message = [](const SolidMesh& mesh, Material m = {}) -> std::string {
    try {
      LeafletSolid(mesh, {m, m});
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(message(good), "accepted");
  SolidMesh bad = good;
  std::swap(bad.tets[8], bad.tets[9]);
  EXPECT_NE(message(bad).find("element 2 has a reference Jacobian"), std::string::npos) << message(bad);
  bad = good;
  bad.tets[5] = 99;
  EXPECT_NE(message(bad).find("refers to point 99"), std::string::npos);
  bad = good;
  bad.fibres[4] = 3;
  EXPECT_NE(message(bad).find("fibre of leaflet element 1"), std::string::npos);
  bad = good;
  bad.material[3] = 7;
  EXPECT_NE(message(bad).find("element 3 has no material"), std::string::npos);
  bad = good;
  bad.points[4] = std::nan("");
  EXPECT_NE(message(bad).find("not finite"), std::string::npos);
  Material m;
  m.bulk = 0;
  EXPECT_NE(message(good, m).find("bulk"), std::string::npos);
}

TEST(leaflet_solid, positions_that_are_not_finite_are_flagged) {
  LeafletSolid solid = make_solid(Law::m1, false);
  std::vector<double> x = solid.mesh().points, f(x.size(), 0.0);
  x[10] = std::nan("");
  solid.forces(x, f);
  EXPECT_FALSE(solid.statistics().is_finite);
  solid.forces(solid.mesh().points, f);
  EXPECT_TRUE(solid.statistics().is_finite);
}

TEST(leaflet_solid, leaflet_mesh_becomes_metres_with_the_anterior_material_first) {
  LeafletMesh leaflets;
  leaflets.points = {Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 2, 0), Vec3(0, 0, 2), Vec3(2, 2, 2)};
  leaflets.tets = {{0, 1, 2, 3, -1, -1, -1, -1, -1, -1}, {1, 2, 3, 4, -1, -1, -1, -1, -1, -1}};
  leaflets.region = {Region::anterior, Region::posterior};
  leaflets.fibre = {Vec3::UnitX(), Vec3::UnitY()};
  const SolidMesh mesh = to_solid_mesh(leaflets);
  EXPECT_EQ(mesh.nodes_per_tet, 4);
  EXPECT_DOUBLE_EQ(mesh.points[3], 2e-3);
  EXPECT_EQ(mesh.material, (std::vector<int>{0, 1}));
  EXPECT_EQ(mesh.tets, (std::vector<int>{0, 1, 2, 3, 1, 2, 3, 4}));
  EXPECT_EQ(mesh.fibres[4], 1.0);
}

}   // namespace
