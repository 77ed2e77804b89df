// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/prediction.h"

#include <algorithm>
#include <cmath>

#include "pipeline/annulus_stage.h"
#include "pipeline/mesh_stage.h"
#include "pipeline/source_stage.h"
#include "pipeline/tube_stage.h"

namespace mv {
namespace {

// Measured on two cores: 9 ms a step for 100k cells and 76k linear tetrahedra, of which the fluid takes 3.7 ms.
constexpr double seconds_per_cell = 37e-9;
constexpr double seconds_per_linear_tet = 70e-9;
constexpr double quadratic_factor = 5;  // ten nodes and four integration points

// Measured: 1e-5 s is stable, 1.5e-5 s is not, at 0.5 mm with chordae of 20 MPa.
constexpr double reference_step = 1e-5;
constexpr double reference_spacing = 0.5;     // mm
constexpr double reference_stiffness = 20e6;  // Pa

constexpr double bytes_per_cell = 200;   // 25 doubles: velocities and their stages, pressure, transforms, forces
constexpr double bytes_per_tet = 500;    // connectivity, shape gradients, fibre frame, stress, output
constexpr double bytes_per_point = 400;  // positions, velocities, forces, kernel weights, contact lists
constexpr double bytes_of_program = 80e6;

double mean_edge(const MidSurface& surface) {
  double sum = 0;
  for (const auto& t : surface.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      sum += (surface.points[static_cast<std::size_t>(t[k])] - surface.points[static_cast<std::size_t>(t[(k + 1) % 3])]).norm();
    }
  }
  return surface.triangles.empty() ? 0 : sum / (3.0 * static_cast<double>(surface.triangles.size()));
}

}  // namespace

Prediction predict_run(const Config& config, const CaseSize& size) {
  Prediction p;
  const auto cells = static_cast<double>(size.fluid_cells), tets = static_cast<double>(size.tets),
             points = static_cast<double>(size.points);
  const double order_factor = size.order == 2 ? quadratic_factor : 1;
  p.memory_mb =
      (bytes_of_program + bytes_per_cell * cells + bytes_per_tet * tets * order_factor + bytes_per_point * points) / 1e6;
  p.seconds_per_step = seconds_per_cell * cells + seconds_per_linear_tet * tets * order_factor;

  const double node_distance = size.edge_mean / (size.order == 2 ? 2 : 1);
  const double chordae_factor = std::min(1.0, std::sqrt(reference_stiffness / config.number("chordae.stiffness")));
  p.step_s = reference_step * node_distance / reference_spacing * chordae_factor;
  p.limiter = chordae_factor < 1 ? "chordae stiffness" : "tissue stiffness and solid spacing";
  if (!config.is_auto("time.step_fixed")) {
    p.step_s = config.number("time.step_fixed");
    p.limiter = "time.step_fixed";
  } else if (p.step_s > config.number("time.step_max")) {
    p.step_s = config.number("time.step_max");
    p.limiter = "time.step_max";
  }
  p.steps = std::ceil(config.number("time.end") / p.step_s);
  p.run_s = p.steps * p.seconds_per_step;
  return p;
}

CaseSize measure_case(const Config& config) {
  const SourceGeometry source = make_source(config);
  const LeafletMesh mesh = make_mesh(config, source);
  const Annulus annulus = make_annulus(source, source.papillary);
  CaseSize size;
  size.points = static_cast<long>(mesh.points.size());
  size.tets = static_cast<long>(mesh.tets.size());
  size.order = mesh.order;
  size.edge_mean = mean_edge(source.surface);
  if (config.flag("fluid.enabled")) {
    const Tube tube = make_tube(config, annulus, mesh, source.papillary, nullptr);
    size.fluid_cells = static_cast<long>(tube.grid_cells[0]) * tube.grid_cells[1] * tube.grid_cells[2];
  }
  return size;
}

}  // namespace mv
