// SPDX-License-Identifier: BSD-3-Clause
#include "verification/two_sheets_model.h"

#include <algorithm>
#include <cmath>

#include "geometry/core/case.h"

#include "solver/contact/leaflet_contact.h"

namespace mv::test {
namespace {

constexpr double slab_width = 16e-3;                        // m
constexpr double below_sheets = 8e-3, above_sheets = 4e-3;  // m, blood beyond the sheets' ends
constexpr double block_thickness = 2.0;                     // cells: no kernel reaches through
constexpr int measurements = 10;                            // over the last fifth of a run

double mesh_spacing(const TwoSheetsSpec& s) { return 0.5 * s.h; }

/// Opposite node pairs (left, right) of the middle half, first plane left out with its copy: every column but the last.
std::vector<std::array<int, 2>> facing_pairs(const TwoSheets& m) {
  std::vector<std::array<int, 2>> pairs;
  for (int k = m.left.nz / 4; k <= 3 * m.left.nz / 4; ++k)
    for (int j = 0; j < m.left.columns; ++j) pairs.push_back({m.left.node(m.left.nx, j, k), m.right.node(0, j, k)});
  return pairs;
}

/// Penalty and gap over the pairs.
BeltMeans measure_contact(const TwoSheets& m, const ContactSurface& surface, const SelfContact& contact,
                          const std::vector<double>& x) {
  std::vector<double> pressure(static_cast<std::size_t>(surface.solid_nodes), 0.0);
  for (std::size_t s = 0; s < surface.nodes.size(); ++s)
    pressure[static_cast<std::size_t>(surface.nodes[s])] = contact.pressure()[s];
  BeltMeans means;
  means.penalty_min = 1e300;
  means.penalty_max = -1e300;
  const auto pairs = facing_pairs(m);
  for (const auto& pair : pairs) {
    const double mean = 0.5 * (pressure[static_cast<std::size_t>(pair[0])] + pressure[static_cast<std::size_t>(pair[1])]);
    means.penalty += mean / static_cast<double>(pairs.size());
    means.penalty_min = std::min(means.penalty_min, mean);
    means.penalty_max = std::max(means.penalty_max, mean);
    means.gap +=
        (x[static_cast<std::size_t>(3 * pair[1])] - x[static_cast<std::size_t>(3 * pair[0])]) / static_cast<double>(pairs.size());
  }
  return means;
}

BeltMeans measure_in_blood(const TwoSheets& m, SlabFlow& slab) {
  const std::vector<double> on_grid = slab.pressure_of(slab.contact_forces());
  BeltMeans means = measure_contact(m, slab.surface(), slab.contact(), slab.x());
  means.sum_min = 1e300;
  means.sum_max = -1e300;
  const auto pairs = facing_pairs(m);
  for (const auto& pair : pairs) {
    const auto at = [&](int node) { return Eigen::Vector3d::Map(slab.x().data() + 3 * node); };
    const Eigen::Vector3d middle = 0.5 * (at(pair[0]) + at(pair[1]));
    const double film = pressure_at(m.grid, slab.flow().pressure, middle), potential = pressure_at(m.grid, on_grid, middle);
    means.film += film / static_cast<double>(pairs.size());
    means.contact_on_grid += potential / static_cast<double>(pairs.size());
    means.sum_min = std::min(means.sum_min, film - potential);
    means.sum_max = std::max(means.sum_max, film - potential);
  }
  return means;
}

/// Adds the forces of a pressure on the sheets' outer faces.
void push_outer_faces(const TwoSheets& m, double pressure, const std::vector<double>& x, std::vector<double>& forces) {
  for (const Plate& plate : {m.left, m.right}) {
    const bool is_left = plate.first == m.left.first;
    const int i = is_left ? 0 : plate.nx;
    for (int k = 0; k < plate.nz; ++k)
      for (int j = 0; j < plate.columns; ++j) {
        const std::array<int, 4> quad{plate.node(i, j, k), plate.node(i, j + 1, k), plate.node(i, j + 1, k + 1),
                                      plate.node(i, j, k + 1)};
        const auto at = [&](std::size_t q) { return Eigen::Vector3d::Map(x.data() + 3 * quad[q]); };
        // Half the diagonals' cross product is the area vector, along +x; a quarter of it to each corner.
        const Eigen::Vector3d push = (is_left ? 0.125 : -0.125) * pressure * (at(2) - at(0)).cross(at(3) - at(1));
        for (int node : quad) Eigen::Vector3d::Map(forces.data() + 3 * node) += push;
      }
  }
}

/// Mean in time of the sums, extremes in time of the extremes.
struct TimeMean {
  BeltMeans value;
  int count = 0;
  void add(const BeltMeans& b) {
    value.penalty += b.penalty / measurements;
    value.gap += b.gap / measurements;
    value.film += b.film / measurements;
    value.contact_on_grid += b.contact_on_grid / measurements;
    value.sum_min = count ? std::min(value.sum_min, b.sum_min) : b.sum_min;
    value.sum_max = count ? std::max(value.sum_max, b.sum_max) : b.sum_max;
    value.penalty_min = count ? std::min(value.penalty_min, b.penalty_min) : b.penalty_min;
    value.penalty_max = count ? std::max(value.penalty_max, b.penalty_max) : b.penalty_max;
    ++count;
  }
};

/// Calls advance(pressure) to `end` and measure() in the last fifth.
template <class Advance, class Measure>
BeltMeans run(const TwoSheetsSpec& spec, double dt, double end, Advance advance, Measure measure) {
  const long steps = std::lround(end / dt), every = steps / (5 * measurements);
  TimeMean mean;
  for (long step = 1; step <= steps; ++step) {
    advance(spec.pressure * std::min(1.0, static_cast<double>(step) * dt / spec.ramp));
    if ((steps - step) % every == 0 && (steps - step) / every < measurements) mean.add(measure());
  }
  return mean.value;
}

}  // namespace

TwoSheets make_two_sheets(const TwoSheetsSpec& spec) {
  TwoSheets m;
  m.grid = slab_grid({0, slab_width}, {-below_sheets, spec.length + above_sheets}, spec.h, spec.cells_deep);
  const double spacing = mesh_spacing(spec), middle = 0.5 * slab_width, half_gap = 0.5 * spec.gap * spec.h;
  m.tissue.depth = spec.cells_deep * spec.h;
  m.tissue.columns = static_cast<int>(std::lround(m.tissue.depth / spacing));
  const int layers = std::max(2, static_cast<int>(std::lround(spec.thickness / spacing)));
  const int rows = static_cast<int>(std::lround(spec.length / spacing));
  const double outer_left = middle - half_gap - spec.thickness, outer_right = middle + half_gap + spec.thickness;
  m.left = m.tissue.add_plate({outer_left, middle - half_gap}, layers, {0, spec.length}, rows);
  m.right = m.tissue.add_plate({middle + half_gap, outer_right}, layers, {0, spec.length}, rows);
  for (const Plate& plate : {m.left, m.right})
    for (int k = 0; k <= rows; ++k)
      for (int j = 0; j <= plate.columns; ++j) {
        const bool is_left = plate.first == m.left.first;
        m.tissue.side[static_cast<std::size_t>(plate.node(0, j, k))] = is_left ? ventricular : atrial;
        m.tissue.side[static_cast<std::size_t>(plate.node(layers, j, k))] = is_left ? atrial : ventricular;
        if (k == 0 || k == rows)
          for (int i = 0; i <= layers; ++i) m.tissue.is_held[static_cast<std::size_t>(plate.node(i, j, k))] = 1;
      }
  const double block = block_thickness * spec.h, inset = 0.25 * spacing;
  const auto add_block = [&](Range x, Range z) {
    const std::vector<double> points = block_points(x, z, spacing, m.tissue.depth, m.tissue.columns);
    m.held_points.insert(m.held_points.end(), points.begin(), points.end());
  };
  add_block({inset, outer_left - spacing}, {spec.length - block, spec.length});
  add_block({outer_right + spacing, slab_width - inset}, {spec.length - block, spec.length});
  add_block({outer_left, outer_right}, {-block, -spacing});
  return m;
}

ContactOptions sheet_contact(const TwoSheetsSpec& spec) {
  constexpr double range_share = 0.5;  // as in solver/time/structure.cpp
  return leaflet_contact_options(range_share * spec.h, spec.thickness, spec.pressure);
}

Material sheet_material() {
  Material m;
  m.law = Law::neo_hookean;
  m.neo_mu = 100e3;
  m.bulk = 1e6;
  return m;
}

BeltMeans press_in_blood(const TwoSheetsSpec& spec, double dt, double end) {
  const TwoSheets m = make_two_sheets(spec);
  SlabSetup setup;
  setup.grid = m.grid;
  setup.kernel = spec.kernel;
  setup.material = sheet_material();
  setup.relaxation = spec.relaxation;
  SlabFlow slab(setup, m.tissue, m.held_points);
  std::optional<FilmDrainageOptions> drainage;
  if (spec.is_drained) {
    drainage.emplace();
    drainage->drainage_time = spec.drainage_time;
    drainage->pressure_scale = spec.pressure;
  }
  slab.set_contact(sheet_contact(spec), drainage);
  return run(
      spec, dt, end, [&](double p) { slab.advance(dt, p); }, [&] { return measure_in_blood(m, slab); });
}

BeltMeans press_dry(const TwoSheetsSpec& spec, double dt, double end) {
  constexpr double damping_rate = 300.0;  // 1/s, structural_damping_rate of solver/time/simulation.cpp
  const TwoSheets m = make_two_sheets(spec);
  LeafletSolid solid(m.tissue.mesh, {sheet_material()});
  const ContactSurface surface = facing_surface(m.tissue);
  const std::unique_ptr<SelfContact> contact = make_contact(surface, sheet_contact(spec));
  std::vector<double> x = m.tissue.mesh.points, v(x.size(), 0.0), forces(x.size()), masses(x.size());
  for (std::size_t a = 0; a < x.size(); ++a) masses[a] = solid.node_masses()[a / 3];
  m.tissue.gather_copies(masses);
  for (double& mass : masses) mass = std::max(mass, 1e-30);  // copies carry nothing and follow
  const auto advance = [&](double pressure) {
    std::fill(forces.begin(), forces.end(), 0.0);
    solid.forces(x, forces);
    contact->evaluate(x, v, dt, forces);
    push_outer_faces(m, pressure, x, forces);
    m.tissue.gather_copies(forces);
    const double decay = 1.0 / (1.0 + dt * damping_rate);
    for (std::size_t a = 0; a < x.size(); ++a) {
      if (m.tissue.is_held[a / 3]) continue;
      v[a] = (v[a] + dt * forces[a] / masses[a]) * decay;
      x[a] += dt * v[a];
    }
    m.tissue.follow_first_plane(x, v);
  };
  return run(spec, dt, end, advance, [&] { return measure_contact(m, surface, *contact, x); });
}

}  // namespace mv::test
