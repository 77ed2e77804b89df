// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Incompressible Navier-Stokes on a staggered grid:
//   rho (du/dt + div(u u)) = -grad p + mu lap u + f,   div u = 0.
// Scheme: explicit second-order Adams-Bashforth for advection (conservative, third-order upwind-biased, Leonard) and diffusion (second order),
// incremental pressure correction (Van Kan 1986) with a direct Poisson solve on the box. Forces f and boundary pressures act as given through the whole
// step: second order in time when they are those of its middle, first order otherwise. The pressure belongs to the middle of the last step.
// Rigid tube wall: faces outside carry no flow before the projection; the pressure increment leaves there only O(dt^2 dp/dt).
// Stability (von Neumann): (|u| + |v| + |w|) dt/h < 0.55 without viscosity, nu dt/h^2 < 1/12 without flow; together the shares of both add up to less than one.
// Both are far above the step the leaflets allow.

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "solver/fluid/grid.h"
#include "solver/fluid/poisson.h"
#include "solver/fluid/tube_wall.h"

namespace mv {

/// Every fluid unknown; copying it is rollback and checkpoint.
struct FlowState {
  FaceField velocity;             // m/s
  std::vector<double> pressure;   // Pa, padded layout
  FaceField rate_old;             // m/s2, advection + diffusion of the step before
  double dt_old = 0;              // s; 0 before the first step
  std::array<std::array<double, 2>, 3> boundary_pressure{};  // Pa, that of the last step, as `pressure`
};

/// Faces of a staggered grid, per component: indices in the padded layout.
using RestFaces = std::array<std::vector<std::ptrdiff_t>, 3>;

/// What one step did, for the energy budget (J) and the flow.
struct FlowStepReport {
  double viscous_loss = 0;       // J, dissipated by viscosity
  double advection_loss = 0;     // J, lost by the advection scheme (negative when it gains); transport through open sides excluded
  double pressure_work = 0;      // J, done by the pressures on the open sides
  double boundary_kinetic = 0;   // J, kinetic energy carried in through open sides
  double rest_work = 0;          // J, done on the blood by what holds the faces at rest
  Eigen::Vector3d rest_force = Eigen::Vector3d::Zero();  // N, on the blood, of the same
};

class NavierStokes {
 public:
  NavierStokes(const FluidGrid& grid, const FluidBoundary& boundary, TubeWall wall, double density, double viscosity);

  FlowState make_state() const;

  /// Normal velocities (m/s, along the axis whichever the side) that every following step has at its end on a side of kind `inflow`. One value a face, the
  /// axis that follows `axis` cyclically running fastest: n[axis+1] * n[axis+2]. Zero before the first call. Work and kinetic energy that enter there are not
  /// in FlowStepReport.
  void set_inflow(std::size_t axis, std::size_t side, std::span<const double> normal_velocity);

  /// Faces of rigid bodies at rest: they carry no flow, like those outside the tube (the pressure increment leaves there only O(dt^2 dp/dt)). Each at most once.
  void set_rest_faces(RestFaces faces) { rest_faces_ = std::move(faces); }
  const RestFaces& rest_faces() const { return rest_faces_; }

  /// Advances by dt under the force density `force` (N/m3, padded layout) and the boundary pressures (Pa), both constant over the step.
  /// No allocation.
  FlowStepReport advance(FlowState& state, const FaceField& force, double dt, const std::array<std::array<double, 2>, 3>& boundary_pressure);

  /// Makes a face field (of any unit) free of divergence as a step does: at rest outside the tube first, then less the gradient of a potential that is zero on
  /// open sides. Linear in the field; ghost layers are not filled. No allocation.
  void project(FaceField& field);

  /// The potential whose gradient project() took off last, times the field's unit and metres; valid until the next call of advance() or project().
  const std::vector<double>& last_potential() const { return increment_; }

  /// Largest |div u| h / max|u| over the cells (dimensionless).
  double relative_divergence(const FlowState& state) const;
  double kinetic_energy(const FlowState& state) const;       // J
  double peak_velocity(const FlowState& state) const;        // m/s, of the face components at cell centres
  /// Volume flow (m3/s) through the z-plane of faces k, positive along +z.
  double flow_through_z(const FlowState& state, int k) const;
  /// Largest step (s) that advection and diffusion allow together.
  double stable_step(const FlowState& state) const;

  const FluidGrid& grid() const { return grid_; }
  const TubeWall& wall() const { return wall_; }
  double density() const { return density_; }
  double viscosity() const { return viscosity_; }

  /// Fills the ghost layers of the velocity and imposes normal velocities on walls; those on inflow sides stay as they are.
  void apply_velocity_boundary(FaceField& velocity) const;

 private:
  void compute_rate(const FaceField& velocity, FaceField& rate, double& advection_power, double& viscous_power);
  /// rhs_ = scale * (sum of outgoing face values) of each cell.
  void divergence_to_rhs(const FaceField& velocity, double scale);
  void subtract_gradient(const std::vector<double>& potential, double scale, FaceField& velocity) const;
  void impose_inflow(FaceField& velocity) const;
  void fill_pressure_ghosts(std::vector<double>& p, const std::array<std::array<double, 2>, 3>& boundary_value) const;

  FluidGrid grid_;
  FluidBoundary boundary_;
  TubeWall wall_;
  double density_, viscosity_;
  PoissonSolver poisson_;
  FaceField rate_;
  std::vector<double> rhs_;        // unpadded
  std::vector<double> increment_;  // padded pressure increment
  RestFaces rest_faces_;
  std::array<std::vector<double>, 3> rest_old_, rest_removed_;  // m/s, velocities of rest_faces_ before the step and before they are stopped
  std::array<std::array<std::vector<double>, 2>, 3> inflow_;  // m/s; empty where no inflow was set
  std::vector<std::array<double, 3>> partial_;  // one a z-slab: sums in fixed order
};

}  // namespace mv
