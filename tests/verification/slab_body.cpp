// SPDX-License-Identifier: BSD-3-Clause
#include "verification/slab_body.h"

#include <algorithm>
#include <cmath>

namespace mv::test {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

// Nearer surfaces are treated as this share of a cell away.
constexpr double smallest_fraction = 0.05;
// Faces with a larger sum of weights in the plane have them all scaled down, as at the tube's wall: the viscous step does not depend on how near the surface passes. A face
// without cut links has 4. The tube's limit, 60, needs a fifth of the step and changes the drag of a cylinder by 0.004 %, its lift by 0.008 % of the drag (64 cells across the channel).
constexpr double largest_weight_sum = 12;

std::array<std::ptrdiff_t, 4> neighbours(const FluidGrid& grid) { return {-1, 1, -grid.stride_z(), grid.stride_z()}; }

Vector3d add_cut_links(const SlabBody& body, const NavierStokes& fluid, const FaceField& velocity, FaceField& force) {
  const double h = fluid.grid().h;
  const std::array<std::ptrdiff_t, 4> step = neighbours(fluid.grid());
  Vector3d sum = Vector3d::Zero();
  for (std::size_t c = 0; c < 3; ++c)
    for (const SlabBody::CutFace& cut : body.cut[c]) {
      const double* q = velocity.c[c].data() + cut.face;
      double density = 0;
      for (std::size_t d = 0; d < 4; ++d) density += fluid.viscosity() / (h * h) * cut.excess[d] * (q[step[d]] - q[0]);
      force.c[c][static_cast<std::size_t>(cut.face)] += density;
      sum[static_cast<Eigen::Index>(c)] += h * h * h * density;
    }
  return sum;
}

Vector3d momentum_inside(const SlabBody& body, const NavierStokes& fluid, const FaceField& velocity) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t c = 0; c < 3; ++c)
    for (const std::ptrdiff_t face : body.inside[c]) sum[static_cast<Eigen::Index>(c)] += velocity.c[c][static_cast<std::size_t>(face)];
  return fluid.density() * std::pow(fluid.grid().h, 3) * sum;
}

}  // namespace

SlabBody disc_body(const FluidGrid& grid, double x, double z, double radius) {
  constexpr std::array<std::array<double, 2>, 3> offset{{{0, 0.5}, {0.5, 0.5}, {0.5, 0}}};  // of a face's centre along x and z, in cells
  const std::array<Vector2d, 4> direction{Vector2d(-1, 0), Vector2d(1, 0), Vector2d(0, -1), Vector2d(0, 1)};
  const auto is_inside = [&](const Vector2d& from_centre) { return from_centre.norm() < radius; };
  SlabBody body;
  for (std::size_t c = 0; c < 3; ++c)
    for (int k = 0; k < grid.n[2]; ++k)
      for (int i = 0; i < grid.n[0]; ++i) {
        const Vector2d p(grid.lower[0] + grid.h * (i + offset[c][0]) - x, grid.lower[2] + grid.h * (k + offset[c][1]) - z);
        if (is_inside(p)) {
          for (int j = 0; j < grid.n[1]; ++j) body.inside[c].push_back(grid.index(i, j, k));
          continue;
        }
        std::array<double, 4> fraction{1, 1, 1, 1}, excess;
        bool is_cut = false;
        for (std::size_t d = 0; d < 4; ++d) {
          if (!is_inside(p + grid.h * direction[d])) continue;
          is_cut = true;
          const double along = p.dot(direction[d]);
          const double distance = -along - std::sqrt(along * along - p.squaredNorm() + radius * radius);  // |p + distance direction| = radius
          fraction[d] = std::clamp(distance / grid.h, smallest_fraction, 1.0);
        }
        if (!is_cut) continue;
        double sum = 0;
        for (std::size_t d = 0; d < 4; ++d) sum += excess[d] = 2.0 / ((fraction[d & ~std::size_t{1}] + fraction[d | 1]) * fraction[d]);
        for (double& weight : excess) weight = weight * std::min(1.0, largest_weight_sum / sum) - 1.0;
        for (int j = 0; j < grid.n[1]; ++j) body.cut[c].push_back({grid.index(i, j, k), excess});
      }
  return body;
}

Vector3d advance_around(const SlabBody& body, NavierStokes& fluid, FlowState& state, FaceField& force, double dt,
                        const std::array<std::array<double, 2>, 3>& boundary_pressure) {
  const Vector3d before = momentum_inside(body, fluid, state.velocity);
  const Vector3d links = add_cut_links(body, fluid, state.velocity, force);
  const FlowStepReport report = fluid.advance(state, force, dt, boundary_pressure);
  return report.rest_force + links - (momentum_inside(body, fluid, state.velocity) - before) / dt;
}

}  // namespace mv::test
