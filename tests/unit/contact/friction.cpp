// SPDX-License-Identifier: BSD-3-Clause
// A rigid block of surface nodes on a fixed plane: stick, slip and what friction costs.
#include <gtest/gtest.h>

#include <cmath>

#include "solver/contact/self_contact.h"
#include "unit/contact/shapes.h"

namespace mv::test {
namespace {

constexpr double mm = 1e-3;
constexpr double gravity = 9.81;

struct Incline {
  OneThread one_thread;
  TriangleMesh mesh;
  std::array<int, 2> block{};
  ContactSurface surface;
  ContactOptions options;
  std::vector<double> x, v, forces;
  Vec3 velocity = Vec3::Zero(), moved = Vec3::Zero();
  double mass = 1e-4, dissipated = 0;
  Eigen::AngleAxisd turn{0.8, Vec3(0.3, 1, -0.2).normalized()};  // the plane lies anywhere in space

  Incline() {
    mesh.add_sheet(40, 10, 20 * mm, 5 * mm, [&](const Vec3& p) -> Vec3 { return turn * p; });
    block = mesh.add_sheet(
        6, 5, 2.6 * mm, 2.2 * mm, [&](const Vec3& p) -> Vec3 { return turn * (p + Vec3(3 * mm, 1.3 * mm, 0.2 * mm)); }, true);
    surface = contact_surface_from_triangles(mesh.x, mesh.triangles);
    options.threshold = 0.2 * mm;
    options.stiffness = 5e6;
    options.friction = 0.3;
    options.thickness = 0;
    options.exclusion_radius = 1e-9;
    x = mesh.x;
    v.assign(x.size(), 0.0);
    forces.assign(x.size(), 0.0);
  }

  /// Moves the block as a rigid body without rotation under gravity tilted by `angle`; the normal motion is damped.
  ContactResult run(SelfContact& contact, double angle, int steps, double dt) {
    const Vec3 along = turn * Vec3::UnitX(), up = turn * Vec3::UnitZ();
    const Vec3 g = gravity * (std::sin(angle) * along - std::cos(angle) * up);
    ContactResult result;
    for (int step = 0; step < steps; ++step) {
      std::fill(forces.begin(), forces.end(), 0.0);
      result = contact.evaluate(x, v, dt, forces);
      dissipated += result.friction_dissipation;
      Vec3 total = mass * g;
      for (int n = block[0]; n < block[1]; ++n) total += Eigen::Map<const Vec3>(forces.data() + 3 * n);
      velocity += dt / mass * total;
      velocity -= up * (up.dot(velocity) * dt * 2e3 / (1 + dt * 2e3));
      moved += dt * velocity;
      for (int n = block[0]; n < block[1]; ++n) {
        Eigen::Map<Vec3>(v.data() + 3 * n) = velocity;
        Eigen::Map<Vec3>(x.data() + 3 * n) += dt * velocity;
      }
    }
    return result;
  }
};

TEST(ContactFriction, holds_below_the_friction_angle) {
  Incline s;
  SelfContact contact(s.surface, s.options);
  const double angle = 0.8 * std::atan(0.3);
  s.run(contact, angle, 2000, 2e-5);  // it starts clear of the plane and comes down first
  const Vec3 along = s.turn * Vec3::UnitX();
  const double settled = s.moved.dot(along);
  double loss = s.dissipated;
  const auto result = s.run(contact, angle, 6000, 2e-5);
  loss = s.dissipated - loss;
  const double weight = s.mass * gravity;
  EXPECT_NEAR(result.normal_force, weight * std::cos(angle), 0.06 * weight);
  // Without friction it would slide more than 10 mm in these 0.12 s. It swings within the elastic slip, mu * overlap / ratio each
  // way.
  const double overlap = s.options.threshold - result.min_gap;
  EXPECT_LT(std::abs(s.moved.dot(along) - settled), 2 * 0.3 * overlap / s.options.tangential_ratio);
  EXPECT_LT(loss, 0.01 * weight * 1 * mm);
  EXPECT_GT(result.friction_energy, 0.0);
}

TEST(ContactFriction, slides_above_the_friction_angle_with_the_coulomb_force) {
  Incline s;
  SelfContact contact(s.surface, s.options);
  const double angle = 2.0 * std::atan(0.3);
  const Vec3 along = s.turn * Vec3::UnitX();
  s.run(contact, angle, 3000, 1e-5);  // settle on the plane
  const double speed = s.velocity.dot(along), dissipated = s.dissipated, path = s.moved.dot(along);
  const int steps = 3000;
  const auto result = s.run(contact, angle, steps, 1e-5);
  const double acceleration = (s.velocity.dot(along) - speed) / (steps * 1e-5);
  const double expected = gravity * (std::sin(angle) - 0.3 * std::cos(angle));
  EXPECT_NEAR(acceleration, expected, 0.01 * expected);
  EXPECT_NEAR(result.friction_force, 0.3 * result.normal_force, 1e-9 * result.normal_force);
  const double slid = s.moved.dot(along) - path;
  EXPECT_NEAR(s.dissipated - dissipated, 0.3 * s.mass * gravity * std::cos(angle) * slid, 0.02 * s.mass * gravity * slid);
  for (int n = s.block[0]; n < s.block[1]; ++n) {
    const Vec3 f = contact.friction_force()[n];
    EXPECT_NEAR(f.norm(), 0.3 * contact.normal_force()[n], 1e-9 * contact.normal_force()[n]);
    EXPECT_LT(f.dot(along), 0);
  }
}

TEST(ContactFriction, work_is_stored_plus_dissipated) {
  // A block pressed by a prescribed overlap is dragged to and fro; work of the friction force against storage and loss.
  Incline s;
  SelfContact contact(s.surface, s.options);
  const Vec3 along = s.turn * Vec3::UnitX(), up = s.turn * Vec3::UnitZ();
  for (int n = s.block[0]; n < s.block[1]; ++n) Eigen::Map<Vec3>(s.x.data() + 3 * n) -= 0.1 * mm * up;
  double work = 0, dissipated = 0;
  ContactResult result;
  const double dt = 1e-5;
  for (int step = 0; step < 4000; ++step) {
    const Vec3 velocity = 0.05 * std::cos(step * dt * 300) * along;
    for (int n = s.block[0]; n < s.block[1]; ++n) Eigen::Map<Vec3>(s.v.data() + 3 * n) = velocity;
    std::fill(s.forces.begin(), s.forces.end(), 0.0);
    result = contact.evaluate(s.x, s.v, dt, s.forces);
    EXPECT_GE(result.friction_dissipation, 0.0);
    dissipated += result.friction_dissipation;
    Vec3 total = Vec3::Zero();
    for (int n = s.block[0]; n < s.block[1]; ++n) total += Eigen::Map<const Vec3>(s.forces.data() + 3 * n);
    work -= dt * velocity.dot(total);
    for (int n = s.block[0]; n < s.block[1]; ++n) Eigen::Map<Vec3>(s.x.data() + 3 * n) += dt * velocity;
  }
  EXPECT_GT(dissipated, 100 * result.friction_energy);
  // Positions and velocities are one step apart; a node that crosses the border of the averaging strip adds a little.
  EXPECT_NEAR(work, dissipated + result.friction_energy, 1e-3 * work);
  // Lifting the block releases what was stored.
  for (int n = s.block[0]; n < s.block[1]; ++n) Eigen::Map<Vec3>(s.x.data() + 3 * n) += 1 * mm * up;
  const double stored = result.friction_energy;
  result = contact.evaluate(s.x, s.v, dt, s.forces);
  EXPECT_EQ(result.friction_energy, 0.0);
  EXPECT_NEAR(result.friction_dissipation, stored, 1e-9 * stored);
  for (double slip : contact.export_history()) EXPECT_EQ(slip, 0.0);
}

TEST(ContactFriction, a_pair_that_turns_as_one_body_does_not_slip) {
  Incline s;
  SelfContact contact(s.surface, s.options);
  const Vec3 up = s.turn * Vec3::UnitZ(), along = s.turn * Vec3::UnitX();
  for (int n = s.block[0]; n < s.block[1]; ++n) {
    Eigen::Map<Vec3>(s.x.data() + 3 * n) -= 0.1 * mm * up;
    Eigen::Map<Vec3>(s.v.data() + 3 * n) = 0.1 * along;
  }
  contact.evaluate(s.x, s.v, 2e-5, s.forces);  // some elastic slip, below the cap
  const auto before = contact.export_history();
  const double stored = contact.evaluate(s.x, std::vector<double>(s.x.size(), 0.0), 1e-5, s.forces).friction_energy;
  ASSERT_GT(stored, 0.0);
  const Vec3 omega(120, -250, 310);  // rad/s, a full turn in about 15 ms
  const double dt = 1e-6;
  const int steps = 5000;
  const Eigen::AngleAxisd step_turn(omega.norm() * dt, omega.normalized());
  ContactResult result;
  double lost = 0;
  for (int step = 0; step < steps; ++step) {
    for (std::size_t n = 0; n < s.x.size() / 3; ++n) {
      auto p = Eigen::Map<Vec3>(s.x.data() + 3 * n);
      p = step_turn * Vec3(p);
      Eigen::Map<Vec3>(s.v.data() + 3 * n) = omega.cross(Vec3(p));
    }
    result = contact.evaluate(s.x, s.v, dt, s.forces);
    lost += result.friction_dissipation;
  }
  EXPECT_NEAR(result.friction_energy, stored, 1e-6 * stored);
  EXPECT_LT(lost, 1e-6 * stored);
  const auto after = contact.export_history();
  const Eigen::AngleAxisd all(omega.norm() * dt * steps, omega.normalized());
  for (int n = 0; n < s.surface.node_count(); ++n) {
    const Vec3 a = Eigen::Map<const Vec3>(before.data() + 3 * n), b = Eigen::Map<const Vec3>(after.data() + 3 * n);
    EXPECT_LT((b - all * a).norm(), 2e-3 * a.norm() + 1e-18);
  }
}

}  // namespace
}  // namespace mv::test
