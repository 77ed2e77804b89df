// SPDX-License-Identifier: BSD-3-Clause
#include "solver/coupling/coupling.h"

#include "geometry/core/parallel.h"

namespace mv {

int Coupling::bind(const CoupledNodes& nodes) {
  active_.clear();
  const int count = static_cast<int>(nodes.is_fixed.size());
  for (int i = 0; i < count; ++i)
    if (!nodes.is_fixed[static_cast<std::size_t>(i)] && !nodes.is_released[static_cast<std::size_t>(i)]) active_.push_back(i);
  return transfer_.bind(nodes.x, active_);
}

void Coupling::move(const CoupledNodes& nodes, const FaceField& velocity, std::span<const double> forces, double dt) {
  transfer_.interpolate(velocity, nodes.v);
  parallel_for(static_cast<std::ptrdiff_t>(nodes.is_fixed.size()), [&](std::ptrdiff_t i) {
    const std::size_t node = static_cast<std::size_t>(i);
    for (std::size_t a = 3 * node; a < 3 * node + 3; ++a) {
      if (nodes.is_fixed[node]) nodes.v[a] = 0;
      else if (nodes.is_released[node]) nodes.v[a] += dt * forces[a] / masses_[node];
      nodes.x[a] += dt * nodes.v[a];
    }
  });
}

void Coupling::accelerate(const CoupledNodes& nodes, std::span<const double> forces, FaceField& scratch, std::span<double> out) const {
  scratch.set_zero();
  transfer_.spread(forces, scratch);
  transfer_.interpolate(scratch, out);
  for (std::size_t i = 0; i < nodes.is_fixed.size(); ++i)
    for (std::size_t a = 3 * i; a < 3 * i + 3; ++a)
      out[a] = nodes.is_fixed[i] ? 0.0 : nodes.is_released[i] ? forces[a] / masses_[i] : out[a] / density_;
}

}  // namespace mv
