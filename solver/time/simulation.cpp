// SPDX-License-Identifier: BSD-3-Clause
#include "solver/time/simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "geometry/core/errors.h"
#include "geometry/core/log.h"
#include "geometry/core/parallel.h"
#include "solver/time/annulus_barrier.h"
#include "solver/output/contact_map.h"
#include "solver/time/preflight.h"

namespace mv {
namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

constexpr double metres_per_mm = 1e-3;
// Steps between two estimates of the stiffest mode: few while it stiffens quickly (fibres at the impact, contact) and after a rollback.
constexpr int estimate_every = 80, estimate_soon = 10, estimate_at_once = 5;
constexpr double quick_stiffening = 1.03;  // growth of the frequency from one estimate to the next
// Growth of the energy of tissue or contact since the last estimate. Contact counts from a share of the tissue's energy on.
constexpr double slow_loading = 1.03, quick_loading = 1.05, sudden_loading = 1.2, contact_share = 0.01;
constexpr double room_to_stiffen = 0.7;    // share of the step that is used while it stiffens quickly
constexpr int estimate_products = 3;
// Of the power iteration for the elements' own critical steps: relaxation keeps a ninth of its limit, so that a few per cent do not matter.
constexpr int relaxation_rounds = 6;
constexpr int volumes_every = 10;          // steps between two evaluations of the nodes' smoothed volumes
constexpr int gaps_every = 20;             // steps between two searches for facing leaflets
constexpr int snapshot_every = 200;       // steps between two states to fall back to
constexpr int rollbacks_allowed = 8;      // in a row
constexpr int cap_steps = 500;            // how long the smaller step lasts after a rollback
// An inverted element is pushed back by the continued law and distortion control; a step fails when they become more than a few.
constexpr double inverted_share_allowed = 2e-4;
constexpr double largest_move = 0.25;     // of the fluid spacing (or the mesh spacing) in one step
constexpr double move_share = 0.6;        // of largest_move that the next step may make at the last step's largest velocity ...
constexpr double contact_move_share = 0.5;   // ... and of the depth that contact sees, beyond which it gives up

double swept_volume_of(const std::vector<std::array<int, 3>>& faces, const std::vector<double>& x0, const std::vector<double>& x1) {
  // Mean of the area vectors times the mean displacement: exact to third order in the tiny motion of one step.
  return parallel_sum(static_cast<std::ptrdiff_t>(faces.size()), [&](std::ptrdiff_t f) {
    const auto& t = faces[static_cast<std::size_t>(f)];
    auto at = [&](const std::vector<double>& x, std::size_t c) { return Vec3::Map(x.data() + 3 * t[c]); };
    const Vec3 moved = (at(x1, 0) - at(x0, 0)) + (at(x1, 1) - at(x0, 1)) + (at(x1, 2) - at(x0, 2));
    const Vec3 a0 = (at(x0, 1) - at(x0, 0)).cross(at(x0, 2) - at(x0, 0)), a1 = (at(x1, 1) - at(x1, 0)).cross(at(x1, 2) - at(x1, 0));
    return moved.dot(a0 + a1) / 12.0;
  });
}

/// Whether tissue or contact hold `growth` times the energy they held at the last estimate: what is stretched further, or pressed harder, is stiffer.
bool is_loaded(const State& state, double growth) {
  return state.elastic_energy > growth * state.energy_at_estimate ||
         state.contact_energy > growth * state.contact_at_estimate + contact_share * state.elastic_energy;
}

/// Blood (m3) that chordae or leaflets may stir before they close: a small share of the annulus' area times its root.
double least_closing_volume(const Annulus& annulus) {
  constexpr double share = 0.005;
  const auto& p = annulus.points;
  double twice_area = 0;  // mm2
  for (std::size_t i = 0; i < p.size(); ++i) twice_area += annulus.normal.dot((p[i] - annulus.origin).cross(p[(i + 1) % p.size()] - annulus.origin));
  return share * std::pow(0.5 * std::abs(twice_area) * metres_per_mm * metres_per_mm, 1.5);
}

}  // namespace

Simulation::Simulation(Scene scene) : scene_(std::move(scene)), waveform_(Waveform::from_config(scene_.config, scene_.directory)) {
  const Config& config = scene_.config;
  preflight(scene_, waveform_);
  structure_.emplace(scene_, std::max(waveform_.largest(), 1.0));
  const std::size_t unknowns = structure_->rest_positions().size();
  forces_.assign(unknowns, 0.0);
  x_before_.assign(unknowns, 0.0);
  if (scene_.has_contact()) {
    const std::span<const double> leaflets(structure_->rest_positions().data(), 3 * static_cast<std::size_t>(structure_->leaflet_nodes()));
    guard_.emplace(leaflets, boundary_faces(scene_.mesh).triangles, structure_->masses(), structure_->is_fixed());
  }
  if (scene_.has_fluid()) {
    FluidGrid grid;
    grid.n = scene_.tube.grid_cells;
    grid.h = metres_per_mm * scene_.tube.grid_spacing;
    grid.lower = metres_per_mm * scene_.tube.grid_lower;
    std::vector<Eigen::Vector2d> section;
    for (const Vec2& p : scene_.tube.cross_section) section.push_back(metres_per_mm * p);
    fluid_.emplace(grid, FluidBoundary(), make_tube_wall(grid, section), config.number("fluid.density"), config.number("fluid.viscosity"));
    coupling_.emplace(Transfer(grid, fluid_->wall(), kernel_from_name(config.text("fluid.kernel"))), config.number("fluid.density"));
    force_density_ = FaceField(grid);
    if (section.size() >= 3) {
      const auto leaflets = static_cast<std::size_t>(structure_->leaflet_nodes());
      wall_limit_.emplace(section, std::span<const double>(structure_->rest_positions().data(), 3 * leaflets), std::span<const char>(structure_->is_fixed().data(), leaflets));
    }
    std::vector<double> volumes = structure_->solid().node_volumes();
    volumes.resize(structure_->is_fixed().size(), 0.0);
    coupling_->set_volumes(std::move(volumes));
    coupling_->tie_to_fixed(structure_->rest_positions(), structure_->is_fixed());
    if (config.text("coupling.annulus") == "faces") fluid_->set_rest_faces(faces_crossed(grid, annulus_barrier(scene_)));
    else hold_annulus();
    coupling_->set_hold_share(config.number("time.safety"));
    if (scene_.has_contact() && config.text("coupling.scheme") == "drained") {
      FilmDrainageOptions options;
      options.drainage_time = config.number("coupling.drainage_time");
      options.pressure_scale = std::max(waveform_.largest(), 1.0);
      drainage_.emplace(structure_->surface(), *structure_->contact(),
                        std::span<const double>(structure_->rest_positions().data(), 3 * static_cast<std::size_t>(structure_->leaflet_nodes())),
                        structure_->is_fixed(), grid, options);
    }
    stable_step_.emplace(&fluid_->grid());
  } else {
    stable_step_.emplace(nullptr);
  }
}

State Simulation::initial_state() {
  State state;
  state.x = structure_->rest_positions();
  state.v.assign(state.x.size(), 0.0);
  if (fluid_) {
    state.holding.assign(3 * static_cast<std::size_t>(held_count_), 0.0);
    state.flow = fluid_->make_state();
    const double p = waveform_.at(0);
    state.flow.boundary_pressure[2][0] = p;
    const FluidGrid& grid = fluid_->grid();
    for (int k = 0; k < grid.n[2]; ++k)
      for (int j = 0; j < grid.n[1]; ++j)
        for (int i = 0; i < grid.n[0]; ++i) state.flow.pressure[static_cast<std::size_t>(grid.index(i, j, k))] = p * (1 - (k + 0.5) / grid.n[2]);
  }
  if (structure_->contact()) state.friction_slip = structure_->contact()->export_history();
  PartTimes ignored;
  structure_->evaluate(state, 0.0, 0.0, forces_, ignored);
  state.initial_energy = total_energy(state);
  return state;
}

double Simulation::choose_step(State& state, double stop_time, std::string& limiter) {
  const Config& config = scene_.config;
  const auto start = Clock::now();
  const bool is_estimated = state.step >= state.next_estimate || (state.step >= state.last_estimate + estimate_soon && is_loaded(state, quick_loading)) ||
                            (state.step >= state.last_estimate + estimate_at_once && is_loaded(state, sudden_loading));
  if (is_estimated) {
    const double before = state.frequency;
    const bool is_probed = is_loaded(state, slow_loading) || state.step < state.cap_until_step;
    // The tangent of contact belongs to these positions, also after a resume or a rollback.
    if (structure_->contact()) refresh(state);
    if (coupling_) coupling_->bind({state.x, state.v, structure_->is_fixed()});
    // Without blood the elements' own steps serve look_at_stiff_nodes() alone.
    if (coupling_ ? config.flag("coupling.relaxation") : is_probed) update_relaxation(state);
    if (is_probed) stable_step_->look_at_stiff_nodes(state);
    stable_step_->update(state, *structure_, coupling_ ? &*coupling_ : nullptr, fluid_ ? &*fluid_ : nullptr, estimate_products);
    state.last_estimate = state.step;
    state.energy_at_estimate = state.elastic_energy;
    state.contact_at_estimate = state.contact_energy;
    const bool is_soon = state.step < state.cap_until_step || (before > 0 && state.frequency > quick_stiffening * before);
    state.next_estimate = state.step + (is_soon ? estimate_soon : estimate_every);
    state.is_stiffening = is_soon;
  }
  times_.step_estimate += seconds_since(start);
  double dt = config.number("time.step_max");
  limiter = "step_max";
  const double stable = state.frequency > 0 ? (state.is_stiffening ? room_to_stiffen : 1.0) * 2.0 / state.frequency : 1e300;
  if (config.number("time.safety") * stable < dt) {
    dt = config.number("time.safety") * stable;
    limiter = state.stiffest_part;
  }
  if (!config.is_auto("time.step_fixed")) {
    dt = config.number("time.step_fixed");
    limiter = "step_fixed";
    if (dt > stable) {
      dt = config.number("time.safety") * stable;
      limiter = state.stiffest_part;
      if (!has_warned_of_step_)
        spdlog::warn("time.step_fixed = {:.4g} us is beyond the stable step of {:.4g} us ({}); steps are reduced to {:.4g} us and follow the stable step from here",
                     1e6 * config.number("time.step_fixed"), 1e6 * stable, limiter, 1e6 * dt);
      has_warned_of_step_ = true;
    }
  }
  if (fluid_ && is_estimated) state.flow_step = fluid_->stable_step(state.flow);
  if (fluid_ && state.flow_step < dt) {
    dt = state.flow_step;
    limiter = "flow";
  }
  double most = move_share * largest_move * motion_scale();
  if (structure_->contact()) most = std::min(most, contact_move_share * structure_->contact()->options().penetration_limit);
  if (state.fastest * dt > most) {
    dt = most / state.fastest;
    limiter = "motion";
  }
  if (state.step < state.cap_until_step && state.dt_cap < dt) {
    dt = state.dt_cap;
    limiter = "retry";
  }
  // Growing slowly keeps the two-step scheme of the flow smooth.
  if (state.dt > 0) dt = std::min(dt, 1.1 * state.dt);
  // Even steps to the next output: cutting the last one would leave the next ones to grow again.
  const double left = stop_time - state.time;
  const double count = std::ceil(left / dt - 1e-9);
  if (count <= 1) limiter = "output";
  return left / std::max(count, 1.0);
}

void Simulation::update_relaxation(State& state) {
  LeafletSolid& solid = structure_->solid();
  element_steps_.resize(static_cast<std::size_t>(solid.element_count()));
  solid.critical_step(std::span<const double>(state.x.data(), 3 * static_cast<std::size_t>(structure_->leaflet_nodes())), element_steps_, relaxation_rounds);
  state.relax_steps.assign(structure_->is_fixed().size(), 1e300);
  const auto& mesh = solid.mesh();
  for (std::size_t e = 0; e < element_steps_.size(); ++e)
    for (int n = 0; n < mesh.nodes_per_tet; ++n) {
      double& step = state.relax_steps[static_cast<std::size_t>(mesh.tets[e * static_cast<std::size_t>(mesh.nodes_per_tet) + static_cast<std::size_t>(n)])];
      step = std::min(step, element_steps_[e]);
    }
  const auto& own = solid.node_masses();
  for (std::size_t i = 0; i < state.relax_steps.size(); ++i) {
    double& step = state.relax_steps[i];
    if (step > 1e200) step = 0;
    else if (!fluid_) step *= std::sqrt(structure_->masses()[i] / own[i]);  // scaled masses
  }
}

void Simulation::advance(State& state, double dt) {
  const double pressure = waveform_.at(state.time + 0.5 * dt);  // second order in time: it acts over the whole step
  x_before_ = state.x;
  if (structure_->contact()) structure_->contact()->import_history(state.friction_slip);
  structure_->evaluate(state, dt, pressure, forces_, times_);
  if (structure_->contact()) structure_->contact()->export_history(state.friction_slip);

  if (fluid_) {
    // The loss of the last step's unseen motion was booked with the forces before it; their mean with those after it is right to second order.
    if (!state.unseen_shift.empty()) state.ledger.coupling_loss += 0.5 * (work_on(state.unseen_shift) - state.unseen_work);
    state.unseen_shift.clear();
    state.unseen_work = 0;
    const CoupledNodes nodes{state.x, state.v, structure_->is_fixed()};
    auto start = Clock::now();
    outside_ = coupling_->bind(nodes);
    force_density_.set_zero();
    coupling_->hand_over(forces_, force_density_);
    const bool is_relaxed = !state.relax_steps.empty();
    if (is_relaxed || drainage_) {
      if (state.step % volumes_every == 0) state.mean_volume.clear();
      const std::span<double> unseen = coupling_->find_unseen(forces_, force_density_, state.mean_volume);
      const std::span<double> x(state.x.data(), 3 * static_cast<std::size_t>(structure_->leaflet_nodes()));
      if (drainage_) {
        if (state.step % gaps_every == 0 || state.film_gaps.empty()) drainage_->find_gaps(x, state.film_gaps);
        drainage_->press(x, state.film_gaps, state.flow.pressure, pressure, forces_, unseen);
        drainage_->slip(x, state.film_gaps, dt);
      }
      if (is_relaxed) coupling_->relax(nodes, unseen, state.relax_steps, scene_.config.number("leaflet.density"), state.relax_shift);
      book_unseen_motion(state);
    }

    coupling_->relieve_tied(nodes, forces_, force_density_);
    if (skirt_) carry_hold(state.time, dt);
    const Coupling::HoldWork held = coupling_->hold(state.holding, state.flow.velocity, dt, force_density_, 0.5 * dt * state.frequency);
    state.ledger.coupling_loss -= held.on_blood - held.by_motion;
    state.ledger.work_moved += held.by_motion;
    times_.coupling += seconds_since(start);
    start = Clock::now();
    const FlowStepReport report = fluid_->advance(state.flow, force_density_, dt, {{{0, 0}, {0, 0}, {pressure, 0}}});
    times_.fluid += seconds_since(start);
    start = Clock::now();
    if (skirt_) move_annulus(state, dt);
    state.ledger.work_moved += coupling_->move(nodes, state.flow.velocity, dt);
    times_.coupling += seconds_since(start);
    guard_motion(state, dt);  // keeps its own time
    start = Clock::now();
    // What the nodes did in truth, relaxation and slip included, is what friction feels.
    if (is_relaxed || drainage_)
      parallel_for(static_cast<std::ptrdiff_t>(state.v.size()), [&](std::ptrdiff_t a) {
        const std::size_t q = static_cast<std::size_t>(a);
        if (!structure_->is_fixed()[q / 3]) state.v[q] = (state.x[q] - x_before_[q]) / dt;
      });
    times_.coupling += seconds_since(start);
    state.ledger.work_pressure += report.pressure_work;
    state.ledger.boundary_kinetic += report.boundary_kinetic;
    state.ledger.coupling_loss -= report.rest_work;
    state.ledger.viscous_loss += report.viscous_loss;
    state.ledger.advection_loss += report.advection_loss;
  } else {
    const auto& fixed = structure_->is_fixed();
    const auto& masses = structure_->masses();
    const double rate = structure_->damping_rate(), decay = 1.0 / (1.0 + dt * rate);
    double damped = 0;
    if (structure_->annulus_motion()) move_annulus(state, dt);
    for (std::size_t i = 0; i < fixed.size(); ++i) {
      if (fixed[i]) continue;
      for (std::size_t a = 3 * i; a < 3 * i + 3; ++a) {
        state.v[a] = (state.v[a] + dt * forces_[a] / masses[i]) * decay;
        damped += dt * rate * masses[i] * state.v[a] * state.v[a];
        state.x[a] += dt * state.v[a];
      }
    }
    state.ledger.damping_loss += damped;
    guard_motion(state, dt);
    state.ledger.work_pressure += pressure * -swept_volume_of(structure_->ventricular_faces(), x_before_, state.x);
  }
  state.volume_swept += swept_volume_of(structure_->atrial_faces(), x_before_, state.x);
  state.time += dt;
  state.step += 1;
  state.dt = dt;
  state.dt_sum += dt;
  state.dt_min = std::min(state.dt_min, dt);

  const double flow = flow_backward(state);
  const double before = state.flow_rate;
  state.flow_rate = flow;
  state.volume_backward += dt * flow;
  if (state.closing_time < 0) {
    if (!state.closure_began && flow > 0 && pressure > 0) {
      state.closure_began = true;
      state.volume_at_closure_start = state.volume_backward;
    }
    if (state.closure_began && before > 0 && flow <= 0) {
      const double volume = state.volume_backward - state.volume_at_closure_start;
      if (volume > least_closing_volume(scene_.annulus)) {
        state.closing_time = state.time;
        state.closing_volume = volume;
      } else {
        state.closure_began = false;
      }
    }
  }
}

void Simulation::move_annulus(State& state, double dt) {
  const AnnulusMotion& motion = *structure_->annulus_motion();
  const auto& nodes = motion.nodes();
  const auto& rest = structure_->rest_positions();
  double work = 0;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const std::size_t node = static_cast<std::size_t>(nodes[n]);
    Eigen::Map<Vec3> x(state.x.data() + 3 * node), v(state.v.data() + 3 * node);
    const Vec3 moved = Vec3::Map(rest.data() + 3 * node) + motion.displacement(n, state.time + dt);
    const Vec3 velocity = (moved - x) / dt;
    // What moves a node works against the forces on it and on its inertia, which in blood is the blood's.
    work -= Vec3::Map(forces_.data() + 3 * node).dot(moved - x);
    if (!fluid_) work += 0.5 * structure_->masses()[node] * (velocity.squaredNorm() - v.squaredNorm());
    v = velocity;
    x = moved;
  }
  state.ledger.work_moved += work;
}

void Simulation::place_hold(double time, std::vector<double>& x) {
  const AnnulusMotion& motion = *structure_->annulus_motion();
  const auto& rest = structure_->rest_positions();
  const std::size_t nodes = motion.nodes().size();
  for (std::size_t n = 0; n < nodes; ++n) Vec3::Map(x.data() + 3 * n) = Vec3::Map(rest.data() + 3 * motion.nodes()[n]) + motion.displacement(n, time);
  skirt_->place(time, std::span(x).subspan(3 * nodes), std::span(is_hold_active_).subspan(nodes));
}

void Simulation::carry_hold(double time, double dt) {
  place_hold(time + dt, hold_velocity_);
  place_hold(time, hold_place_);
  for (std::size_t a = 0; a < hold_place_.size(); ++a) hold_velocity_[a] = (hold_velocity_[a] - hold_place_[a]) / dt;
  coupling_->carry_held(hold_place_, hold_velocity_, is_hold_active_);
}

void Simulation::hold_annulus() {
  const AnnulusMotion* motion = structure_->annulus_motion();
  if (!motion) {
    held_count_ = coupling_->set_held(structure_->rest_positions(), structure_->is_fixed());
    return;
  }
  skirt_.emplace(scene_, *motion, scene_.config.path("annulus.motion").string());
  const std::size_t count = motion->nodes().size() + skirt_->points();
  hold_place_.assign(3 * count, 0.0);
  hold_velocity_.assign(3 * count, 0.0);
  is_hold_active_.assign(count, 1);
  place_hold(0, hold_place_);
  held_count_ = coupling_->set_held(hold_place_, static_cast<int>(skirt_->points()));
  constexpr double any_step = 1;        // s: only the places matter ...
  constexpr double moved_cells = 0.25;  // ... that differ
  const double moved = moved_cells * metres_per_mm * scene_.tube.grid_spacing;
  std::vector<double> taken;
  // Rows after time.end count, too: a run that goes on to a later end must not differ from one in one piece.
  for (const double time : motion->table().times()) {
    place_hold(time, hold_place_);
    if (!taken.empty() && std::equal(taken.begin(), taken.end(), hold_place_.begin(), [&](double a, double b) { return std::abs(a - b) < moved; })) continue;
    taken = hold_place_;
    carry_hold(time, any_step);
    coupling_->allow_for_held_mobility();
  }
}

void Simulation::book_unseen_motion(State& state) {
  state.unseen_shift.resize(state.x.size());
  parallel_for(static_cast<std::ptrdiff_t>(state.x.size()), [&](std::ptrdiff_t a) {
    const std::size_t q = static_cast<std::size_t>(a);
    state.unseen_shift[q] = state.x[q] - x_before_[q];
  });
  state.unseen_work = work_on(state.unseen_shift);
  state.ledger.coupling_loss += state.unseen_work;
}

double Simulation::largest_motion(const State& state, std::size_t count) const {
  std::vector<double> largest(static_cast<std::size_t>(thread_count()), 0.0);
  parallel_ranges(static_cast<std::ptrdiff_t>(count), [&](std::ptrdiff_t begin, std::ptrdiff_t end, int thread) {
    // Four sums side by side; a NaN stays in `sum`, where max() would lose it.
    constexpr std::ptrdiff_t side = 4;
    double most[side] = {}, sum[side] = {};
    std::ptrdiff_t a = begin;
    for (; a + side <= end; a += side)
      for (std::ptrdiff_t k = 0; k < side; ++k) {
        const double move = std::abs(state.x[static_cast<std::size_t>(a + k)] - x_before_[static_cast<std::size_t>(a + k)]);
        most[k] = move > most[k] ? move : most[k];
        sum[k] += move;
      }
    for (; a < end; ++a) {
      const double move = std::abs(state.x[static_cast<std::size_t>(a)] - x_before_[static_cast<std::size_t>(a)]);
      most[0] = move > most[0] ? move : most[0];
      sum[0] += move;
    }
    double& all = largest[static_cast<std::size_t>(thread)];
    for (std::ptrdiff_t k = 0; k < side; ++k) all = std::isfinite(sum[k]) ? std::max(all, most[k]) : NAN;
  });
  double moved = 0;
  for (double l : largest) {
    if (std::isnan(l)) return NAN;
    moved = std::max(moved, l);
  }
  return moved;
}

void Simulation::add_unseen(State& state, std::span<const int> nodes, std::span<const Eigen::Vector3d> shifts) {
  if (nodes.empty()) return;
  state.unseen_shift.resize(state.x.size(), 0.0);
  double work = 0;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const std::size_t a = 3 * static_cast<std::size_t>(nodes[k]);
    work += Vec3::Map(forces_.data() + a).dot(shifts[k]);
    Vec3::Map(state.unseen_shift.data() + a) += shifts[k];
  }
  state.unseen_work += work;
  state.ledger.coupling_loss += work;
}

void Simulation::guard_motion(State& state, double dt) {
  if (!guard_ && !wall_limit_) return;
  auto start = Clock::now();
  const std::size_t leaflet_size = 3 * static_cast<std::size_t>(structure_->leaflet_nodes());
  // Far-flung nodes make the search as long as the box. Such a step is left to failure(), also where stopping nodes would have brought it within the limit:
  // half the step does the same with less.
  if (outside_ > 0 || !(largest_motion(state, leaflet_size) < largest_move * motion_scale())) return;
  const std::span<double> leaflets(state.x.data(), leaflet_size);
  if (wall_limit_) {
    wall_limit_->apply(leaflets);
    add_unseen(state, wall_limit_->moved(), wall_limit_->shifts());
    times_.coupling += seconds_since(start);
    start = Clock::now();
  }
  if (!guard_) return;
  guard_->apply(std::span<const double>(x_before_.data(), leaflet_size), leaflets);
  if (fluid_) add_unseen(state, guard_->moved(), guard_->shifts());
  else state.ledger.damping_loss += slow_down(state, dt);
  times_.contact += seconds_since(start);
}

double Simulation::slow_down(State& state, double dt) const {
  double lost = 0;
  for (std::size_t k = 0; k < guard_->moved().size(); ++k) {
    const std::size_t node = static_cast<std::size_t>(guard_->moved()[k]);
    Eigen::Map<Vec3> v(state.v.data() + 3 * node);
    const Vec3 after = v + guard_->shifts()[k] / dt;
    lost += 0.5 * structure_->masses()[node] * (v.squaredNorm() - after.squaredNorm());
    v = after;
  }
  return lost;
}

double Simulation::work_on(const std::vector<double>& shift) const {
  return parallel_sum(static_cast<std::ptrdiff_t>(shift.size()), [&](std::ptrdiff_t a) { return forces_[static_cast<std::size_t>(a)] * shift[static_cast<std::size_t>(a)]; });
}

double Simulation::motion_scale() const { return metres_per_mm * (fluid_ ? scene_.tube.grid_spacing : 1.0); }

std::string Simulation::failure(State& state, int outside) const {
  if (outside > 0) return fmt::format("{} leaflet points left the fluid box", outside);
  if (!structure_->solid().statistics().is_finite) return "the tissue's energy is not finite";
  if (const SolidStatistics& solid = structure_->solid().statistics();
      static_cast<double>(solid.inverted) > inverted_share_allowed * static_cast<double>(structure_->solid().element_count())) {
    const auto element = static_cast<std::size_t>(solid.J_min_element);
    const auto node = static_cast<std::size_t>(scene_.mesh.tets[element][0]);
    const Vec2 uv = scene_.mesh.unfolded[node];
    return fmt::format("{} elements are inverted, the worst is element {} (layer {}, at u {:.1f} mm, v {:.1f} mm of the flat pattern)", solid.inverted, element,
                       scene_.mesh.layer[element], uv.x(), uv.y());
  }
  const double limit = largest_move * motion_scale();
  const double moved = largest_motion(state, state.x.size());
  if (!(moved < limit))
    for (std::size_t a = 0; a < state.x.size(); ++a)
      if (const double move = std::abs(state.x[a] - x_before_[a]); !(move < limit)) return fmt::format("node {} moved {:.3g} mm in one step", a / 3, 1e3 * move);
  state.fastest = moved / state.dt;
  if (!std::isfinite(state.flow_rate)) return "the flow is not finite";
  return "";
}

std::string Simulation::step(State& state, double stop_time) {
  if (!has_snapshot_ || (state.step % snapshot_every == 0 && state.step != snapshot_.step)) {
    snapshot_ = state;
    has_snapshot_ = true;
  }
  std::string limiter;
  double dt = state.dt;
  std::string reason;
  try {
    dt = choose_step(state, stop_time, limiter);
    advance(state, dt);
    reason = failure(state, outside_);
  } catch (const TrustError& error) {
    reason = error.what();
  }
  if (!reason.empty()) {
    const long in_a_row = state.rollbacks_in_a_row + 1;
    if (in_a_row > rollbacks_allowed)
      throw TrustError(fmt::format("the run cannot go on at {:.6f} s after {} smaller steps: {}", state.time, rollbacks_allowed, reason));
    const long total = state.rollbacks + 1;
    spdlog::warn("step {} at {:.6f} s: {}; back to {:.6f} s with steps of {:.3g} us", state.step, state.time, reason, snapshot_.time, 0.5e6 * dt);
    const double cap = 0.5 * std::min(dt, state.dt_cap);
    state = snapshot_;
    state.dt_cap = cap;
    state.cap_until_step = state.step + cap_steps;
    state.next_estimate = state.last_estimate = state.step;
    state.rollbacks = total;
    state.rollbacks_in_a_row = in_a_row;
    snapshot_ = state;
    return "retry";
  }
  if (state.step >= state.cap_until_step) {
    state.dt_cap = 1e300;
    state.rollbacks_in_a_row = 0;
  }
  return limiter;
}

void Simulation::refresh(State& state) {
  State copy = state;
  PartTimes ignored;
  if (structure_->contact()) structure_->contact()->import_history(copy.friction_slip);
  structure_->evaluate(copy, 0.0, waveform_.at(state.time), forces_, ignored);
  if (structure_->contact()) structure_->contact()->import_history(state.friction_slip);
}

const std::vector<double>& Simulation::pressure_of_contact(const State& state) {
  const SelfContact& contact = *structure_->contact();
  const ContactSurface& surface = structure_->surface();
  std::vector<double> push(state.x.size(), 0.0);
  const auto nodal = contact.nodal_force();
  for (std::size_t s = 0; s < surface.nodes.size(); ++s) Vec3::Map(push.data() + 3 * surface.nodes[s]) = nodal[s];
  std::vector<double> x = state.x, v = state.v;
  coupling_->bind({x, v, structure_->is_fixed()});
  force_density_.set_zero();
  coupling_->hand_over(push, force_density_);
  fluid_->project(force_density_);
  return fluid_->last_potential();
}

double Simulation::flow_backward(const State& state) const {
  if (!fluid_) return 0.0;
  return fluid_->flow_through_z(state.flow, fluid_->grid().n[2] / 2);
}

double Simulation::kinetic_energy(const State& state) const {
  double energy = fluid_ ? fluid_->kinetic_energy(state.flow) : 0.0;
  if (!fluid_)
    for (std::size_t i = 0; i < structure_->masses().size(); ++i) energy += 0.5 * structure_->masses()[i] * Vec3::Map(state.v.data() + 3 * i).squaredNorm();
  return energy;
}

double Simulation::total_energy(const State& state) const {
  return kinetic_energy(state) + state.elastic_energy + state.chordae_energy + state.contact_energy;
}

double Simulation::energy_residual(const State& state) const {
  const EnergyLedger& l = state.ledger;
  const double gained = total_energy(state) - state.initial_energy;
  const double unexplained = l.work_pressure + l.work_moved + l.boundary_kinetic - l.viscous_loss - l.advection_loss - l.friction_loss - l.damping_loss - l.coupling_loss - gained;
  return std::abs(unexplained) / std::max(std::abs(l.work_pressure) + std::abs(l.work_moved), 1e-9);
}

}  // namespace mv
