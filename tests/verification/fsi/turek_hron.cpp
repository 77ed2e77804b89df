// SPDX-License-Identifier: BSD-3-Clause
#include "verification/fsi/turek_hron.h"

#include <cmath>

namespace mv::test {
namespace {

constexpr double width = 0.41, length = 2.5, radius = 0.05, centre = 0.2;  // m; the centre has x = z
constexpr double plate_thickness = 0.02, plate_end = 0.6;                   // m
constexpr double density = 1000, viscosity = 1.0;                           // kg/m3, Pa s
constexpr double poisson_ratio = 0.4;
constexpr double rise = 2.0;            // s, of the inflow

}  // namespace

TurekHron::TurekHron(const TurekHronSpec& spec) : spec_(spec) {
  SlabSetup setup = channel_setup(width, length, spec.cells, density, viscosity);
  const double h = setup.grid.h;
  setup.kernel = spec.kernel;
  setup.relaxation = spec.relaxation;
  setup.held_tissue_holds_blood = false;
  const double mu = spec.shear_modulus * (spec.modulus == PlateModulus::matched ? 0.5 / (1 - poisson_ratio) : 1.0);
  setup.material.law = Law::neo_hookean;
  setup.material.neo_mu = mu;
  setup.material.bulk = 2 * mu * (1 + poisson_ratio) / (3 * (1 - 2 * poisson_ratio));
  setup.material.density = density;
  setup.material.distortion_factor = 0;

  SlabTissue tissue;
  tissue.depth = h;
  tissue.columns = 1;
  const double start = centre + std::sqrt(radius * radius - 0.25 * plate_thickness * plate_thickness);
  // Quadratic elements: nodes half a width apart.
  const int nx = std::max(1, static_cast<int>(std::lround(plate_thickness / (2 * spec.spacing_across * h))));
  const int nz = static_cast<int>(std::ceil((plate_end - start) / (2 * spec.spacing_along * h)));
  const Plate plate = tissue.add_plate({centre - 0.5 * plate_thickness, centre + 0.5 * plate_thickness}, nx, {start, plate_end}, nz);
  for (int j = 0; j <= plate.columns; ++j)
    for (int i = 0; i <= plate.nx; ++i) tissue.is_held[static_cast<std::size_t>(plate.node(i, j, 0))] = 1;
  tissue.make_quadratic();
  tip_ = tissue.nearest_node(centre, plate_end);
  tip_rest_.assign(tissue.mesh.points.begin() + 3 * tip_, tissue.mesh.points.begin() + 3 * tip_ + 3);

  for (std::size_t t = 0; t < tissue.mesh.tets.size(); t += 10)
    corners_.push_back({tissue.mesh.tets[t], tissue.mesh.tets[t + 1], tissue.mesh.tets[t + 2], tissue.mesh.tets[t + 3]});
  rest_ = tissue.mesh.points;

  flow_ = std::make_unique<SlabFlow>(setup, tissue, std::vector<double>{});
  flow_->set_body(disc_body(setup.grid, centre, centre, radius));
  profile_ = parabola(setup.grid, 6 * spec.mean_velocity / (width * width));
}

double TurekHron::swelling() const {
  const auto volume = [&](const std::vector<double>& x) {
    double sum = 0;
    for (const auto& t : corners_) {
      const auto at = [&](int c) { return Vec3::Map(x.data() + 3 * t[static_cast<std::size_t>(c)]); };
      sum += (at(1) - at(0)).cross(at(2) - at(0)).dot(at(3) - at(0));
    }
    return sum;
  };
  return volume(flow_->x()) / volume(rest_) - 1;
}

TurekHronSample TurekHron::advance(double interval) {
  const int steps = std::max(1, static_cast<int>(std::lround(interval / spec_.dt)));
  const double depth = flow_->fluid().grid().h;
  const Vec3 momentum = flow_->tissue_momentum();
  Vec3 force = Vec3::Zero();
  for (int s = 0; s < steps; ++s) {
    const double time = static_cast<double>(++step_) * spec_.dt;
    const double share = time < rise ? 0.5 * (1 - std::cos(M_PI * time / rise)) : 1.0;
    inflow_ = profile_;
    for (double& u : inflow_) u *= share;
    flow_->set_inflow(2, 0, inflow_);
    flow_->advance(spec_.dt, 0);
    force += flow_->force_on_blood();
  }
  // Blood around plate and cylinder pushes them by what they do not push the blood inside with, plus the change of the plate's momentum.
  force = -force / steps + (flow_->tissue_momentum() - momentum) / (steps * spec_.dt);
  TurekHronSample sample;
  sample.time = static_cast<double>(step_) * spec_.dt;
  sample.ux = flow_->x()[static_cast<std::size_t>(3 * tip_ + 2)] - tip_rest_[2];
  sample.uy = flow_->x()[static_cast<std::size_t>(3 * tip_)] - tip_rest_[0];
  sample.drag = force[2] / depth;
  sample.lift = force[0] / depth;
  return sample;
}

}  // namespace mv::test
