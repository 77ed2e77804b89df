// SPDX-License-Identifier: BSD-3-Clause
#include "solver/time/structure.h"

#include <chrono>
#include <numeric>

#include "geometry/core/errors.h"
#include "geometry/core/leaflet_names.h"
#include "geometry/core/log.h"
#include "solver/contact/leaflet_contact.h"
#include "solver/output/contact_map.h"

namespace mv {
namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

constexpr double metres_per_mm = 1e-3;
// Range of the penalty over the fluid spacing, unless set.
constexpr double range_share = 0.5;
// The isotropic law stiffens by the whole strain and not along one direction: its exponents grow to 5 in a loaded valve, where fibres stay below 4.
constexpr double isotropic_exponent_limit = 10;
// 1/s, without blood: brings motion to rest within a beat when there is no pressure to speak of.
constexpr double damping_rate_least = 300;

}  // namespace

Material material_of(const Config& config, const std::string& leaflet) {
  const std::string at = "leaflet." + leaflet + ".";
  Material m;
  m.law = law_from_name(config.text(at + "law"));
  m.density = config.number("leaflet.density");
  m.bulk = config.number("leaflet.bulk");
  m.m1_c = config.number(at + "m1_c");
  m.m1_a = config.number(at + "m1_a");
  m.m1_b = config.number(at + "m1_b");
  m.hgo_c10 = config.number(at + "hgo_c10");
  m.hgo_k1 = config.number(at + "hgo_k1");
  m.hgo_k2 = config.number(at + "hgo_k2");
  m.hgo_kappa = config.number(at + "hgo_kappa");
  const auto& mu = config.numbers(at + "ogden_mu");
  const auto& alpha = config.numbers(at + "ogden_alpha");
  if (mu.size() != 3 || alpha.size() != 3) throw ConfigError(at + "ogden_mu and ogden_alpha: three values each were expected (Ogden, N = 3)");
  for (std::size_t i = 0; i < 3; ++i) {
    m.ogden_mu[i] = mu[i];
    m.ogden_alpha[i] = alpha[i];
  }
  // Isochoric invariants: the blood's pressure carries the mean stress. With the plain I4 a taut fibre swells the tissue by a third of its
  // stress over the bulk modulus, which the interpolated velocity does not resist below the width of its kernel.
  m.has_modified_fibre_invariant = true;
  m.neo_mu = config.number(at + "neo_mu");
  m.iso_c0 = config.number(at + "iso_c0");
  m.iso_c1 = config.number(at + "iso_c1");
  m.iso_c2 = config.number(at + "iso_c2");
  if (!config.is_auto("leaflet.exponent_limit")) m.exponent_limit = config.number("leaflet.exponent_limit");
  else if (m.law == Law::isotropic_exponential) m.exponent_limit = isotropic_exponent_limit;
  if (!config.is_auto("leaflet.poisson_ratio")) {
    const double nu = config.number("leaflet.poisson_ratio"), shear = ground_shear_modulus(m);
    if (!(shear > 0)) throw ConfigError(at + "law has no shear modulus at rest from which leaflet.poisson_ratio could make a volumetric stiffness; set leaflet.bulk");
    m.bulk = 2 * shear * (1 + nu) / (3 * (1 - 2 * nu));
  }
  m.distortion_strain = config.number("leaflet.distortion_strain");
  m.distortion_factor = config.number("leaflet.distortion_factor");
  if (config.text("fibers.model") == "none") {
    // Without fibres the fibre terms of M1 and HGO would follow an arbitrary direction.
    m.m1_a = 0;
    if (m.law == Law::hgo) m.hgo_kappa = 1.0 / 3.0;
  }
  return m;
}

ChordaLaw chorda_law_of(const Config& config, int leaflet) {
  ChordaLaw law;
  law.youngs_modulus = config.number("chordae.stiffness");
  if (config.text("chordae.law") == "linear") return law;
  law.is_ogden = true;
  // A chorda that holds both leaflets or none that is known takes the anterior leaflet's law.
  const std::string name = leaflet_name(leaflet).empty() ? "anterior" : leaflet_name(leaflet);
  const std::string at = "chordae." + name + ".";
  const auto& mu = config.numbers(at + "ogden_mu");
  const auto& alpha = config.numbers(at + "ogden_alpha");
  if (mu.size() != 3 || alpha.size() != 3) throw ConfigError(at + "ogden_mu and ogden_alpha: three values each were expected (0 leaves a term out)");
  for (std::size_t i = 0; i < 3; ++i) {
    law.mu[i] = mu[i];
    law.alpha[i] = alpha[i];
  }
  for (const std::string& defect : defects(law)) throw ConfigError(at + "ogden_mu, ogden_alpha: " + defect);
  limit_stiffening(law);
  return law;
}

Structure::Structure(const Scene& scene, double largest_pressure) : has_fluid_(scene.has_fluid()) {
  const Config& config = scene.config;
  const LeafletMesh& mesh = scene.mesh;
  leaflet_nodes_ = static_cast<int>(mesh.points.size());
  auto to_solver = [&](const Vec3& p) { return Vec3(metres_per_mm * (scene.tube.axes * (p - scene.tube.origin))); };

  SolidMesh solid = to_solid_mesh(mesh);
  for (std::size_t i = 0; i < mesh.points.size(); ++i) Vec3::Map(solid.points.data() + 3 * i) = to_solver(mesh.points[i]);
  // Without fibres the laws' fibre terms are off (material_of) and the direction is any.
  const bool has_fibres = config.text("fibers.model") != "none";
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) Vec3::Map(solid.fibres.data() + 3 * e) = has_fibres ? Vec3(scene.tube.axes * mesh.fibre[e]) : Vec3::UnitX();
  rest_ = solid.points;
  std::vector<Material> materials;
  for (const NamedRegion& leaflet : leaflet_names) {
    if (leaflet.region == septal && !has_other_leaflets(mesh)) continue;
    materials.push_back(material_of(config, leaflet.name));
    for (const std::string& warning : warnings(materials.back())) spdlog::warn("leaflet.{}: {}", leaflet.name, warning);
  }
  solid_.emplace(solid, materials);
  masses_ = solid_->node_masses();
  is_fixed_.assign(mesh.on_annulus.begin(), mesh.on_annulus.end());
  const auto& volumes = solid_->node_volumes();
  reference_volume_ = std::accumulate(volumes.begin(), volumes.end(), 0.0);

  for (const Vec3& tip : scene.papillary.tips) tips_.push_back(to_solver(tip));
  if (scene.has_chordae()) {
    chordae_.emplace(scene.chordae, leaflet_nodes_, [&](int leaflet) { return chorda_law_of(config, leaflet); });
    std::vector<Eigen::Vector3d> offsets(scene.chordae.points.size(), Eigen::Vector3d::Zero());
    for (std::size_t p = 0; p < offsets.size(); ++p)
      if (const int muscle = scene.chordae.muscle_of_point[p]; muscle >= 0) offsets[p] = to_solver(scene.chordae.points[p]) - tips_[static_cast<std::size_t>(muscle)];
    chordae_->set_root_offsets(std::move(offsets));
    // Branch points carry half the mass of the segments that meet there.
    const double density = config.number("chordae.density");
    for (int point : chordae_->free_points()) {
      double mass = 0;
      for (const ChordaSegment& s : scene.chordae.segments)
        if (s.a == point || s.b == point) mass += 0.5 * density * s.area * 1e-6 * s.rest_length * metres_per_mm;
      const Vec3 p = to_solver(scene.chordae.points[static_cast<std::size_t>(point)]);
      rest_.insert(rest_.end(), {p.x(), p.y(), p.z()});
      masses_.push_back(mass);
      is_fixed_.push_back(0);
    }
  }

  if (!config.text("annulus.motion").empty()) {
    if (has_fluid_ && config.text("coupling.annulus") == "faces")
      throw ConfigError("annulus.motion: coupling.annulus = \"faces\" holds an annulus that rests; expected \"points\", or fluid.enabled = false");
    const auto file = config.path("annulus.motion");
    annulus_motion_.emplace(MotionTable::read(file), mesh, scene.tube, file.string());
  }
  if (!has_fluid_ && !config.is_auto("time.target_step")) scale_masses(config.number("time.target_step"));

  if (chordae_) {
    BoundaryMotion motion(config, scene.chordae, scene.tube, tips_);
    if (motion.is_active()) motion_.emplace(std::move(motion));
  }

  ventricular_faces_ = faces_on_side(mesh, ventricular).triangles;
  atrial_faces_ = faces_on_side(mesh, atrial).triangles;

  if (!has_fluid_) stand_in_for_blood(config, largest_pressure);

  if (scene.has_contact()) {
    const std::span<const double> leaflet_rest(rest_.data(), 3 * mesh.points.size());
    surface_ = extract_contact_surface(leaflet_rest, mesh.tets, mesh.order, mesh.side,
                                       config.text("contact.faces") == "inner" ? ContactFaces::inner : ContactFaces::both);
    const double spacing = config.number("tube.spacing");
    // On a very coarse grid a range beyond the thickness would press on leaflets at rest.
    const double range = config.is_auto("contact.range") ? std::min(range_share * spacing, config.number("mesh.thickness")) : config.number("contact.range");
    threshold_ = config.is_auto("contact.threshold") ? std::max(range, has_fluid_ ? spacing : 0.0) : config.number("contact.threshold");
    ContactOptions options = leaflet_contact_options(range, config.number("mesh.thickness"), largest_pressure, config.number("contact.stiffness"));
    options.friction = config.number("contact.friction");
    options.search_every = static_cast<int>(config.integer("contact.search_every"));
    contact_ = std::make_unique<SelfContact>(surface_, options);
    hinge_distances_ = rest_distances_to(surface_, is_fixed_);
  }
}

/// Masses such that `target_step` is stable for each element and each chorda alone at rest. Of an element with the critical step s every node's mass grows by
/// (target / s)^2; a node that holds chordae of stiffness k needs target^2 k / 2 for each (ends 2 k / m at most).
void Structure::scale_masses(double target_step) {
  const double before = std::accumulate(masses_.begin(), masses_.end(), 0.0);
  const SolidMesh& mesh = solid_->mesh();
  const std::size_t corners = static_cast<std::size_t>(mesh.nodes_per_tet);
  std::vector<double> steps(static_cast<std::size_t>(solid_->element_count()));
  solid_->critical_step(std::span<const double>(rest_.data(), 3 * static_cast<std::size_t>(leaflet_nodes_)), steps);
  std::vector<double> factor(masses_.size(), 1.0);
  for (std::size_t e = 0; e < steps.size(); ++e)
    for (std::size_t c = 0; c < corners; ++c) {
      double& f = factor[static_cast<std::size_t>(mesh.tets[e * corners + c])];
      f = std::max(f, std::pow(target_step / steps[e], 2));
    }
  for (std::size_t i = 0; i < masses_.size(); ++i) masses_[i] *= factor[i];
  if (chordae_) {
    std::vector<double> stiffness(masses_.size(), 0.0);
    chordae_->add_rest_stiffness(stiffness);
    // Room for the chordae's stiffening: at most stiffening_limit, in a closed valve far less.
    constexpr double stiffening = 4;
    for (std::size_t i = 0; i < masses_.size(); ++i) masses_[i] += stiffening * 0.5 * target_step * target_step * stiffness[i];
  }
  added_mass_share_ = 1 - before / std::accumulate(masses_.begin(), masses_.end(), 0.0);
}

/// Nothing holds dry leaflets back: under 16 kPa one of 1 mm gains 15 m/s in a millisecond and strikes the other at a multiple of what it does in blood. Damping is
/// chosen such that the largest pressure moves a free leaflet at the closing speed, whatever its mass; and with so much damping the mass may grow (mass scaling,
/// which lengthens the stable step by its root) until it delays that speed by the settling time.
void Structure::stand_in_for_blood(const Config& config, double largest_pressure) {
  double area = 0;
  for (const auto& t : ventricular_faces_) {
    const Vec3 a = Vec3::Map(rest_.data() + 3 * t[0]), b = Vec3::Map(rest_.data() + 3 * t[1]), c = Vec3::Map(rest_.data() + 3 * t[2]);
    area += 0.5 * (b - a).cross(c - a).norm();
  }
  if (!(area > 0)) return;
  const double mass_per_area = std::accumulate(masses_.begin(), masses_.begin() + leaflet_nodes_, 0.0) / area;
  const double rate = std::max(largest_pressure / (mass_per_area * config.number("structure.closing_speed")), damping_rate_least);
  mass_factor_ = std::max(1.0, rate * config.number("structure.settling_time"));
  damping_rate_ = rate / mass_factor_;
  for (double& m : masses_) m *= mass_factor_;
}

void Structure::move_boundary(State& state, double dt) {
  motion_->apply(state.time, *chordae_, tips_);  // a rollback may come from another time
  if (!(dt > 0) || !motion_->changes(state.time, state.time + dt)) return;
  const double before = chordae_->energy(state.x, tips_);
  motion_->apply(state.time + dt, *chordae_, tips_);
  // With the nodes at rest, what chordae gain is what moved them.
  state.ledger.work_moved += chordae_->energy(state.x, tips_) - before;
}

void Structure::evaluate(State& state, double dt, double ventricular_pressure, std::span<double> forces, PartTimes& times) {
  std::fill(forces.begin(), forces.end(), 0.0);
  if (motion_) move_boundary(state, dt);
  const std::size_t leaflet_size = 3 * static_cast<std::size_t>(leaflet_nodes_);
  const std::span<const double> x(state.x.data(), leaflet_size);
  auto start = Clock::now();
  state.elastic_energy = solid_->forces(x, forces.first(leaflet_size));
  const SolidStatistics& statistics = solid_->statistics();
  state.J_min = statistics.J_min;
  state.J_max = statistics.J_max;
  state.controlled_fraction_max = std::max(state.controlled_fraction_max, statistics.controlled_fraction);
  times.solid += seconds_since(start);

  if (chordae_) {
    start = Clock::now();
    state.chordae_energy = chordae_->forces(state.x, tips_, forces);
    times.chordae += seconds_since(start);
  }
  if (contact_) {
    start = Clock::now();
    contact_result_ = contact_->evaluate(x, std::span<const double>(state.v.data(), leaflet_size), dt, forces.first(leaflet_size));
    state.contact_energy = contact_result_.potential_energy + contact_result_.friction_energy;
    state.ledger.friction_loss += contact_result_.friction_dissipation;
    state.penetration_max = std::max(state.penetration_max, contact_result_.penetration_max);
    times.contact += seconds_since(start);
  }
  if (!has_fluid_ && ventricular_pressure != 0) {
    for (const auto& t : ventricular_faces_) {
      const Vec3 a = Vec3::Map(state.x.data() + 3 * t[0]), b = Vec3::Map(state.x.data() + 3 * t[1]), c = Vec3::Map(state.x.data() + 3 * t[2]);
      const Vec3 push = -ventricular_pressure / 6.0 * (b - a).cross(c - a);
      for (int node : t) Vec3::Map(forces.data() + 3 * node) += push;
    }
  }
}

void Structure::begin_products(std::span<const double> x) {
  x_of_products_ = x;
  const std::size_t leaflet_size = 3 * static_cast<std::size_t>(leaflet_nodes_);
  tissue_forces_.assign(leaflet_size, 0.0);
  solid_->forces(x.first(leaflet_size), tissue_forces_);
}

void Structure::stiffness_times(std::span<const double> v, std::span<double> out, std::array<double, 3>& shares) {
  const std::span<const double> x = x_of_products_;
  const std::size_t leaflet_size = 3 * static_cast<std::size_t>(leaflet_nodes_);
  std::fill(out.begin(), out.end(), 0.0);
  auto product = [&] { return std::inner_product(out.begin(), out.end(), v.begin(), 0.0); };
  solid_->forces_directional(x.first(leaflet_size), tissue_forces_, v.first(leaflet_size), out.first(leaflet_size));
  shares[0] = product();
  if (chordae_) chordae_->stiffness_times(x, tips_, v, out);
  shares[1] = product() - shares[0];
  if (contact_) {
    const auto normal = contact_->normal();
    for (int s = 0; s < surface_.node_count(); ++s) {
      const double k = contact_->tangent_stiffness(s);
      if (!(k > 0)) continue;
      // Both passes act on a node: once as a slave, once through the facets it is a corner of.
      const Vec3& n = normal[static_cast<std::size_t>(s)];
      const int node = surface_.nodes[static_cast<std::size_t>(s)];
      Vec3::Map(out.data() + 3 * node) += 2.0 * k * n.dot(Vec3::Map(v.data() + 3 * node)) * n;
    }
  }
  shares[2] = product() - shares[0] - shares[1];
}

}  // namespace mv
