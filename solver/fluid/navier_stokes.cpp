// SPDX-License-Identifier: BSD-3-Clause
#include "solver/fluid/navier_stokes.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "geometry/core/parallel.h"
#include "solver/fluid/navier_stokes_kernel.h"

namespace mv {
namespace {

constexpr int g = FluidGrid::ghosts;

std::array<std::array<PoissonSide, 2>, 3> poisson_sides(const FluidBoundary& boundary) {
  std::array<std::array<PoissonSide, 2>, 3> sides{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t s = 0; s < 2; ++s) {
      const BoundaryKind kind = boundary.side[axis][s];
      sides[axis][s] = kind == BoundaryKind::open       ? PoissonSide::dirichlet_at_face
                       : kind == BoundaryKind::periodic ? PoissonSide::periodic
                                                 : PoissonSide::neumann;
    }
  return sides;
}

// Faces of component c along an axis: one more than cells on its own axis, the last one a copy when periodic.
int faces(const FluidGrid& grid, const FluidBoundary& boundary, std::size_t component, std::size_t axis) {
  const int n = grid.n[axis];
  return component == axis && boundary.side[axis][0] != BoundaryKind::periodic ? n + 1 : n;
}

}  // namespace

namespace {

/// A row of faces along x: velocity component q, the three components as they advect it, the wall's stencil, and the result (m/s2).
struct RateRow {
  const double* q;
  const double* a[3];
  const double* open;
  const double* weight[4];
  double* out;
};
struct RateStrides {
  std::ptrdiff_t own, y, z;  // of the component's own axis, of y and of z
};

/// Advection and diffusion of the row, and what they do to its kinetic energy, per mass of a cell. A function of its own with plain arguments: inside the parallel
/// loop's closure the compiler gathers value by value.
[[gnu::noinline]] void rate_row(const RateRow& row, std::ptrdiff_t count, const RateStrides& s, double inverse_h, double nu, double& advection_sum, double& viscous_sum) {
  const double* __restrict q = row.q;
  const double *__restrict a0 = row.a[0], *__restrict a1 = row.a[1], *__restrict a2 = row.a[2], *__restrict open = row.open;
  const double *__restrict west = row.weight[0], *__restrict east = row.weight[1], *__restrict south = row.weight[2], *__restrict north = row.weight[3];
  double* __restrict out = row.out;
  const std::ptrdiff_t shift = -s.own, sy = s.y, sz = s.z;
  double advection_power = 0, viscous_power = 0;
#pragma omp simd reduction(+ : advection_power, viscous_power)
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const double advection =
        -inverse_h * (advective_outflow(q, a0, i, shift, 1) + advective_outflow(q, a1, i, shift, sy) + advective_outflow(q, a2, i, shift, sz));
    const double centre = q[i];
    const double diffusion = nu * (west[i] * (q[i - 1] - centre) + east[i] * (q[i + 1] - centre) + south[i] * (q[i - sy] - centre) +
                                   north[i] * (q[i + sy] - centre) + (q[i - sz] - centre) + (q[i + sz] - centre));
    out[i] = open[i] * (advection + diffusion);
    advection_power += open[i] * centre * advection;
    viscous_power += open[i] * centre * diffusion;
  }
  advection_sum += advection_power;
  viscous_sum += viscous_power;
}

}  // namespace

NavierStokes::NavierStokes(const FluidGrid& grid, const FluidBoundary& boundary, TubeWall wall, double density, double viscosity)
    : grid_(grid),
      boundary_(boundary),
      wall_(std::move(wall)),
      density_(density),
      viscosity_(viscosity),
      poisson_(grid.n, grid.h, poisson_sides(boundary)),
      rate_(grid),
      rhs_(grid.cells()),
      increment_(grid.padded_size(), 0.0),
      partial_(static_cast<std::size_t>(grid.n[2] + 1)) {}

FlowState NavierStokes::make_state() const {
  FlowState state;
  state.velocity = FaceField(grid_);
  state.pressure.assign(grid_.padded_size(), 0.0);
  state.rate_old = FaceField(grid_);
  return state;
}

void NavierStokes::set_inflow(std::size_t axis, std::size_t side, std::span<const double> normal_velocity) {
  assert(boundary_.side[axis][side] == BoundaryKind::inflow);
  assert(normal_velocity.size() == static_cast<std::size_t>(grid_.n[(axis + 1) % 3]) * static_cast<std::size_t>(grid_.n[(axis + 2) % 3]));
  inflow_[axis][side].assign(normal_velocity.begin(), normal_velocity.end());
}

void NavierStokes::impose_inflow(FaceField& velocity) const {
  const std::array<std::ptrdiff_t, 3> stride{1, grid_.stride_y(), grid_.stride_z()};
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t side = 0; side < 2; ++side) {
      if (inflow_[axis][side].empty()) continue;
      const std::size_t a1 = (axis + 1) % 3, a2 = (axis + 2) % 3;
      const double* given = inflow_[axis][side].data();
      double* faces_of_side = velocity.c[axis].data() + grid_.index(0, 0, 0) + (side == 0 ? 0 : grid_.n[axis]) * stride[axis];
      for (int q2 = 0; q2 < grid_.n[a2]; ++q2)
        for (int q1 = 0; q1 < grid_.n[a1]; ++q1) faces_of_side[q1 * stride[a1] + q2 * stride[a2]] = *given++;
    }
}

void NavierStokes::apply_velocity_boundary(FaceField& velocity) const {
  const std::array<std::ptrdiff_t, 3> stride{1, grid_.stride_y(), grid_.stride_z()};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t a1 = axis == 0 ? 1 : 0, a2 = axis == 2 ? 1 : 2;  // a1 is the nearer in memory
    const int m1 = grid_.padded(static_cast<int>(a1)), m2 = grid_.padded(static_cast<int>(a2));
    const int n = grid_.n[axis];
    const std::ptrdiff_t s = stride[axis];
    // Lines along an axis do not meet.
    parallel_for(
        m2,
        [&](std::ptrdiff_t q2) {
          for (std::size_t component = 0; component < 3; ++component) {
            double* const data = velocity.c[component].data();
            const bool is_normal = component == axis;
            for (int q1 = 0; q1 < m1; ++q1) {
              double* line = data + q1 * stride[a1] + q2 * stride[a2] + g * s;  // entry 0 is the first cell or face
              const double* normal = velocity.c[axis].data() + q1 * stride[a1] + q2 * stride[a2] + g * s;
              if (boundary_.side[axis][0] == BoundaryKind::periodic) {
                line[-s] = line[(n - 1) * s];
                line[-2 * s] = line[(n - 2 >= 0 ? n - 2 : n - 1) * s];
                line[n * s] = line[0];
                line[(n + 1) * s] = line[(n > 1 ? 1 : 0) * s];
                line[(n + 2) * s] = line[(n > 2 ? 2 : n == 2 ? 0 : 0) * s];
                continue;
              }
              for (std::size_t side = 0; side < 2; ++side) {
                const BoundaryKind kind = boundary_.side[axis][side];
                // Walk outwards from the boundary: `in` points to the interior, `out` beyond it.
                const std::ptrdiff_t out = side == 0 ? -s : s;
                if (is_normal) {
                  double* face = line + (side == 0 ? 0 : n) * s;
                  if (kind == BoundaryKind::open) {
                    face[out] = face[0];
                    face[2 * out] = face[0];
                  } else {
                    const double v = kind == BoundaryKind::wall     ? boundary_.wall_velocity[axis][side][static_cast<Eigen::Index>(axis)]
                                     : kind == BoundaryKind::inflow ? face[0]
                                                                    : 0.0;
                    face[0] = v;
                    face[out] = 2 * v - face[-out];
                    if (2 <= n) face[2 * out] = 2 * v - face[-2 * out];
                  }
                } else {
                  double* cell = line + (side == 0 ? 0 : n - 1) * s;
                  if (kind == BoundaryKind::open) {
                    const double entering = side == 0 ? normal[0] : -normal[n * s];
                    const double value = entering > 0 ? 0.0 : cell[0];
                    cell[out] = value;
                    cell[2 * out] = value;
                  } else if (kind == BoundaryKind::symmetry) {
                    cell[out] = cell[0];
                    cell[2 * out] = n > 1 ? cell[-out] : cell[0];
                  } else {
                    const double v = kind == BoundaryKind::wall ? boundary_.wall_velocity[axis][side][static_cast<Eigen::Index>(component)] : 0.0;
                    cell[out] = 2 * v - cell[0];
                    cell[2 * out] = 2 * v - (n > 1 ? cell[-out] : cell[0]);
                  }
                }
              }
            }
          }
        },
        2);
  }
}

void NavierStokes::fill_pressure_ghosts(std::vector<double>& p, const std::array<std::array<double, 2>, 3>& boundary_value) const {
  const std::array<std::ptrdiff_t, 3> stride{1, grid_.stride_y(), grid_.stride_z()};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t a1 = axis == 0 ? 1 : 0, a2 = axis == 2 ? 1 : 2;  // a1 is the nearer in memory
    const int n = grid_.n[axis];
    const std::ptrdiff_t s = stride[axis];
    for (int q2 = 0; q2 < grid_.n[a2]; ++q2) {
      for (int q1 = 0; q1 < grid_.n[a1]; ++q1) {
        double* line = p.data() + (q1 + g) * stride[a1] + (q2 + g) * stride[a2] + g * s;
        if (boundary_.side[axis][0] == BoundaryKind::periodic) {
          line[-s] = line[(n - 1) * s];
          line[n * s] = line[0];
          continue;
        }
        line[-s] = boundary_.side[axis][0] == BoundaryKind::open ? 2 * boundary_value[axis][0] - line[0] : line[0];
        line[n * s] = boundary_.side[axis][1] == BoundaryKind::open ? 2 * boundary_value[axis][1] - line[(n - 1) * s] : line[(n - 1) * s];
      }
    }
  }
}

void NavierStokes::compute_rate(const FaceField& velocity, FaceField& rate, double& advection_power, double& viscous_power) {
  const std::ptrdiff_t sy = grid_.stride_y(), sz = grid_.stride_z();
  const std::array<std::ptrdiff_t, 3> stride{1, sy, sz};
  const double inverse_h = 1.0 / grid_.h;
  const double nu = viscosity_ / density_ * inverse_h * inverse_h;
  for (auto& p : partial_) p = {0, 0, 0};
  for (std::size_t component = 0; component < 3; ++component) {
    const int mx = faces(grid_, boundary_, component, 0);
    const int my = faces(grid_, boundary_, component, 1);
    const int mz = faces(grid_, boundary_, component, 2);
    const std::ptrdiff_t sc = stride[component];
    const WallStencil& stencil = wall_.stencil[component];
    parallel_for(
        mz,
        [&](std::ptrdiff_t k) {
          double advection_sum = 0, viscous_sum = 0;
          for (int j = 0; j < my; ++j) {
            const std::ptrdiff_t row = grid_.index(0, j, static_cast<int>(k));
            const double* q = velocity.c[component].data() + row;
            const double* a0 = velocity.c[0].data() + row;
            const double* a1 = velocity.c[1].data() + row;
            const double* a2 = velocity.c[2].data() + row;
            double* out = rate.c[component].data() + row;
            const std::ptrdiff_t plane = g + static_cast<std::ptrdiff_t>(grid_.padded(0)) * (j + g);
            const double* open = stencil.open.data() + plane;
            const double* west = stencil.weight[0].data() + plane;
            const double* east = stencil.weight[1].data() + plane;
            const double* south = stencil.weight[2].data() + plane;
            const double* north = stencil.weight[3].data() + plane;
            rate_row({q, {a0, a1, a2}, open, {west, east, south, north}, out}, mx, {sc, sy, sz}, inverse_h, nu, advection_sum, viscous_sum);
          }
          partial_[static_cast<std::size_t>(k)][0] += advection_sum;
          partial_[static_cast<std::size_t>(k)][1] += viscous_sum;
        },
        2);
  }
  advection_power = viscous_power = 0;
  const double mass = density_ * grid_.h * grid_.h * grid_.h;
  for (const auto& p : partial_) {
    advection_power += mass * p[0];
    viscous_power += mass * p[1];
  }
}

void NavierStokes::divergence_to_rhs(const FaceField& velocity, double scale) {
  const std::ptrdiff_t sy = grid_.stride_y(), sz = grid_.stride_z();
  const int nx = grid_.n[0], ny = grid_.n[1];
  parallel_for(
      grid_.n[2],
      [&](std::ptrdiff_t k) {
        for (int j = 0; j < ny; ++j) {
          const std::ptrdiff_t row = grid_.index(0, j, static_cast<int>(k));
          const double* u = velocity.c[0].data() + row;
          const double* v = velocity.c[1].data() + row;
          const double* w = velocity.c[2].data() + row;
          double* r = rhs_.data() + static_cast<std::ptrdiff_t>(nx) * (j + static_cast<std::ptrdiff_t>(ny) * k);
#pragma omp simd
          for (int i = 0; i < nx; ++i) r[i] = scale * (u[i + 1] - u[i] + v[i + sy] - v[i] + w[i + sz] - w[i]);
        }
      },
      2);
}

void NavierStokes::subtract_gradient(const std::vector<double>& potential, double scale, FaceField& velocity) const {
  const std::array<std::ptrdiff_t, 3> stride{1, grid_.stride_y(), grid_.stride_z()};
  for (std::size_t component = 0; component < 3; ++component) {
    const int mx = faces(grid_, boundary_, component, 0), my = faces(grid_, boundary_, component, 1), mz = faces(grid_, boundary_, component, 2);
    const std::ptrdiff_t sc = stride[component];
    parallel_for(
        mz,
        [&](std::ptrdiff_t k) {
          for (int j = 0; j < my; ++j) {
            const std::ptrdiff_t row = grid_.index(0, j, static_cast<int>(k));
            double* u = velocity.c[component].data() + row;
            const double* phi = potential.data() + row;
#pragma omp simd
            for (int i = 0; i < mx; ++i) u[i] -= scale * (phi[i] - phi[i - sc]);
          }
        },
        2);
  }
}

void NavierStokes::project(FaceField& field) {
  for (std::size_t component = 0; component < 3; ++component) {
    const std::vector<double>& open = wall_.stencil[component].open;
    const std::ptrdiff_t plane = grid_.stride_z();
    parallel_for(
        grid_.padded(2),
        [&](std::ptrdiff_t k) {
          double* u = field.c[component].data() + k * plane;
#pragma omp simd
          for (std::ptrdiff_t q = 0; q < plane; ++q) u[q] *= open[static_cast<std::size_t>(q)];
        },
        2);
  }
  for (std::size_t c = 0; c < 3; ++c)
    for (const std::ptrdiff_t face : rest_faces_[c]) field.c[c][static_cast<std::size_t>(face)] = 0;
  // A field to be made free of divergence meets resting walls and moves freely through open sides.
  const std::array<std::ptrdiff_t, 3> stride{1, grid_.stride_y(), grid_.stride_z()};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t a1 = (axis + 1) % 3, a2 = (axis + 2) % 3;
    for (int q2 = 0; q2 < grid_.n[a2]; ++q2)
      for (int q1 = 0; q1 < grid_.n[a1]; ++q1) {
        double* line = field.c[axis].data() + grid_.index(0, 0, 0) + q1 * stride[a1] + q2 * stride[a2];
        if (boundary_.side[axis][0] == BoundaryKind::periodic) {
          line[grid_.n[axis] * stride[axis]] = line[0];
          continue;
        }
        for (std::size_t side = 0; side < 2; ++side)
          if (boundary_.side[axis][side] != BoundaryKind::open) line[(side == 0 ? 0 : grid_.n[axis]) * stride[axis]] = 0;
      }
  }
  divergence_to_rhs(field, 1.0 / grid_.h);
  poisson_.solve(rhs_);
  const int nx = grid_.n[0], ny = grid_.n[1];
  parallel_for(
      grid_.n[2],
      [&](std::ptrdiff_t k) {
        for (int j = 0; j < ny; ++j)
          std::copy_n(rhs_.data() + static_cast<std::ptrdiff_t>(nx) * (j + static_cast<std::ptrdiff_t>(ny) * k), nx,
                      increment_.data() + grid_.index(0, j, static_cast<int>(k)));
      },
      2);
  fill_pressure_ghosts(increment_, {});
  subtract_gradient(increment_, 1.0 / grid_.h, field);
}

FlowStepReport NavierStokes::advance(FlowState& state, const FaceField& force, double dt,
                                      const std::array<std::array<double, 2>, 3>& boundary_pressure) {
  FlowStepReport report;
  const std::ptrdiff_t sy = grid_.stride_y(), sz = grid_.stride_z();
  const std::array<std::ptrdiff_t, 3> stride{1, sy, sz};
  const double h = grid_.h, inverse_h = 1.0 / h;
  const double per_density = 1.0 / density_;

  impose_inflow(state.velocity);
  apply_velocity_boundary(state.velocity);
  double advection_power = 0, viscous_power = 0;
  compute_rate(state.velocity, rate_, advection_power, viscous_power);

  // Open sides: flow before the step (for work and transport at the mean velocity of the step).
  std::array<std::array<double, 2>, 3> flow_before{};
  double kinetic_in = 0;
  auto open_side_flow = [&](std::size_t axis, std::size_t side, bool with_kinetic) {
    const std::size_t a1 = (axis + 1) % 3, a2 = (axis + 2) % 3;
    double sum = 0;
    for (int q2 = 0; q2 < grid_.n[a2]; ++q2)
      for (int q1 = 0; q1 < grid_.n[a1]; ++q1) {
        const std::ptrdiff_t p = (side == 0 ? 0 : grid_.n[axis]) * stride[axis] + (q1)*stride[a1] + (q2)*stride[a2] + grid_.index(0, 0, 0);
        const double un = state.velocity.c[axis][static_cast<std::size_t>(p)] * (side == 0 ? 1 : -1);
        sum += un;
        if (with_kinetic) {
          const std::ptrdiff_t in = side == 0 ? p : p - stride[axis];
          double squared = un * un;
          for (std::size_t t : {a1, a2}) {
            const double mean = 0.5 * (state.velocity.c[t][static_cast<std::size_t>(in)] + state.velocity.c[t][static_cast<std::size_t>(in + stride[t])]);
            squared += mean * mean;
          }
          kinetic_in += 0.5 * density_ * un * squared * h * h;
        }
      }
    return sum * h * h;
  };
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t side = 0; side < 2; ++side)
      if (boundary_.side[axis][side] == BoundaryKind::open) flow_before[axis][side] = open_side_flow(axis, side, true);

  for (std::size_t c = 0; c < 3; ++c) {
    rest_old_[c].resize(rest_faces_[c].size());
    rest_removed_[c].resize(rest_faces_[c].size());
    for (std::size_t q = 0; q < rest_faces_[c].size(); ++q) rest_old_[c][q] = state.velocity.c[c][static_cast<std::size_t>(rest_faces_[c][q])];
  }

  // Predictor: u* = u + dt (3/2 N - 1/2 N_old) + dt/rho (f - grad p), at rest outside the tube.
  fill_pressure_ghosts(state.pressure, state.boundary_pressure);
  const double ratio = state.dt_old > 0 ? 0.5 * dt / state.dt_old : 0.0;
  const double now_weight = dt * (1.0 + ratio), old_weight = dt * ratio;
  for (std::size_t component = 0; component < 3; ++component) {
    const int mx = faces(grid_, boundary_, component, 0), my = faces(grid_, boundary_, component, 1), mz = faces(grid_, boundary_, component, 2);
    const std::ptrdiff_t sc = stride[component];
    const double* open_plane = wall_.stencil[component].open.data();
    parallel_for(
        mz,
        [&](std::ptrdiff_t k) {
          for (int j = 0; j < my; ++j) {
            const std::ptrdiff_t row = grid_.index(0, j, static_cast<int>(k));
            double* u = state.velocity.c[component].data() + row;
            const double* n0 = rate_.c[component].data() + row;
            const double* n1 = state.rate_old.c[component].data() + row;
            const double* f = force.c[component].data() + row;
            const double* p = state.pressure.data() + row;
            const double* open = open_plane + g + static_cast<std::ptrdiff_t>(grid_.padded(0)) * (j + g);
#pragma omp simd
            for (int i = 0; i < mx; ++i)
              u[i] = open[i] * (u[i] + now_weight * n0[i] - old_weight * n1[i] + dt * per_density * (f[i] - inverse_h * (p[i] - p[i - sc])));
          }
        },
        2);
  }
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t q = 0; q < rest_faces_[c].size(); ++q) {
      double& u = state.velocity.c[c][static_cast<std::size_t>(rest_faces_[c][q])];
      rest_removed_[c][q] = u;
      u = 0;
    }
  impose_inflow(state.velocity);
  apply_velocity_boundary(state.velocity);
  std::swap(state.rate_old, rate_);
  state.dt_old = dt;

  // Projection.
  std::array<std::array<double, 2>, 3> boundary_increment{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t side = 0; side < 2; ++side)
      if (boundary_.side[axis][side] == BoundaryKind::open) boundary_increment[axis][side] = boundary_pressure[axis][side] - state.boundary_pressure[axis][side];
  const int nx = grid_.n[0], ny = grid_.n[1], nz = grid_.n[2];
  divergence_to_rhs(state.velocity, density_ / dt * inverse_h);
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t side = 0; side < 2; ++side) {
      if (boundary_increment[axis][side] == 0) continue;
      const std::size_t a1 = (axis + 1) % 3, a2 = (axis + 2) % 3;
      const std::array<std::ptrdiff_t, 3> flat{1, nx, static_cast<std::ptrdiff_t>(nx) * ny};
      const std::ptrdiff_t start = side == 0 ? 0 : (grid_.n[axis] - 1) * flat[axis];
      for (int q2 = 0; q2 < grid_.n[a2]; ++q2)
        for (int q1 = 0; q1 < grid_.n[a1]; ++q1)
          rhs_[static_cast<std::size_t>(start + q1 * flat[a1] + q2 * flat[a2])] -= poisson_.dirichlet_weight() * boundary_increment[axis][side];
    }
  poisson_.solve(rhs_);
  parallel_for(
      nz,
      [&](std::ptrdiff_t k) {
        for (int j = 0; j < ny; ++j) {
          const std::ptrdiff_t row = grid_.index(0, j, static_cast<int>(k));
          const double* r = rhs_.data() + static_cast<std::ptrdiff_t>(nx) * (j + static_cast<std::ptrdiff_t>(ny) * k);
          double* phi = increment_.data() + row;
          double* p = state.pressure.data() + row;
#pragma omp simd
          for (int i = 0; i < nx; ++i) {
            phi[i] = r[i];
            p[i] += r[i];
          }
        }
      },
      2);
  fill_pressure_ghosts(increment_, boundary_increment);
  subtract_gradient(increment_, dt * per_density * inverse_h, state.velocity);
  apply_velocity_boundary(state.velocity);

  const double mass = density_ * h * h * h;
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t q = 0; q < rest_faces_[c].size(); ++q) {
      const double impulse = -mass * rest_removed_[c][q];
      report.rest_work += 0.5 * impulse * (rest_old_[c][q] + state.velocity.c[c][static_cast<std::size_t>(rest_faces_[c][q])]);
      report.rest_force[static_cast<Eigen::Index>(c)] += impulse / dt;
    }

  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t side = 0; side < 2; ++side)
      if (boundary_.side[axis][side] == BoundaryKind::open) {
        const double flow = 0.5 * (flow_before[axis][side] + open_side_flow(axis, side, false));
        report.pressure_work += dt * flow * boundary_pressure[axis][side];
      }
  state.boundary_pressure = boundary_pressure;
  report.boundary_kinetic = dt * kinetic_in;
  report.advection_loss = -dt * advection_power + report.boundary_kinetic;
  report.viscous_loss = -dt * viscous_power;
  return report;
}

double NavierStokes::relative_divergence(const FlowState& state) const {
  const std::ptrdiff_t sy = grid_.stride_y(), sz = grid_.stride_z();
  double worst = 0, fastest = 1e-300;
  for (int k = 0; k < grid_.n[2]; ++k)
    for (int j = 0; j < grid_.n[1]; ++j)
      for (int i = 0; i < grid_.n[0]; ++i) {
        const std::ptrdiff_t p = grid_.index(i, j, k);
        const double* u = state.velocity.c[0].data() + p;
        const double* v = state.velocity.c[1].data() + p;
        const double* w = state.velocity.c[2].data() + p;
        worst = std::max(worst, std::abs(u[1] - u[0] + v[sy] - v[0] + w[sz] - w[0]));
        fastest = std::max({fastest, std::abs(u[0]), std::abs(v[0]), std::abs(w[0])});
      }
  return worst / fastest;
}

double NavierStokes::kinetic_energy(const FlowState& state) const {
  double sum = 0;
  for (std::size_t component = 0; component < 3; ++component) {
    const int mx = faces(grid_, boundary_, component, 0), my = faces(grid_, boundary_, component, 1), mz = faces(grid_, boundary_, component, 2);
    const std::array<int, 3> last{mx - 1, my - 1, mz - 1};
    const bool has_end_faces = last[component] == grid_.n[component];
    for (int k = 0; k < mz; ++k)
      for (int j = 0; j < my; ++j)
        for (int i = 0; i < mx; ++i) {
          const std::array<int, 3> at{i, j, k};
          const bool is_end = has_end_faces && (at[component] == 0 || at[component] == last[component]);
          const double u = state.velocity.c[component][static_cast<std::size_t>(grid_.index(i, j, k))];
          sum += (is_end ? 0.5 : 1.0) * u * u;
        }
  }
  return 0.5 * density_ * sum * grid_.h * grid_.h * grid_.h;
}

double NavierStokes::peak_velocity(const FlowState& state) const {
  const std::ptrdiff_t sy = grid_.stride_y(), sz = grid_.stride_z();
  double peak = 0;
  for (int k = 0; k < grid_.n[2]; ++k)
    for (int j = 0; j < grid_.n[1]; ++j)
      for (int i = 0; i < grid_.n[0]; ++i) {
        const std::size_t p = static_cast<std::size_t>(grid_.index(i, j, k));
        const double u = 0.5 * (state.velocity.c[0][p] + state.velocity.c[0][p + 1]);
        const double v = 0.5 * (state.velocity.c[1][p] + state.velocity.c[1][p + static_cast<std::size_t>(sy)]);
        const double w = 0.5 * (state.velocity.c[2][p] + state.velocity.c[2][p + static_cast<std::size_t>(sz)]);
        peak = std::max(peak, u * u + v * v + w * w);
      }
  return std::sqrt(peak);
}

double NavierStokes::flow_through_z(const FlowState& state, int k) const {
  double sum = 0;
  for (int j = 0; j < grid_.n[1]; ++j)
    for (int i = 0; i < grid_.n[0]; ++i) sum += state.velocity.c[2][static_cast<std::size_t>(grid_.index(i, j, k))];
  return sum * grid_.h * grid_.h;
}

double NavierStokes::stable_step(const FlowState& state) const {
  constexpr double courant = 0.3;
  const double h = grid_.h;
  const double diffusive = viscosity_ > 0 ? 0.4 * h * h * density_ / (wall_.stiffest_weight * viscosity_) : 1e300;
  const double peak = peak_velocity(state);
  const double advective = peak > 0 ? courant * h / peak : 1e300;
  // Both damp the shortest waves, and Adams-Bashforth overshoots beyond a damping of one a step: the rates add.
  return 1.0 / (1.0 / diffusive + 1.0 / advective);
}

}  // namespace mv
