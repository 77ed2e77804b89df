// SPDX-License-Identifier: BSD-3-Clause
#include "verification/solid/dry_motion.h"

#include <algorithm>

namespace mv::test {

DryMotion::DryMotion(const SolidMesh& mesh, const Material& material)
    : x(mesh.points), v(x.size(), 0.0), external(x.size(), 0.0), masses(x.size()), is_held(x.size(), 0),
      solid_(std::make_unique<LeafletSolid>(mesh, std::vector<Material>{material})), forces_(x.size(), 0.0) {
  for (std::size_t a = 0; a < x.size(); ++a) masses[a] = solid_->node_masses()[a / 3];
}

void DryMotion::add_contact(const ContactOptions& options, const std::vector<int>& side) {
  const SolidMesh& mesh = solid_->mesh();
  const std::size_t per = static_cast<std::size_t>(mesh.nodes_per_tet);
  std::vector<std::array<int, 10>> tets(mesh.tets.size() / per);
  for (std::size_t e = 0; e < tets.size(); ++e) std::copy_n(mesh.tets.begin() + static_cast<std::ptrdiff_t>(per * e), per, tets[e].begin());
  const ContactFaces faces = side.empty() ? ContactFaces::both : ContactFaces::inner;
  surface_ = extract_contact_surface(mesh.points, tets, per == 10 ? 2 : 1, side, faces);
  contact_ = std::make_unique<SelfContact>(surface_, options);
}

void DryMotion::add_guard() {
  std::vector<std::array<int, 3>> triangles = surface_.triangles;
  for (auto& t : triangles)
    for (int& n : t) n = surface_.nodes[static_cast<std::size_t>(n)];
  std::vector<char> is_fixed(x.size() / 3, 0);
  for (std::size_t a = 0; a < x.size(); ++a) is_fixed[a / 3] |= is_held[a];
  guard_.emplace(x, triangles, solid_->node_masses(), is_fixed);
}

/// As Simulation::advance without blood: impulses on velocities, their loss counted as damping.
void DryMotion::guard(double dt) {
  guard_impulses_ += guard_->apply(x_before_, x).stopped;
  guard_force_.setZero();
  for (std::size_t k = 0; k < guard_->moved().size(); ++k) {
    const std::size_t n = static_cast<std::size_t>(guard_->moved()[k]);
    const Vec3 change = guard_->shifts()[k] / dt;
    Eigen::Map<Vec3> velocity(v.data() + 3 * n);
    energies_.damping_loss += 0.5 * masses[3 * n] * (velocity.squaredNorm() - (velocity + change).squaredNorm());
    velocity += change;
    guard_force_ += masses[3 * n] / dt * change;
  }
}

void DryMotion::step(double dt) {
  std::copy(external.begin(), external.end(), forces_.begin());
  energies_.elastic = solid_->forces(x, forces_);
  if (contact_) {
    contact_result_ = contact_->evaluate(x, v, dt, forces_);
    energies_.contact = contact_result_.potential_energy + contact_result_.friction_energy;
    energies_.friction_loss += contact_result_.friction_dissipation;
  }
  if (load) load(x, forces_);
  if (guard_) x_before_ = x;
  const double decay = 1.0 / (1.0 + dt * damping);
  energies_.kinetic = 0;
  for (std::size_t a = 0; a < x.size(); ++a) {
    const double before = v[a];
    if (!is_held[a]) v[a] = (v[a] + dt * forces_[a] / masses[a]) * decay;
    energies_.kinetic += 0.5 * masses[a] * before * v[a];
    energies_.damping_loss += dt * damping * masses[a] * v[a] * v[a];
    x[a] += dt * v[a];
  }
  if (guard_) guard(dt);
}

Vec3 DryMotion::momentum() const {
  Vec3 p = Vec3::Zero();
  for (std::size_t a = 0; a < x.size(); ++a) p[static_cast<Eigen::Index>(a % 3)] += masses[a] * v[a];
  return p;
}

Vec3 DryMotion::angular_momentum() const {
  Vec3 l = Vec3::Zero();
  for (std::size_t n = 0; n < x.size() / 3; ++n) l += masses[3 * n] * Vec3::Map(x.data() + 3 * n).cross(Vec3::Map(v.data() + 3 * n));
  return l;
}

SmallStrain small_strain(double shear, double bulk) {
  return {9 * bulk * shear / (3 * bulk + shear), (3 * bulk - 2 * shear) / (2 * (3 * bulk + shear))};
}

}  // namespace mv::test
