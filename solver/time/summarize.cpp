// SPDX-License-Identifier: BSD-3-Clause
#include "solver/time/summarize.h"

#include <fmt/format.h>

#include <cmath>

#include "geometry/core/leaflet_names.h"
#include "geometry/core/parallel.h"
#include "geometry/core/unfolded.h"
#include "solver/contact/intersection.h"
#include "solver/output/carried_annulus.h"
#include "solver/output/contact_map.h"
#include "solver/seal/belt.h"
#include "solver/seal/seal.h"
#include "solver/seal/valve_metrics.h"
#include "solver/solid/stress.h"
#include "solver/time/stress_areas.h"

namespace mv {
namespace {

constexpr double ml_per_m3 = 1e6;
// Trust gates.
constexpr double energy_residual_limit = 0.05;
constexpr double volume_drift_limit = 0.01;
// Without blood nothing but its bulk modulus keeps tissue from swelling under tension.
constexpr double dry_volume_drift_limit = 0.05;
constexpr double kinetic_share_limit = 0.05;

void put_seal(Summary& summary, const Simulation& simulation, const std::vector<Vec3>& points, double threshold_mm) {
  const Scene& scene = simulation.scene();
  SealInput input;
  input.points = points;
  input.triangles = boundary_faces(scene.mesh).triangles;
  input.region.assign(points.size(), 0);
  for (std::size_t e = 0; e < scene.mesh.tets.size(); ++e)
    for (int n = 0; n < scene.mesh.nodes_per_tet(); ++n) input.region[static_cast<std::size_t>(scene.mesh.tets[e][static_cast<std::size_t>(n)])] = scene.mesh.region[e];
  input.unfolded = scene.mesh.unfolded;
  // One interval of u for each leaflet: what lies across the pattern's seam is shifted by its period.
  const double period = unfolded_period(scene.mesh);
  for (std::size_t e = 0; e < scene.mesh.tets.size(); ++e) {
    double highest = -1e300;
    for (int n = 0; n < scene.mesh.nodes_per_tet(); ++n)
      highest = std::max(highest, input.unfolded[static_cast<std::size_t>(scene.mesh.tets[e][static_cast<std::size_t>(n)])].x());
    for (int n = 0; n < scene.mesh.nodes_per_tet(); ++n) {
      double& u = input.unfolded[static_cast<std::size_t>(scene.mesh.tets[e][static_cast<std::size_t>(n)])].x();
      if (period > 0 && highest - u > 0.5 * period) u += period;
    }
  }
  input.annulus = carried_annulus(scene.annulus, scene.mesh, points).points;
  input.tube = scene.tube;
  if (scene.papillary.tips.size() == 2) input.anterolateral = (scene.papillary.tips[0] - scene.papillary.tips[1]).normalized();
  const SealResult seal = find_seal(input, threshold_mm);
  summary.set("seal.sealed", seal.sealed);
  summary.set("seal.certain", seal.certain);
  summary.set("seal.threshold_mm", seal.threshold_mm);
  summary.set("seal.smallest_sealing_threshold_mm", seal.smallest.value_mm);
  summary.set("seal.smallest_sealing_threshold_lower_mm", seal.smallest.lower_mm);
  summary.set("seal.last_passage", seal.smallest.location);
  summary.set("seal.hole_area_mm2", seal.hole_area_mm2);
  Json holes = Json::array();
  for (const Hole& hole : seal.holes)
    holes.push_back({{"location", hole.location},
                     {"place_mm", {hole.place.x(), hole.place.y(), hole.place.z()}},
                     {"area_mm2", hole.area_mm2},
                     {"width_mm", hole.width_mm}});
  summary.set("seal.holes", holes);
  summary.set("seal.grid_spacing_mm", seal.spacing_mm);
}

void put_contact(Summary& summary, const Simulation& simulation, const State& state, const std::vector<Vec3>& points, const ContactMeasure& contact) {
  const Scene& scene = simulation.scene();
  // The map, because there each leaflet is one interval of u: points on the pattern's seam stand twice.
  const ContactMap map = make_contact_map(scene.mesh, contact.traction, std::span<const double>(contact.force.front().data(), 3 * contact.force.size()),
                                          contact.gap, contact.in_contact);
  BeltInput input;
  input.unfolded = map.points;
  input.triangles = map.triangles;
  input.in_contact = map.in_belt;
  for (int point : map.mesh_point) input.current.push_back(points[static_cast<std::size_t>(point)]);
  // The map keeps the order of the faces.
  for (int element : faces_on_side(scene.mesh, atrial).element) input.region.push_back(scene.mesh.region[static_cast<std::size_t>(element)]);
  // Two points of a face nearer than this, along the solid, are never seen to touch: contact cannot tell a crease from a gap below it.
  BeltOptions options;
  options.spacing_mm = 1e3 * simulation.structure().contact()->options().exclusion_radius;
  const BeltResult belt = measure_belt(input, options);
  summary.set("contact.belt_spacing_mm", options.spacing_mm);
  summary.set("contact.belt_continuous", belt.continuous);
  summary.set("contact.belt_width_mm_mean", belt.width_mean_mm);
  Json interruptions = Json::array();
  for (const BeltInterruption& i : belt.interruptions)
    interruptions.push_back({{"leaflet", leaflet_name(i.region)}, {"u_from_mm", i.u_from}, {"u_to_mm", i.u_to}, {"width_mm", i.width_mm}});
  summary.set("contact.belt_interruptions", interruptions);
  summary.set("contact.threshold_mm", 1e3 * contact.threshold);
  summary.set("contact.range_mm", 1e3 * simulation.structure().contact()->options().threshold);
  summary.set("contact.area_mm2", 1e6 * contact.area);
  summary.set("contact.force_N", contact.force_total);
  summary.set("contact.force_penalty_N", contact.penalty_total);
  summary.set("contact.force_film_N", contact.film_total);
  summary.set("contact.penetration_max_mm", 1e3 * state.penetration_max);
  std::vector<double> gaps;
  for (std::size_t i = 0; i < contact.gap.size(); ++i)
    if (contact.in_contact[i]) gaps.push_back(contact.gap[i]);
  if (!gaps.empty()) {
    std::nth_element(gaps.begin(), gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2), gaps.end());
    summary.set("contact.belt_gap_mm_median", 1e3 * gaps[gaps.size() / 2]);
  }
}

void put_tissue(Summary& summary, const Simulation& simulation, const State& state) {
  const Scene& scene = simulation.scene();
  // The areas are the mitral valve's.
  if (scene.config.text("fibers.model") == "none" || has_other_leaflets(scene.mesh)) return;
  const std::size_t points = scene.mesh.points.size();
  const ElementStress stress = element_stress(simulation.structure().solid(), std::span<const double>(state.x.data(), 3 * points));
  const StressAreas areas = find_stress_areas(scene.mesh, scene.papillary.tips);
  summary.set("tissue.fibre_stress_belly_kPa", 1e-3 * mean_over(scene.mesh, areas.belly, stress.fibre_stress));
  summary.set("tissue.fibre_stress_trigones_kPa", Json::array({1e-3 * mean_over(scene.mesh, areas.trigone[0], stress.fibre_stress),
                                                               1e-3 * mean_over(scene.mesh, areas.trigone[1], stress.fibre_stress)}));
}

/// Where triangles cross, gathered into places at least `apart_mm` from each other on the flat pattern.
Json crossing_places(const LeafletMesh& mesh, const std::vector<std::array<int, 3>>& triangles, const std::vector<std::pair<int, int>>& crossings) {
  constexpr double apart_mm = 3.0;
  struct Place {
    Vec2 uv;
    int side;
    long count;
  };
  std::vector<Place> places;
  for (const auto& [first, second] : crossings)
    for (int t : {first, second}) {
      const auto& corners = triangles[static_cast<std::size_t>(t)];
      const Vec2 uv = mesh.unfolded[static_cast<std::size_t>(corners[0])];
      int side = mesh.side[static_cast<std::size_t>(corners[0])];
      for (int c : corners)
        if (mesh.side[static_cast<std::size_t>(c)] != side) side = 0;
      auto near = std::find_if(places.begin(), places.end(), [&](const Place& p) { return p.side == side && (p.uv - uv).norm() < apart_mm; });
      if (near == places.end()) places.push_back({uv, side, 1});
      else ++near->count;
    }
  Json out = Json::array();
  for (const Place& p : places)
    out.push_back({{"u_mm", p.uv.x()}, {"v_mm", p.uv.y()}, {"face", p.side == atrial ? "atrial" : p.side == ventricular ? "ventricular" : "rim"}, {"triangles", p.count}});
  return out;
}

}  // namespace

Summary summarize(Simulation& simulation, const State& state, const ContactMeasure& contact, const RunFacts& facts) {
  const Scene& scene = simulation.scene();
  const Structure& structure = simulation.structure();
  const std::vector<Vec3> points = world_points(simulation, state);
  Summary summary;
  summary.set("run.end", facts.end);
  if (const NavierStokes* fluid = simulation.fluid()) {
    const FluidGrid& grid = fluid->grid();
    summary.set("fluid.cells", static_cast<long>(grid.cells()));
    summary.set("fluid.cells_in_tube", std::lround(fluid->wall().area / (grid.h * grid.h)) * grid.n[2]);
    summary.set("fluid.spacing_mm", 1e3 * grid.h);
  }
  summary.set("solid.tets", static_cast<long>(scene.mesh.tets.size()));
  summary.set("solid.points", static_cast<long>(scene.mesh.points.size()));
  summary.set("solid.J_min", state.J_min);
  summary.set("solid.J_max", state.J_max);
  summary.set("solid.distortion_controlled_fraction", state.controlled_fraction_max);
  summary.set("run.steps", state.step);
  summary.set("run.wall_s", facts.wall_seconds);
  summary.set("run.threads", thread_count());
  summary.set("run.simulated_s", state.time);
  summary.set("run.dt_mean_s", state.step > 0 ? state.dt_sum / static_cast<double>(state.step) : 0.0);
  summary.set("run.dt_min_s", state.step > 0 ? state.dt_min : 0.0);
  summary.set("run.rollbacks", state.rollbacks);
  const PartTimes& times = simulation.times();
  const double all = std::max(times.sum(), 1e-12);
  summary.set("run.share.fluid", times.fluid / all);
  summary.set("run.share.coupling", times.coupling / all);
  summary.set("run.share.solid", times.solid / all);
  summary.set("run.share.contact", times.contact / all);
  summary.set("run.share.chordae", times.chordae / all);
  summary.set("run.share.step_estimate", times.step_estimate / all);
  summary.set("run.share.output", times.output / all);
  if (simulation.fluid()) {
    const bool has_closed = state.closing_time >= 0;
    summary.set("flow.closing_volume_ml", has_closed ? Json(ml_per_m3 * state.closing_volume) : Json());
    summary.set("flow.closing_time_s", has_closed ? Json(state.closing_time) : Json());
    summary.set("flow.backward_volume_ml", ml_per_m3 * state.volume_backward);
    summary.set("flow.leak_volume_ml", has_closed ? Json(ml_per_m3 * (state.volume_backward - state.volume_at_closure_start - state.closing_volume)) : Json());
    summary.set("flow.leak_rate_ml_s", ml_per_m3 * facts.leak_rate);
    summary.set("flow.leak_window_s", facts.leak_window);
    summary.set("flow.peak_velocity_m_s", facts.peak_velocity);
  }
  const double default_threshold_mm = simulation.fluid() ? 1e3 * simulation.fluid()->grid().h : 0.5;
  put_seal(summary, simulation, points, structure.contact() ? 1e3 * contact.threshold : default_threshold_mm);
  if (structure.contact()) put_contact(summary, simulation, state, points, contact);
  const auto boundary = boundary_faces(scene.mesh).triangles;
  const auto crossings = self_intersections(points, boundary);
  summary.set("contact.self_intersections", static_cast<long>(crossings.size()));
  summary.set("contact.self_intersection_places", crossing_places(scene.mesh, boundary, crossings));

  put_tissue(summary, simulation, state);
  const Annulus annulus = carried_annulus(scene.annulus, scene.mesh, points);
  const AnnulusPlane plane{annulus.origin, -annulus.normal};
  const Triangles atrial_triangles = faces_on_side(scene.mesh, atrial).triangles;
  const Bulging bulging = measure_bulging(points, atrial_triangles, plane);
  summary.set("bulging.volume_ml", bulging.volume_ml);
  summary.set("bulging.area_ratio", bulging.area_ratio);
  summary.set("bulging.height_mm", bulging.height_mm);
  const auto loops = flagged_boundary_loops(atrial_triangles, scene.mesh.on_free_edge);
  if (!loops.empty()) {
    std::vector<Vec3> now, open;
    for (int node : loops.front()) {
      now.push_back(points[static_cast<std::size_t>(node)]);
      open.push_back(scene.mesh.points[static_cast<std::size_t>(node)]);
    }
    summary.set("orifice.area_cm2", orifice_area_cm2(now, open, plane));
    summary.set("orifice.open_area_cm2", orifice_area_cm2(open, open, plane));
  }
  if (const ChordaeTension* chordae = structure.chordae()) {
    const SeriesRow row = measure_series(simulation, state, contact);
    summary.set("chordae.force_primary_N", row.chordae_primary_N);
    summary.set("chordae.force_secondary_N", row.chordae_secondary_N);
    Json forces = Json::array();
    double total = 0;
    for (const auto& pull : chordae->papillary_forces()) {
      forces.push_back(pull.norm());
      total += pull.norm();
    }
    summary.set("papillary.force_N", forces);
    summary.set("papillary.force_total_N", total);
  }
  if (!simulation.fluid()) {
    const double stored = state.elastic_energy + state.chordae_energy;
    summary.set("energy.kinetic_share", stored > 0 ? Json(simulation.kinetic_energy(state) / stored) : Json());
    // With masses that are not the true ones only rest means something.
    const bool is_gated = !scene.config.is_auto("gates.max_kinetic_share") || !scene.config.is_auto("time.target_step");
    if (is_gated)
      summary.set("energy.kinetic_share_allowed", scene.config.is_auto("gates.max_kinetic_share") ? kinetic_share_limit : scene.config.number("gates.max_kinetic_share"));
    summary.set("energy.damping_loss_J", state.ledger.damping_loss);
    summary.set("energy.work_pressure_J", state.ledger.work_pressure);
    summary.set("energy.work_moved_J", state.ledger.work_moved);
    summary.set("energy.elastic_J", state.elastic_energy);
    summary.set("solid.added_mass_share", structure.added_mass_share());
  }
  summary.set("energy.residual_relative", simulation.energy_residual(state));
  summary.set("mass.solid_volume_drift", facts.volume_drift_max);
  summary.set("mass.divergence_relative", simulation.fluid() ? Json(simulation.fluid()->relative_divergence(state.flow)) : Json());
  return summary;
}

std::vector<std::string> failed_trust_gates(const Summary& summary) {
  std::vector<std::string> failed;
  const Json& json = summary.json();
  const Json& crossings = json_at(json, "contact.self_intersections");
  if (crossings.is_number() && crossings.get<long>() > 0) failed.push_back(fmt::format("{} pairs of leaflet triangles cross each other in the last frame", crossings.get<long>()));
  const Json& residual = json_at(json, "energy.residual_relative");
  if (!residual.is_number() || residual.get<double>() > energy_residual_limit)
    failed.push_back(fmt::format("energy residual {:.3g} is above {:.3g}", residual.is_number() ? residual.get<double>() : NAN, energy_residual_limit));
  const Json& kinetic = json_at(json, "energy.kinetic_share");
  const Json& allowed = json_at(json, "energy.kinetic_share_allowed");
  if (kinetic.is_number() && allowed.is_number() && kinetic.get<double>() > allowed.get<double>())
    failed.push_back(fmt::format("not at rest: the kinetic energy is {:.3g} of the elastic one, at most {:.3g} is allowed (gates.max_kinetic_share); let it run longer (time.end)",
                                 kinetic.get<double>(), allowed.get<double>()));
  const Json& drift = json_at(json, "mass.solid_volume_drift");
  const double drift_limit = json_at(json, "fluid.cells").is_number() ? volume_drift_limit : dry_volume_drift_limit;
  if (!drift.is_number() || std::abs(drift.get<double>()) > drift_limit)
    failed.push_back(fmt::format("solid volume drifts by {:.3g}, limit {:.3g}", drift.is_number() ? drift.get<double>() : NAN, drift_limit));
  return failed;
}

}  // namespace mv
