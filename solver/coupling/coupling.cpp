// SPDX-License-Identifier: BSD-3-Clause
#include "solver/coupling/coupling.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "geometry/core/parallel.h"

namespace mv {

namespace {
constexpr double hold_share_most = 0.2, hold_share_least = 0.05, hold_room = 0.42;   // set_hold_share()
constexpr double room_beside_tissue = 0.6, least_room = 0.05;   // hold()
// Steps shorter than this hold no harder: the harder the hold, the more of the weakly seen motions between the held nodes it stops, and what the annulus lets
// pass would depend on the step.
constexpr double hold_step = 50e-6;  // s
// kappa and beta of relax(): a ninth of the stability limit 4 kappa < 2 (1 + beta), because tau is some fifty steps old while the fibres stiffen.
constexpr double relaxation = 0.1;
constexpr double relaxation_memory = 0.9;
// Nodes in corners of the wall, where almost nothing is spread, do not relax: <V> there is less than this share of V / h^3. What a node's own volume leaves at its
// place in open blood is 0.03 to 0.13 of that, by the kernel; what its neighbours leave comes on top.
constexpr double smallest_volume_share = 0.01;
}  // namespace

Coupling::Coupling(Transfer transfer, double fluid_density) : transfer_(std::move(transfer)), density_(fluid_density) {}

void Coupling::set_hold_share(double safety) { hold_share_ = std::clamp(hold_room * (1.0 - safety * safety), hold_share_least, hold_share_most); }

int Coupling::set_held(std::span<const double> x, std::span<const char> is_fixed) {
  std::vector<double> positions;
  for (std::size_t i = 0; i < is_fixed.size(); ++i)
    if (is_fixed[i]) positions.insert(positions.end(), x.begin() + static_cast<std::ptrdiff_t>(3 * i), x.begin() + static_cast<std::ptrdiff_t>(3 * i + 3));
  return set_held(std::move(positions), 0);
}

int Coupling::set_held(std::vector<double> positions, int axial) {
  const int count = static_cast<int>(positions.size() / 3);
  if (count == 0) return 0;
  held_axial_ = axial;
  held_active_.resize(static_cast<std::size_t>(count));
  std::iota(held_active_.begin(), held_active_.end(), 0);
  held_transfer_ = std::make_unique<Transfer>(transfer_);
  held_transfer_->bind(positions, held_active_);
  held_velocity_.assign(positions.size(), 0.0);
  held_force_.assign(positions.size(), 0.0);
  allow_for_held_mobility();
  return count;
}

void Coupling::carry_held(std::span<const double> positions, std::span<const double> velocities, std::span<const char> is_active) {
  // Beside the wall a part of each kernel lies outside, where nothing moves: blood that moves as the point does is seen to move by the part inside alone.
  if (all_ones_.c[0].empty()) {
    all_ones_ = FaceField(transfer_.grid());
    for (auto& component : all_ones_.c) std::fill(component.begin(), component.end(), 1.0);
  }
  is_held_active_.assign(is_active.begin(), is_active.end());
  held_active_.clear();
  for (std::size_t i = 0; i < is_active.size(); ++i)
    if (is_active[i]) held_active_.push_back(static_cast<int>(i));
  held_transfer_->bind(positions, held_active_);
  held_target_.assign(velocities.size(), 0.0);
  held_transfer_->interpolate(all_ones_, held_target_);
  for (std::size_t a = 0; a < held_target_.size(); ++a) held_target_[a] *= velocities[a];
}

void Coupling::leave_axial_part(std::vector<double>& held) const {
  const std::size_t first = held.size() - 3 * static_cast<std::size_t>(held_axial_);
  for (std::size_t a = first; a < held.size(); a += 3) held[a] = held[a + 1] = 0;
}

void Coupling::allow_for_held_mobility() {
  // Power iteration on interpolate(spread(.)) / density.
  std::vector<double> force(held_velocity_.size(), 0.0), velocity(force.size(), 0.0);
  for (const int i : held_active_) std::fill_n(force.begin() + 3 * static_cast<std::ptrdiff_t>(i), 3, 1.0);
  leave_axial_part(force);
  FaceField field(transfer_.grid());
  double mobility = 0;
  for (int iteration = 0; iteration < 20; ++iteration) {
    field.set_zero();
    held_transfer_->spread(force, field);
    held_transfer_->interpolate(field, velocity);
    leave_axial_part(velocity);
    double squared = 0;
    for (double v : velocity) squared += v * v;
    const double norm = std::sqrt(squared);
    if (iteration > 0) mobility = norm / density_;
    if (!(norm > 0)) break;
    for (std::size_t a = 0; a < force.size(); ++a) force[a] = velocity[a] / norm;
  }
  held_mobility_ = std::max(held_mobility_, mobility);
}

void Coupling::set_volumes(std::vector<double> volumes) {
  volumes_ = std::move(volumes);
  volume_vectors_.resize(3 * volumes_.size());
  for (std::size_t a = 0; a < volume_vectors_.size(); ++a) volume_vectors_[a] = volumes_[a / 3];
  mean_force_.assign(volume_vectors_.size(), 0.0);
  unseen_.assign(volume_vectors_.size(), 0.0);
  volume_density_ = FaceField(transfer_.grid());
}

std::span<double> Coupling::find_unseen(std::span<const double> forces, const FaceField& force_density, std::vector<double>& mean_volume) {
  transfer_.interpolate(force_density, mean_force_);
  if (mean_volume.empty()) {
    mean_volume.assign(volume_vectors_.size(), 0.0);
    volume_density_.set_zero();
    transfer_.spread(volume_vectors_, volume_density_);
    transfer_.interpolate(volume_density_, mean_volume);
  }
  std::fill(unseen_.begin(), unseen_.end(), 0.0);
  const double cell = std::pow(transfer_.grid().h, 3);
  parallel_for(static_cast<std::ptrdiff_t>(active_.size()), [&](std::ptrdiff_t q) {
    const std::size_t node = static_cast<std::size_t>(active_[static_cast<std::size_t>(q)]);
    if (!(volumes_[node] > 0)) return;
    for (std::size_t a = 3 * node; a < 3 * node + 3; ++a)
      if (mean_volume[a] * cell > smallest_volume_share * volumes_[node]) unseen_[a] = forces[a] - volumes_[node] * mean_force_[a] / mean_volume[a];
  });
  return unseen_;
}

void Coupling::relax(const CoupledNodes& nodes, std::span<const double> unseen, std::span<const double> critical_steps, double solid_density,
                     std::vector<double>& shift) {
  shift.resize(volume_vectors_.size(), 0.0);
  parallel_for(static_cast<std::ptrdiff_t>(active_.size()), [&](std::ptrdiff_t q) {
    const std::size_t node = static_cast<std::size_t>(active_[static_cast<std::size_t>(q)]);
    if (!(volumes_[node] > 0)) return;
    const double factor = relaxation * critical_steps[node] * critical_steps[node] / (solid_density * volumes_[node]);
    for (std::size_t a = 3 * node; a < 3 * node + 3; ++a) {
      shift[a] = relaxation_memory * shift[a] + factor * unseen[a];
      nodes.x[a] += shift[a];
    }
  });
}

Coupling::HoldWork Coupling::hold(std::vector<double>& holding, const FaceField& velocity, double dt, FaceField& force_density, double tissue_share) {
  HoldWork work;
  if (!held_transfer_ || !(held_mobility_ > 0)) return work;
  const double step = std::max(dt, hold_step);
  const double room = room_beside_tissue * (1.0 - std::min(1.0, tissue_share * tissue_share)), wanted = hold_share_ * (dt / step) * (1.0 + dt / step);
  const double share = hold_share_ * std::min(1.0, std::max(room, least_room) / wanted);
  const double spring = share * 4.0 / (held_mobility_ * step * step);
  const double damper = share * 2.0 / (held_mobility_ * step);
  const bool is_carried = !held_target_.empty();
  held_transfer_->interpolate(velocity, held_velocity_);
  for (std::size_t a = 0; a < holding.size(); ++a) {
    if (is_carried && !is_held_active_[a / 3]) {
      holding[a] = held_force_[a] = held_velocity_[a] = 0;
      continue;
    }
    const double slip = is_carried ? held_velocity_[a] - held_target_[a] : held_velocity_[a];
    holding[a] -= dt * spring * slip;
    held_force_[a] = holding[a] - damper * slip;
  }
  if (held_axial_ > 0) {
    leave_axial_part(holding);
    leave_axial_part(held_force_);
  }
  for (std::size_t a = 0; a < holding.size(); ++a) {
    work.on_blood += dt * held_force_[a] * held_velocity_[a];
    if (is_carried) work.by_motion += dt * held_force_[a] * held_target_[a];
  }
  held_transfer_->spread(held_force_, force_density);
  return work;
}

void Coupling::tie_to_fixed(std::span<const double> rest, std::span<const char> is_fixed) {
  const int count = static_cast<int>(is_fixed.size());
  std::vector<int> fixed;
  for (int i = 0; i < count; ++i)
    if (is_fixed[static_cast<std::size_t>(i)]) fixed.push_back(i);
  const auto at = [&](int node) { return Eigen::Vector3d::Map(rest.data() + 3 * static_cast<std::ptrdiff_t>(node)); };
  const double h = transfer_.grid().h, reach = transfer_.kernel_reach() * h;
  std::vector<Tie> of_node(static_cast<std::size_t>(count), Tie{-1, -1, 1.0});
  parallel_for(count, [&](std::ptrdiff_t i) {
    if (is_fixed[static_cast<std::size_t>(i)]) return;
    const int node = static_cast<int>(i);
    int nearest = -1;
    double squared = reach * reach;
    for (const int f : fixed)
      if (const double d = (at(f) - at(node)).squaredNorm(); d < squared) squared = d, nearest = f;
    if (nearest < 0) return;
    const double s = std::sqrt(squared) / h;
    of_node[static_cast<std::size_t>(i)] = {node, nearest, s / std::max(s, transfer_.smeared_ramp(s))};
  });
  ties_.clear();
  tied_.clear();
  for (const Tie& tie : of_node)
    if (tie.free < 1) {
      ties_.push_back(tie);
      tied_.push_back(tie.node);
    }
  if (ties_.empty()) return;
  tied_force_.assign(rest.size(), 0.0);
  tied_transfer_ = std::make_unique<Transfer>(transfer_);
}

void Coupling::relieve_tied(const CoupledNodes& nodes, std::span<const double> forces, FaceField& force_density) {
  if (ties_.empty()) return;
  for (const Tie& tie : ties_)
    for (std::size_t a = 3 * static_cast<std::size_t>(tie.node), end = a + 3; a < end; ++a) tied_force_[a] = -(1 - tie.free) * forces[a];
  tied_transfer_->bind(nodes.x, tied_);
  tied_transfer_->spread(tied_force_, force_density);
}

int Coupling::bind(const CoupledNodes& nodes) {
  active_.clear();
  const int count = static_cast<int>(nodes.is_fixed.size());
  for (int i = 0; i < count; ++i)
    if (!nodes.is_fixed[static_cast<std::size_t>(i)]) active_.push_back(i);
  return transfer_.bind(nodes.x, active_);
}

double Coupling::move(const CoupledNodes& nodes, const FaceField& velocity, double dt) {
  // Midpoint rule: a plain Euler step swells everything that turns, by (dt omega)^2 / 2 of its volume a step. The old velocity is good enough to find
  // the midpoint (an error of dt^3; relaxation and slip are in it as they were last) and saves an interpolation.
  midpoint_.assign(nodes.x.begin(), nodes.x.end());
  parallel_for(static_cast<std::ptrdiff_t>(midpoint_.size()), [&](std::ptrdiff_t a) {
    if (!nodes.is_fixed[static_cast<std::size_t>(a / 3)]) midpoint_[static_cast<std::size_t>(a)] += 0.5 * dt * nodes.v[static_cast<std::size_t>(a)];
  });
  transfer_.move_bound(midpoint_);
  transfer_.interpolate(velocity, nodes.v);
  double work = 0;
  for (const Tie& tie : ties_)
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t a = 3 * static_cast<std::size_t>(tie.node) + c;
      const double carried = nodes.v[3 * static_cast<std::size_t>(tie.fixed) + c];
      nodes.v[a] = tie.free * nodes.v[a] + (1 - tie.free) * carried;
      work += dt * tied_force_[a] * carried;
    }
  parallel_for(static_cast<std::ptrdiff_t>(midpoint_.size()), [&](std::ptrdiff_t a) {
    if (!nodes.is_fixed[static_cast<std::size_t>(a / 3)]) nodes.x[static_cast<std::size_t>(a)] += dt * nodes.v[static_cast<std::size_t>(a)];
  });
  return work;
}

void Coupling::accelerate(const CoupledNodes& nodes, std::span<const double> forces, NavierStokes& fluid, FaceField& scratch,
                          std::span<double> out) const {
  scratch.set_zero();
  if (ties_.empty()) {
    transfer_.spread(forces, scratch);
  } else {
    std::vector<double> handed(forces.begin(), forces.end());
    for (const Tie& tie : ties_)
      for (std::size_t a = 3 * static_cast<std::size_t>(tie.node), end = a + 3; a < end; ++a) handed[a] *= tie.free;
    transfer_.spread(handed, scratch);
  }
  fluid.project(scratch);
  fluid.apply_velocity_boundary(scratch);
  transfer_.interpolate(scratch, out);
  for (std::size_t i = 0; i < nodes.is_fixed.size(); ++i)
    for (std::size_t a = 3 * i; a < 3 * i + 3; ++a)
      out[a] = nodes.is_fixed[i] ? 0.0 : out[a] / density_;
  for (const Tie& tie : ties_)
    for (std::size_t a = 3 * static_cast<std::size_t>(tie.node), end = a + 3; a < end; ++a) out[a] *= tie.free;
}

}  // namespace mv
