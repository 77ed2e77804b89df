// SPDX-License-Identifier: BSD-3-Clause
#include "solver/time/measure.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mv {
namespace {

constexpr double pascal_per_mmHg = 133.322387415;
// Facing leaflets are looked for up to this many fluid spacings (or, without blood, leaflet thicknesses) away.
constexpr double search_spacings = 4.0;
// Nearer than this to the annulus leaflets fold over their clamped hinge.
constexpr double hinge_thicknesses = 2.5;

}  // namespace

ContactMeasure measure_contact(Simulation& simulation, const State& state, bool is_quick) {
  const Structure& structure = simulation.structure();
  const std::size_t points = static_cast<std::size_t>(structure.leaflet_nodes());
  ContactMeasure m;
  m.gap.assign(points, std::numeric_limits<double>::quiet_NaN());
  m.penalty.assign(points, 0.0);
  m.film.assign(points, 0.0);
  m.traction.assign(points, 0.0);
  m.force.assign(points, Vec3::Zero());
  m.in_contact.assign(points, 0);
  m.threshold = structure.contact_threshold();
  const SelfContact* contact = structure.contact();
  if (!contact) return m;

  const ContactSurface& surface = structure.surface();
  const std::span<const double> x(state.x.data(), 3 * points);
  const NavierStokes* fluid = simulation.fluid();
  const double reach = std::max(m.threshold, search_spacings * (fluid ? fluid->grid().h : 1e-3 * simulation.scene().config.number_in("mesh.thickness", "mm")));
  // The film's search ends at two and a half cells.
  const bool has_recent = is_quick && state.film_gaps.size() == points && fluid && m.threshold <= 2.0 * fluid->grid().h;
  ClosestGaps gaps;
  if (!has_recent) contact->closest_gaps(x, reach, true, gaps);
  std::vector<double> area(static_cast<std::size_t>(surface.node_count()));
  current_tributary_areas(surface, x, area);
  std::vector<Vec3> normals(static_cast<std::size_t>(surface.node_count()));
  current_face_normals(surface, x, normals);
  const auto pressure = contact->pressure();
  const std::vector<double>* const caused_by_contact = fluid ? &simulation.pressure_of_contact(state) : nullptr;
  for (int s = 0; s < surface.node_count(); ++s) {
    const std::size_t n = static_cast<std::size_t>(s);
    // The fold at the clamped hinge is no coaptation.
    const bool is_at_hinge = structure.hinge_distances()[n] < hinge_thicknesses * contact->options().thickness;
    if (!surface.on_atrial_face[n] || is_at_hinge) continue;
    const std::size_t node = static_cast<std::size_t>(surface.nodes[n]);
    // Deeper than the limit the other face is seen from behind.
    const double gap = has_recent ? state.film_gaps[node] : gaps.triangle[n] < 0 ? std::numeric_limits<double>::infinity() : gaps.gap[n];
    if (!std::isfinite(gap) || gap < -contact->options().penetration_limit) continue;
    m.gap[node] = gap;
    m.in_contact[node] = gap < m.threshold;
    m.penalty[node] = pressure[n];
    if (!m.in_contact[node] && m.penalty[node] <= 0) continue;
    m.traction[node] = m.penalty[node];
    if (fluid && m.in_contact[node]) {
      const Vec3 halfway = Vec3::Map(state.x.data() + 3 * node) + 0.5 * std::max(gap, 0.0) * normals[n];
      m.traction[node] = std::max(m.penalty[node], pressure_at(fluid->grid(), state.flow.pressure, halfway) - pressure_at(fluid->grid(), *caused_by_contact, halfway));
      m.film[node] = m.traction[node] - m.penalty[node];
    }
    m.force[node] = -m.traction[node] * area[n] * normals[n];
    m.penalty_total += 0.5 * m.penalty[node] * area[n];
    m.film_total += 0.5 * m.film[node] * area[n];
    if (m.in_contact[node]) m.area += 0.5 * area[n];
  }
  m.force_total = m.penalty_total + m.film_total;
  return m;
}

SeriesRow measure_series(Simulation& simulation, const State& state, const ContactMeasure& contact) {
  SeriesRow row;
  row.time_s = state.time;
  row.dt_s = state.dt;
  row.pressure_difference_mmHg = simulation.pressure_difference(state.time) / pascal_per_mmHg;
  if (const NavierStokes* fluid = simulation.fluid()) {
    row.flow_ml_s = -1e6 * state.flow_rate;
    row.volume_ml = -1e6 * state.volume_backward;
    row.peak_velocity_m_s = fluid->peak_velocity(state.flow);
    row.divergence_max = fluid->relative_divergence(state.flow);
    row.viscous_loss_J = state.ledger.viscous_loss;
    row.advection_loss_J = state.ledger.advection_loss;
    row.boundary_kinetic_J = state.ledger.boundary_kinetic;
  }
  Structure& structure = simulation.structure();
  if (structure.contact()) {
    row.contact_force_N = contact.force_total;
    row.contact_penalty_N = contact.penalty_total;
    row.contact_film_N = contact.film_total;
    row.contact_area_mm2 = 1e6 * contact.area;
    row.penetration_max_mm = 1e3 * structure.contact_result().penetration_max;
    row.friction_loss_J = state.ledger.friction_loss;
  }
  if (const ChordaeTension* chordae = structure.chordae()) {
    const auto& pull = chordae->papillary_forces();
    if (!pull.empty()) row.papillary_force_0_N = pull[0].norm();
    if (pull.size() > 1) row.papillary_force_1_N = pull[1].norm();
    double primary = 0, secondary = 0;
    const auto& segments = simulation.scene().chordae.segments;
    const auto& roots = simulation.scene().chordae.muscle_of_point;
    for (std::size_t s = 0; s < segments.size(); ++s) {
      // A chorda's force is counted where it leaves the muscle.
      if (roots[static_cast<std::size_t>(segments[s].a)] < 0) continue;
      const bool is_primary = segments[s].kind == ChordaKind::primary || segments[s].kind == ChordaKind::marginal;
      (is_primary ? primary : secondary) += chordae->tensions()[s];
    }
    row.chordae_primary_N = primary;
    row.chordae_secondary_N = secondary;
    row.chordae_elastic_J = state.chordae_energy;
  }
  row.kinetic_J = simulation.kinetic_energy(state);
  row.elastic_J = state.elastic_energy;
  row.work_pressure_J = state.ledger.work_pressure;
  row.damping_loss_J = state.ledger.damping_loss;
  row.energy_residual_relative = simulation.energy_residual(state);
  row.J_min = state.J_min;
  row.J_max = state.J_max;
  row.distortion_controlled_fraction = structure.solid().statistics().controlled_fraction;
  row.solid_volume_drift = structure.solid().statistics().volume / structure.reference_volume() - 1.0;
  return row;
}

std::vector<Vec3> world_points(const Simulation& simulation, const State& state) {
  const Tube& tube = simulation.scene().tube;
  std::vector<Vec3> points(static_cast<std::size_t>(simulation.structure().leaflet_nodes()));
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = tube.origin + tube.axes.transpose() * (1e3 * Vec3::Map(state.x.data() + 3 * i));
  return points;
}

}  // namespace mv
