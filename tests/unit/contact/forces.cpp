// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "geometry/core/errors.h"
#include "solver/contact/self_contact.h"
#include "unit/contact/shapes.h"

namespace mv::test {
namespace {

constexpr double mm = 1e-3;

ContactOptions plain_options() {
  ContactOptions o;
  o.threshold = 0.2 * mm;
  o.stiffness = 1e8;
  o.friction = 0;
  o.thickness = 0;
  o.exclusion_radius = 1e-9;  // the sheets of these tests are not joined
  return o;
}

/// How far p lies behind the triangle, if the foot of its perpendicular lies within; else 0.
double depth_behind(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = (b - a).cross(c - a), foot = p - normal * normal.dot(p - a) / normal.squaredNorm();
  for (const auto& [from, to] : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}})
    if (normal.dot((to - from).cross(foot - from)) < 0) return 0;
  return std::max(0.0, -normal.normalized().dot(p - a));
}

/// Two wavy sheets, the upper one turned and shifted, overlapping by varying amounts.
struct WavySheets {
  TriangleMesh mesh;
  std::vector<double> x, v;

  explicit WavySheets(double height, double amplitude = 0.15 * mm) {
    const auto identity = [](const Vec3& p) -> Vec3 { return p; };
    const Eigen::AngleAxisd turn(0.3, Vec3::UnitZ());
    mesh.add_sheet(12, 12, 6 * mm, 6 * mm, identity);
    const auto upper = mesh.add_sheet(
        11, 13, 6 * mm, 6 * mm, [&](const Vec3& p) -> Vec3 { return turn * p + Vec3(0.6 * mm, -0.5 * mm, height); }, true);
    x = mesh.x;
    v.resize(x.size());
    for (int n = 0; n < mesh.node_count(); ++n) {
      const Vec3 p = mesh.point(n);
      const double phase = n < upper[0] ? 0.0 : 1.3;
      x[3 * n + 2] += amplitude * std::sin(p[0] / (0.7 * mm) + phase) * std::cos(p[1] / (0.9 * mm) - phase);
      v[3 * n] = 0.3 * std::sin(p[1] / mm + phase);
      v[3 * n + 1] = 0.2 * std::cos(p[0] / mm - phase);
      v[3 * n + 2] = 0.1 * std::sin(3 * p[0] / mm) - phase * 0.1;
    }
    upper_begin = upper[0];
  }

  int upper_begin = 0;

  /// Largest depth of a node of one sheet behind a triangle of the other.
  double deepest() const {
    const auto at = [&](int n) { return Vec3(x[3 * n], x[3 * n + 1], x[3 * n + 2]); };
    double depth = 0;
    for (int n = 0; n < mesh.node_count(); ++n)
      for (const auto& t : mesh.triangles)
        if ((n < upper_begin) != (t[0] < upper_begin)) depth = std::max(depth, depth_behind(at(n), at(t[0]), at(t[1]), at(t[2])));
    return depth;
  }
};

TEST(ContactForces, a_node_beside_a_border_is_in_no_face) {
  // The upper sheet lies 0.1 mm below the lower one's plane, first over it, then beyond its border by less than the averaging radius: forces fade there, gaps go on.
  const double depth = 0.1 * mm;
  for (const auto& [beyond, expected] : {std::pair{-1 * mm, depth}, std::pair{0.05 * mm, 0.0}}) {
    TriangleMesh m;
    m.add_sheet(10, 10, 5 * mm, 5 * mm, [](const Vec3& p) -> Vec3 { return p; });
    m.add_sheet(4, 4, 2 * mm, 2 * mm, [&](const Vec3& p) -> Vec3 { return p + Vec3(5 * mm + beyond, 1.3 * mm, -depth); }, true);
    const auto s = contact_surface_from_triangles(m.x, m.triangles);
    SelfContact contact(s, plain_options());
    std::vector<double> forces(m.x.size(), 0.0), v(m.x.size(), 0.0);
    const auto result = contact.evaluate(m.x, v, 0, forces);
    EXPECT_GT(result.active_nodes, 0);
    EXPECT_NEAR(result.min_gap, -depth, 1e-15);
    EXPECT_NEAR(result.penetration_max, expected, 1e-15);
  }
}

TEST(ContactForces, action_equals_reaction_and_moments_balance_to_round_off) {
  WavySheets w(0.05 * mm);
  const auto s = contact_surface_from_triangles(w.mesh.x, w.mesh.triangles);
  for (double friction : {0.0, 0.2, 2.0}) {
    auto options = plain_options();
    options.friction = friction;
    SelfContact contact(s, options);
    ContactResult result;
    std::vector<double> forces;
    for (int step = 0; step < 5; ++step) {
      forces.assign(w.x.size(), 0.0);
      result = contact.evaluate(w.x, w.v, 1e-5, forces);
      const auto r = resultant(w.x, forces);
      EXPECT_LT(r.force.norm(), 1e-12 * r.force_scale);
      EXPECT_LT(r.moment.norm(), 1e-12 * r.moment_scale);
    }
    EXPECT_GT(result.active_nodes, 100);
    EXPECT_LT(result.min_gap, -0.05 * mm);
    EXPECT_NEAR(result.penetration_max, w.deepest(), 1e-15);
    EXPECT_EQ(result.friction_force > 0, friction > 0);
    for (int n = 0; n < s.node_count(); ++n) {
      for (int k = 0; k < 3; ++k) EXPECT_EQ(contact.nodal_force()[n][k], forces[3 * s.nodes[n] + k]);
    }
  }
}

TEST(ContactForces, are_minus_the_gradient_of_the_energy) {
  OneThread one_thread;
  for (const auto& [height, hardening] : {std::pair{0.17 * mm, 0.0}, std::pair{0.17 * mm, 20.0}, std::pair{0.0 * mm, 20.0}}) {
    WavySheets w(height, 0.08 * mm);  // gentle waves: every facing factor is 1, where the forces are the exact gradient
    const auto s = contact_surface_from_triangles(w.mesh.x, w.mesh.triangles);
    auto options = plain_options();
    options.hardening = hardening;
    SelfContact contact(s, options);
    std::vector<double> forces(w.x.size(), 0.0), scratch(w.x.size());
    const auto result = contact.evaluate(w.x, w.v, 0, forces);
    ASSERT_GT(result.active_nodes, 100);
    const double largest =
        std::abs(*std::max_element(forces.begin(), forces.end(), [](double a, double b) { return std::abs(a) < std::abs(b); }));
    std::mt19937 random(2);
    std::uniform_int_distribution<std::size_t> pick(0, w.x.size() - 1);
    int loaded = 0;
    for (int trial = 0; trial < 200; ++trial) {
      const std::size_t k = pick(random);
      const double h = 1e-9;
      auto x = w.x;
      x[k] += h;
      const double up = contact.evaluate(x, w.v, 0, scratch).potential_energy;
      x[k] -= 2 * h;
      const double down = contact.evaluate(x, w.v, 0, scratch).potential_energy;
      EXPECT_NEAR(forces[k], -(up - down) / (2 * h), 2e-6 * largest);
      loaded += std::abs(forces[k]) > 1e-3 * largest;
    }
    EXPECT_GT(loaded, 50);
  }
}

TEST(ContactForces, hardening_follows_the_stated_law_and_stays_linear_beyond_touching) {
  const double threshold = 0.2 * mm, hardening = 20;
  for (double g : {0.15 * mm, 0.05 * mm, 0.0, -0.05 * mm}) {
    TriangleMesh m;
    m.add_sheet(10, 9, 5 * mm, 4.5 * mm, [](const Vec3& p) -> Vec3 { return p; });
    const auto upper = m.add_sheet(
        7, 8, 3 * mm, 3 * mm, [&](const Vec3& p) -> Vec3 { return p + Vec3(0.8 * mm, 0.9 * mm, g); }, true);
    const auto s = contact_surface_from_triangles(m.x, m.triangles);
    auto options = plain_options();
    options.hardening = hardening;
    SelfContact contact(s, options);
    std::vector<double> forces(m.x.size(), 0.0), v(m.x.size(), 0.0);
    contact.evaluate(m.x, v, 0, forces);
    const double overlap = threshold - g, ratio = std::min(1.0, overlap / threshold);
    const double within = std::min(overlap, threshold), slope = 1 + 13 * hardening * std::pow(ratio, 12);
    const double expected = 1e8 * (within * (1 + hardening * std::pow(ratio, 12)) + slope * (overlap - within));
    EXPECT_NEAR(contact.pressure()[upper[0] + 30], expected, 1e-9 * expected) << g;
    EXPECT_NEAR(contact.tangent_stiffness(upper[0] + 30), 1e8 * slope * s.reference_area[upper[0] + 30], 1e-9 * slope) << g;
  }
}

TEST(ContactForces, nodes_of_a_rim_push_from_further_away) {
  const double g = 0.22 * mm, offset = 0.1 * mm;  // beyond the threshold of 0.2 mm
  TriangleMesh m;
  m.add_sheet(10, 9, 5 * mm, 4.5 * mm, [](const Vec3& p) -> Vec3 { return p; });
  const auto upper = m.add_sheet(7, 8, 3 * mm, 3 * mm, [&](const Vec3& p) -> Vec3 { return p + Vec3(0.8 * mm, 0.9 * mm, g); }, true);
  auto s = contact_surface_from_triangles(m.x, m.triangles);
  const int rim = upper[0] + 30;
  for (int r = s.ring_start[rim]; r < s.ring_start[rim + 1]; ++r) s.triangle_side[s.ring[r]] = 0;
  auto options = plain_options();
  options.border_offset = offset;
  SelfContact contact(s, options);
  std::vector<double> forces(m.x.size(), 0.0), v(m.x.size(), 0.0);
  contact.evaluate(m.x, v, 0, forces);
  EXPECT_NEAR(contact.normal_force()[rim], 1e8 * (0.2 * mm + offset - g) * s.reference_area[rim], 1e-10);
  EXPECT_EQ(contact.normal_force()[upper[0]], 0.0);
}

TEST(ContactForces, gap_is_exact_between_planes_in_any_position) {
  const Eigen::AngleAxisd turn(1.1, Vec3(1, -2, 0.5).normalized());
  const Vec3 shift(0.3, -0.1, 0.2);
  for (double g : {0.19 * mm, 0.05 * mm, 0.0, -0.12 * mm}) {
    TriangleMesh m;
    m.add_sheet(10, 9, 5 * mm, 4.5 * mm, [&](const Vec3& p) -> Vec3 { return turn * p + shift; });
    const auto upper = m.add_sheet(
        7, 8, 3 * mm, 3 * mm, [&](const Vec3& p) -> Vec3 { return turn * (p + Vec3(0.8 * mm, 0.9 * mm, g)) + shift; }, true);
    const auto s = contact_surface_from_triangles(m.x, m.triangles);
    SelfContact contact(s, plain_options());
    std::vector<double> forces(m.x.size(), 0.0), v(m.x.size(), 0.0);
    const auto result = contact.evaluate(m.x, v, 0, forces);
    ClosestGaps closest;
    contact.closest_gaps(m.x, 1 * mm, true, closest);
    EXPECT_NEAR(result.min_gap, g, 1e-15);
    for (int n = upper[0]; n < upper[1]; ++n) {
      EXPECT_NEAR(contact.gap()[n], g, 1e-15);
      EXPECT_NEAR(closest.gap[n], g, 1e-15);
      EXPECT_NEAR((contact.normal()[n] - turn * Vec3::UnitZ()).norm(), 0, 1e-10);
      EXPECT_NEAR(contact.normal_force()[n], 1e8 * (0.2 * mm - g) * s.reference_area[n], 1e-10);
      EXPECT_NEAR(contact.pressure()[n], 1e8 * (0.2 * mm - g), 1e-4);
    }
  }
}

TEST(ContactForces, flat_sheets_carry_stiffness_times_overlap_times_area_whatever_their_meshes) {
  const double overlap = 0.08 * mm, pressure = 1e8 * overlap;
  for (const auto& [nu, nv] : {std::pair{10, 10}, std::pair{13, 7}, std::pair{23, 17}}) {
    TriangleMesh m;
    const auto lower = m.add_sheet(10, 10, 5 * mm, 5 * mm, [](const Vec3& p) -> Vec3 { return p; });
    m.add_sheet(
        nu, nv, 5 * mm, 5 * mm, [&](const Vec3& p) -> Vec3 { return p + Vec3(0, 0, 0.2 * mm - overlap); }, true);
    const auto s = contact_surface_from_triangles(m.x, m.triangles);
    SelfContact contact(s, plain_options());
    std::vector<double> forces(m.x.size(), 0.0), v(m.x.size(), 0.0);
    const auto result = contact.evaluate(m.x, v, 0, forces);
    const double expected = pressure * 25 * mm * mm;
    EXPECT_NEAR(result.normal_force, expected, 1e-9 * expected);
    EXPECT_NEAR(result.contact_area, 25 * mm * mm, 1e-15);
    EXPECT_NEAR(result.potential_energy, 0.5 * expected * overlap, 1e-9 * expected * overlap);
    double carried = 0;  // what the lower sheet really receives
    for (int n = lower[0]; n < lower[1]; ++n) carried -= forces[3 * n + 2];
    EXPECT_NEAR(carried, expected, 1e-9 * expected);
  }
}

TEST(ContactForces, a_smaller_sheet_turned_on_a_larger_one_is_right_up_to_a_border_of_the_averaging_radius) {
  // Nodes of the larger sheet just outside the smaller one are pushed a little: the excess is a strip of at most R and falls with
  // h.
  const Eigen::AngleAxisd turn(0.35, Vec3::UnitZ());
  double previous = 1;
  for (int n : {12, 24, 48}) {
    const double h = 9 * mm / n;
    TriangleMesh m;
    m.add_sheet(n, n, 9 * mm, 9 * mm, [](const Vec3& p) -> Vec3 { return p; });
    m.add_sheet(
        2 * n / 3 - 1, 2 * n / 3 - 1, 5 * mm, 5 * mm,
        [&](const Vec3& p) -> Vec3 { return turn * (p - Vec3(2.5 * mm, 2.5 * mm, 0)) + Vec3(4.5 * mm, 4.5 * mm, 0.1 * mm); },
        true);
    const auto s = contact_surface_from_triangles(m.x, m.triangles);
    SelfContact contact(s, plain_options());
    std::vector<double> forces(m.x.size(), 0.0), v(m.x.size(), 0.0);
    const auto result = contact.evaluate(m.x, v, 0, forces);
    const double expected = 1e8 * 0.1 * mm * 25 * mm * mm;
    const double error = std::abs(result.normal_force / expected - 1);
    EXPECT_LT(error, 0.5 * (20 * mm * 0.35 * h) / (25 * mm * mm) + 0.01);
    EXPECT_LT(error, previous);
    previous = 0.75 * error;
  }
}

TEST(ContactForces, a_loaded_sheet_comes_to_rest_where_contact_carries_the_load) {
  // The upper sheet's nodes move along z only, under a pressure from above, with damping; the lower sheet is fixed.
  OneThread one_thread;
  TriangleMesh m;
  const auto lower = m.add_sheet(10, 10, 5 * mm, 5 * mm, [](const Vec3& p) -> Vec3 { return p; });
  const auto upper = m.add_sheet(
      13, 12, 5 * mm, 5 * mm, [](const Vec3& p) -> Vec3 { return p + Vec3(0, 0, 0.19 * mm); }, true);
  const auto s = contact_surface_from_triangles(m.x, m.triangles);
  const double pressure = 16e3;  // 120 mmHg
  auto options = plain_options();
  options.stiffness = pressure / (0.1 * mm);
  SelfContact contact(s, options);
  std::vector<double> x = m.x, v(x.size(), 0.0), forces(x.size());
  const double density = 1060 * 1 * mm, dt = 2e-5, damping = 2e4;
  ContactResult result;
  for (int step = 0; step < 2000; ++step) {
    std::fill(forces.begin(), forces.end(), 0.0);
    result = contact.evaluate(x, v, dt, forces);
    for (int n = upper[0]; n < upper[1]; ++n) {
      const double a = (forces[3 * n + 2] / s.reference_area[n] - pressure) / density;
      v[3 * n + 2] = (v[3 * n + 2] + dt * a) / (1 + dt * damping);
      x[3 * n + 2] += dt * v[3 * n + 2];
    }
  }
  const double load = pressure * 25 * mm * mm;
  double carried = 0;
  for (int n = lower[0]; n < lower[1]; ++n) carried -= forces[3 * n + 2];
  EXPECT_NEAR(carried, load, 1e-6 * load);
  EXPECT_NEAR(result.normal_force, load, 0.01 * load);  // the reported force against the applied one
}

TEST(ContactForces, an_impact_conserves_momentum_and_energy) {
  OneThread one_thread;
  // Two free sheets of springs hit each other without friction; velocity Verlet.
  TriangleMesh m;
  const auto lower = m.add_sheet(8, 8, 4 * mm, 4 * mm, [](const Vec3& p) -> Vec3 { return p; });
  const auto upper = m.add_sheet(
      9, 9, 4 * mm, 4 * mm, [](const Vec3& p) -> Vec3 { return p + Vec3(0.3 * mm, 0.2 * mm, 0.25 * mm + 0.05 * p[0]); }, true);
  const auto s = contact_surface_from_triangles(m.x, m.triangles);
  auto options = plain_options();
  options.stiffness = 4e8;
  options.exclusion_radius = 0;  // the sheets wrinkle: neighbours must not count
  SelfContact contact(s, options);
  std::vector<double> mass(s.nodes.size());
  for (std::size_t n = 0; n < mass.size(); ++n) mass[n] = 1.06 * s.reference_area[n];
  std::vector<std::pair<std::array<int, 2>, double>> springs;
  for (int n = 0; n < s.solid_nodes; ++n) {
    for (int e = s.edge_start[n]; e < s.edge_start[n + 1]; ++e) {
      if (s.edge_end[e] > n) springs.push_back({{n, s.edge_end[e]}, (m.point(n) - m.point(s.edge_end[e])).norm()});
    }
  }
  constexpr double spring = 300;  // N/m
  std::vector<double> x = m.x, v(x.size(), 0.0), forces(x.size());
  for (int n = 0; n < s.solid_nodes; ++n) v[3 * n + 2] = n < upper[0] ? 0.2 : -0.5;
  double elastic = 0;
  ContactResult result;
  const auto evaluate = [&] {
    std::fill(forces.begin(), forces.end(), 0.0);
    result = contact.evaluate(x, v, 0, forces);
    elastic = 0;
    for (const auto& [ends, rest] : springs) {
      auto a = Eigen::Map<Vec3>(x.data() + 3 * ends[0]), b = Eigen::Map<Vec3>(x.data() + 3 * ends[1]);
      const Vec3 d = b - a;
      const double stretch = d.norm() - rest;
      elastic += 0.5 * spring * stretch * stretch;
      const Vec3 f = spring * stretch / d.norm() * d;
      Eigen::Map<Vec3>(forces.data() + 3 * ends[0]) += f;
      Eigen::Map<Vec3>(forces.data() + 3 * ends[1]) -= f;
    }
  };
  const auto kinetic = [&] {
    double sum = 0;
    for (int n = 0; n < s.solid_nodes; ++n) sum += 0.5 * mass[n] * Eigen::Map<const Vec3>(v.data() + 3 * n).squaredNorm();
    return sum;
  };
  const auto momentum = [&] {
    Vec3 sum = Vec3::Zero();
    for (int n = 0; n < s.solid_nodes; ++n) sum += mass[n] * Eigen::Map<const Vec3>(v.data() + 3 * n);
    return sum;
  };
  evaluate();
  const double energy = kinetic() + elastic + result.potential_energy;
  const Vec3 before = momentum();
  const double dt = 2e-6;
  double contact_peak = 0, worst = 0;
  for (int step = 0; step < 1500; ++step) {
    for (int n = 0; n < s.solid_nodes; ++n)
      Eigen::Map<Vec3>(v.data() + 3 * n) += 0.5 * dt / mass[n] * Eigen::Map<const Vec3>(forces.data() + 3 * n);
    for (std::size_t k = 0; k < x.size(); ++k) x[k] += dt * v[k];
    evaluate();
    for (int n = 0; n < s.solid_nodes; ++n)
      Eigen::Map<Vec3>(v.data() + 3 * n) += 0.5 * dt / mass[n] * Eigen::Map<const Vec3>(forces.data() + 3 * n);
    contact_peak = std::max(contact_peak, result.potential_energy);
    worst = std::max(worst, std::abs(kinetic() + elastic + result.potential_energy - energy));
  }
  EXPECT_GT(contact_peak, 0.05 * energy);
  EXPECT_LT(worst, 2e-3 * energy);
  EXPECT_LT((momentum() - before).norm(), 1e-12 * before.norm());
  double rebound = 0;
  for (int n = lower[0]; n < lower[1]; ++n) rebound += v[3 * n + 2] / (lower[1] - lower[0]);
  EXPECT_LT(rebound, 0);  // the lower sheet was thrown back
}

/// Normal force of a node and total force on its small sheet while it slides across a master ridge or valley of two planes.
struct Slide {
  std::vector<double> normal;
  std::vector<Vec3> total;
};
Slide slide(double slope, int steps) {
  OneThread one_thread;
  TriangleMesh m;
  m.add_sheet(10, 6, 5 * mm, 3 * mm, [&](const Vec3& p) -> Vec3 { return {p[0], p[1], slope * std::abs(p[0] - 2.5 * mm)}; });
  const auto probe = m.add_sheet(
      1, 1, 0.4 * mm, 0.4 * mm, [](const Vec3& p) -> Vec3 { return p; }, true);
  const auto s = contact_surface_from_triangles(m.x, m.triangles);
  auto options = plain_options();
  options.threshold = 0.3 * mm;
  SelfContact contact(s, options);
  Slide history;
  std::vector<double> x = m.x, v(x.size(), 0.0), forces(x.size());
  for (int k = 0; k <= steps; ++k) {
    const double t = static_cast<double>(k) / steps;
    for (int n = probe[0]; n < probe[1]; ++n) {
      for (int c = 0; c < 3; ++c) x[3 * n + c] = m.x[3 * n + c];
      x[3 * n] += (1.2 + 2.0 * t) * mm;
      x[3 * n + 1] += (1.1 + 0.9 * t) * mm;
      x[3 * n + 2] = slope * std::abs(x[3 * n] - 2.5 * mm) + 0.1 * mm;
    }
    std::fill(forces.begin(), forces.end(), 0.0);
    contact.evaluate(x, v, 0, forces);
    history.normal.push_back(contact.normal_force()[probe[0]]);
    history.total.emplace_back(Vec3::Zero());
    for (int n = probe[0]; n < probe[1]; ++n) history.total.back() += Eigen::Map<const Vec3>(forces.data() + 3 * n);
  }
  return history;
}

TEST(ContactForces, change_continuously_when_a_node_slides_over_edges) {
  for (double slope : {-0.5, -0.2, 0.0, 0.2, 0.5}) {
    double previous_normal = 0, previous_total = 0;
    for (int steps : {1000, 4000}) {
      const Slide h = slide(slope, steps);
      double normal = 0, total = 0, largest = 0;
      for (std::size_t k = 1; k < h.normal.size(); ++k) {
        normal = std::max(normal, std::abs(h.normal[k] - h.normal[k - 1]));
        total = std::max(total, (h.total[k] - h.total[k - 1]).norm());
        largest = std::max(largest, h.normal[k]);
      }
      ASSERT_GT(largest, 0);
      if (previous_total > 0) {  // in the limit a quarter for a continuous force, one for a jump
        EXPECT_LT(normal, 0.35 * previous_normal + 1e-12 * largest) << "slope " << slope;
        EXPECT_LT(total, 0.35 * previous_total + 1e-12 * largest) << "slope " << slope;
      }
      EXPECT_LT(normal, 30.0 / steps * largest + 1e-12 * largest);
      previous_normal = normal;
      previous_total = total;
    }
  }
}

TEST(ContactForces, the_callers_node_stiffness_replaces_the_area_rule) {
  TriangleMesh m;
  m.add_sheet(6, 6, 3 * mm, 3 * mm, [](const Vec3& p) -> Vec3 { return p; });
  m.add_sheet(
      5, 5, 3 * mm, 3 * mm, [](const Vec3& p) -> Vec3 { return p + Vec3(0, 0, 0.1 * mm); }, true);
  const auto s = contact_surface_from_triangles(m.x, m.triangles);
  SelfContact contact(s, plain_options());
  std::vector<double> k(s.nodes.size());
  for (std::size_t n = 0; n < k.size(); ++n) k[n] = 100 + static_cast<double>(n);
  contact.set_node_stiffness(k);
  std::vector<double> forces(m.x.size(), 0.0), v(m.x.size(), 0.0);
  contact.evaluate(m.x, v, 0, forces);
  for (std::size_t n = 0; n < k.size(); ++n) EXPECT_NEAR(contact.normal_force()[n], k[n] * 0.1 * mm, 1e-9);
  EXPECT_THROW(contact.set_node_stiffness(std::span<const double>(k.data(), 3)), InputError);
  contact.set_node_stiffness({});
  contact.evaluate(m.x, v, 0, forces);
  EXPECT_NEAR(contact.normal_force()[0], 1e8 * s.reference_area[0] * 0.1 * mm, 1e-9);
}

TEST(ContactForces, positions_that_are_not_finite_stop_the_run) {
  WavySheets w(0.15 * mm);
  const auto s = contact_surface_from_triangles(w.mesh.x, w.mesh.triangles);
  SelfContact contact(s, plain_options());
  std::vector<double> forces(w.x.size(), 0.0);
  contact.evaluate(w.x, w.v, 0, forces);
  auto x = w.x;
  x[3 * 20 + 1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(contact.evaluate(x, w.v, 0, forces), TrustError);
}

TEST(ContactForces, meaningless_options_are_refused) {
  WavySheets w(0.15 * mm);
  const auto s = contact_surface_from_triangles(w.mesh.x, w.mesh.triangles);
  for (auto change : {+[](ContactOptions& o) { o.threshold = 0; }, +[](ContactOptions& o) { o.friction = -1; },
                      +[](ContactOptions& o) { o.stiffness = std::nan(""); }, +[](ContactOptions& o) { o.skin = -1; }}) {
    auto options = plain_options();
    change(options);
    EXPECT_THROW(SelfContact(s, options), InputError);
  }
}

}  // namespace
}  // namespace mv::test
