// SPDX-License-Identifier: BSD-3-Clause
#include "verification/slab_flow.h"

#include <algorithm>

namespace mv::test {
namespace {

// Rhythms of Simulation::advance (solver/time/simulation.cpp).
constexpr long estimate_every = 50, volumes_every = 10, gaps_every = 20;

// Coupling finds the mobility of held nodes without their periodic images. A slab thinner than the kernel has up to 8/3 times as much (the inverse of
// ib4's sum of squared weights along y), and holding is softened by that.
constexpr int thin_slab = 3;
constexpr double thin_slab_mobility = 8.0 / 3.0;

FluidBoundary periodic_in_y(FluidBoundary boundary) {
  boundary.side[1] = {BoundaryKind::periodic, BoundaryKind::periodic};
  return boundary;
}

}  // namespace

void fold_periodic_y(const FluidGrid& grid, FaceField& field, bool fill) {
  const int n = grid.n[1], end = n + 1 + FluidGrid::ghosts;
  const auto image = [&](int j) { return ((j % n) + n) % n; };
  for (auto& component : field.c)
    for (int k = -FluidGrid::ghosts; k < grid.n[2] + 1 + FluidGrid::ghosts; ++k) {
      const auto row = [&](int j) { return component.data() + grid.index(-FluidGrid::ghosts, j, k); };
      for (int j = -FluidGrid::ghosts; j < end; ++j) {
        if (j >= 0 && j < n) continue;
        double* from = row(j);
        double* to = row(image(j));
        for (int i = 0; i < grid.padded(0); ++i) to[i] += from[i];
      }
      for (int j = -FluidGrid::ghosts; j < end; ++j) {
        if (j >= 0 && j < n) continue;
        if (fill) std::copy_n(row(image(j)), grid.padded(0), row(j));
        else std::fill_n(row(j), grid.padded(0), 0.0);
      }
    }
}

SlabFlow::SlabFlow(const SlabSetup& setup, const SlabTissue& tissue, const std::vector<double>& held_points)
    : tissue_(tissue),
      setup_(setup),
      fluid_(setup.grid, periodic_in_y(setup.boundary), make_tube_wall(setup.grid, {}), setup.density, setup.viscosity),
      coupling_(Transfer(setup.grid, fluid_.wall(), setup.kernel), setup.density),
      flow_(fluid_.make_state()),
      force_density_(setup.grid),
      scratch_(setup.grid),
      rest_(tissue.mesh.points) {
  if (!tissue.mesh.tets.empty()) solid_.emplace(tissue.mesh, std::vector<Material>{setup.material});
  rest_.insert(rest_.end(), held_points.begin(), held_points.end());
  x_ = rest_;
  v_.assign(x_.size(), 0.0);
  forces_.assign(x_.size(), 0.0);
  const std::size_t count = x_.size() / 3;
  is_still_ = tissue.is_held;
  is_still_.resize(count, 1);
  std::vector<char> holds = is_still_;
  if (!setup.held_tissue_holds_blood) std::fill_n(holds.begin(), tissue.is_held.size(), 0);
  if (solid_) volumes_ = solid_->node_volumes();
  volumes_.resize(count, 0.0);
  for (int i = 0; i < tissue_.node_count(); ++i)
    if (tissue_.is_copy(i)) {
      const std::size_t copy = static_cast<std::size_t>(i);
      is_still_[copy] = 1;
      holds[copy] = 0;
      volumes_[static_cast<std::size_t>(tissue_.repeats[copy])] += volumes_[copy];
      volumes_[copy] = 0;
    }
  coupling_.set_volumes(volumes_);
  holding_.assign(3 * static_cast<std::size_t>(coupling_.set_held(rest_, holds)), 0.0);
}

void SlabFlow::set_contact(const ContactOptions& options, const std::optional<FilmDrainageOptions>& drainage) {
  surface_ = facing_surface(tissue_);
  contact_ = make_contact(surface_, options);
  if (drainage)
    drainage_.emplace(surface_, *contact_, tissue_.mesh.points, tissue_.is_held, setup_.grid, *drainage);
}

void SlabFlow::set_body(SlabBody body) {
  body_ = std::move(body);
  fluid_.set_rest_faces(body_.inside);
}

void SlabFlow::update_relaxation() {
  std::vector<double> element_steps(static_cast<std::size_t>(solid_->element_count()));
  solid_->critical_step(leaflet(x_), element_steps);
  relax_steps_.assign(is_still_.size(), 1e300);
  const std::size_t nodes_per_tet = static_cast<std::size_t>(tissue_.mesh.nodes_per_tet);
  for (std::size_t q = 0; q < tissue_.mesh.tets.size(); ++q) {
    const int node = tissue_.repeats[static_cast<std::size_t>(tissue_.mesh.tets[q])];
    double& step = relax_steps_[static_cast<std::size_t>(node)];
    step = std::min(step, element_steps[q / nodes_per_tet]);
  }
  for (double& step : relax_steps_)
    if (step > 1e200) step = 0;
}

std::vector<double> SlabFlow::find_unseen(const std::vector<double>& forces) {
  if (step_ % volumes_every == 0 || mean_volume_.empty()) {
    std::vector<double> volume_vectors(x_.size());
    for (std::size_t a = 0; a < volume_vectors.size(); ++a) volume_vectors[a] = volumes_[a / 3];
    scratch_.set_zero();
    coupling_.hand_over(volume_vectors, scratch_);
    fold_periodic_y(setup_.grid, scratch_, true);
    mean_volume_.assign(x_.size(), 0.0);
    coupling_.transfer().interpolate(scratch_, mean_volume_);
  }
  scratch_.set_zero();
  coupling_.hand_over(forces, scratch_);
  fold_periodic_y(setup_.grid, scratch_, true);
  const std::span<double> unseen = coupling_.find_unseen(forces, scratch_, mean_volume_);
  return {unseen.begin(), unseen.end()};
}

void SlabFlow::relax_and_drain(const CoupledNodes& nodes, double dt, double pressure) {
  std::vector<double> unseen = find_unseen(forces_);
  if (drainage_) {
    if (step_ % gaps_every == 0) drainage_->find_gaps(leaflet(x_), film_gaps_);
    tissue_.share_with_copies(solid_->node_volumes(), unseen);
    std::vector<double> forces_shared = forces_;
    tissue_.share_with_copies(solid_->node_volumes(), forces_shared);
    drainage_->press(leaflet(x_), film_gaps_, flow_.pressure, pressure, leaflet(forces_shared), unseen);
  }
  if (setup_.relaxation != Relaxation::none) {
    if (step_ % estimate_every == 0) update_relaxation();
    std::vector<double> relaxing = unseen;
    tissue_.gather_copies(relaxing);
    coupling_.relax(nodes, relaxing, relax_steps_, setup_.material.density, relax_shift_);
  }
  if (drainage_) drainage_->slip(leaflet(x_), film_gaps_, dt);
}

void SlabFlow::advance(double dt, double pressure) {
  x_before_ = x_;
  std::fill(forces_.begin(), forces_.end(), 0.0);
  if (solid_) solid_->forces(leaflet(x_), leaflet(forces_));
  if (contact_) contact_->evaluate(leaflet(x_), leaflet(v_), dt, leaflet(forces_));
  tissue_.gather_copies(forces_);

  const CoupledNodes nodes{x_, v_, is_still_};
  coupling_.bind(nodes);
  force_density_.set_zero();
  coupling_.hand_over(forces_, force_density_);
  if (setup_.relaxation != Relaxation::none || drainage_) relax_and_drain(nodes, dt, pressure);
  // Both gains of hold() go with the inverse of the step it is told.
  coupling_.hold(holding_, flow_.velocity, setup_.grid.n[1] < thin_slab ? thin_slab_mobility * dt : dt, force_density_);
  fold_periodic_y(setup_.grid, force_density_, false);
  body_force_ = advance_around(body_, fluid_, flow_, force_density_, dt, {{{0, 0}, {0, 0}, {pressure, 0}}});
  coupling_.move(nodes, flow_.velocity, dt);
  for (std::size_t a = 0; a < v_.size(); ++a)
    if (!is_still_[a / 3]) v_[a] = (x_[a] - x_before_[a]) / dt;
  tissue_.follow_first_plane(x_, v_);
  ++step_;
}

Vec3 SlabFlow::force_on_blood() const {
  Vec3 sum = body_force_;
  for (std::size_t i = 0; i < is_still_.size(); ++i)
    if (!is_still_[i]) sum += Vec3::Map(forces_.data() + 3 * i);
  const std::span<const double> held = coupling_.held_forces();
  for (std::size_t a = 0; a < held.size(); a += 3) sum += Vec3::Map(held.data() + a);
  return sum;
}

Vec3 SlabFlow::tissue_momentum() const {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < is_still_.size(); ++i)
    if (!is_still_[i]) sum += setup_.material.density * volumes_[i] * Vec3::Map(v_.data() + 3 * i);
  return sum;
}

std::vector<double> SlabFlow::contact_forces() {
  std::vector<double> forces(x_.size(), 0.0);
  const std::vector<double> history = contact_->export_history();
  contact_->evaluate(leaflet(x_), leaflet(v_), 0.0, leaflet(forces));
  contact_->import_history(history);
  return forces;
}

std::vector<double> SlabFlow::pressure_of(std::vector<double> forces) {
  tissue_.gather_copies(forces);
  coupling_.bind({x_, v_, is_still_});
  scratch_.set_zero();
  coupling_.hand_over(forces, scratch_);
  fold_periodic_y(setup_.grid, scratch_, false);
  fluid_.project(scratch_);
  return fluid_.last_potential();
}

}  // namespace mv::test
