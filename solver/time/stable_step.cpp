// SPDX-License-Identifier: BSD-3-Clause
#include "solver/time/stable_step.h"

#include <cmath>
#include <numeric>

namespace mv {

namespace {
constexpr double settled = 0.04;   // change of the squared frequency in one product at which the mode counts as found
constexpr int products_max = 15;
constexpr double probe_share = 0.5;
}  // namespace

StableStep::StableStep(std::size_t unknowns, const FluidGrid* grid) : stiff_(unknowns), moved_(unknowns) {
  if (grid) scratch_ = FaceField(*grid);
}

void StableStep::look_at_stiff_nodes(State& state) {
  if (state.relax_steps.empty() || state.mode_shape.empty()) return;
  double shortest = 1e300;
  for (double step : state.relax_steps)
    if (step > 0) shortest = std::min(shortest, step);
  const double norm = std::sqrt(std::inner_product(state.mode_shape.begin(), state.mode_shape.end(), state.mode_shape.begin(), 0.0));
  double squared = 0;
  std::vector<double>& probe = probe_;
  probe.assign(state.mode_shape.size(), 0.0);
  for (std::size_t a = 0; a < std::min(probe.size(), 3 * state.relax_steps.size()); ++a) {
    const double step = state.relax_steps[a / 3];
    if (step > 0) probe[a] = std::pow(shortest / step, 4) * std::sin(12.9898 * static_cast<double>(a) + 1.0);
    squared += probe[a] * probe[a];
  }
  if (!(squared > 0)) return;
  const double scale = probe_share * norm / std::sqrt(squared);
  for (std::size_t a = 0; a < probe.size(); ++a) state.mode_shape[a] += scale * probe[a];
}

void StableStep::update(State& state, Structure& structure, const Coupling* coupling, NavierStokes* fluid, int iterations) {
  const std::size_t unknowns = state.x.size();
  const auto& is_fixed = structure.is_fixed();
  if (state.mode_shape.size() != unknowns) {
    // Any start that is not orthogonal to the stiffest mode will do; this one is the same on every machine.
    state.mode_shape.resize(unknowns);
    for (std::size_t i = 0; i < unknowns; ++i) state.mode_shape[i] = is_fixed[i / 3] ? 0.0 : std::sin(12.9898 * static_cast<double>(i) + 1.0);
    iterations = std::max(iterations, 25);
  }
  std::array<double, 3> shares{};
  structure.begin_products(state.x);
  double before = 0;
  for (int iteration = 0; iteration < std::max(iterations, products_max); ++iteration) {
    const double norm = std::sqrt(std::inner_product(state.mode_shape.begin(), state.mode_shape.end(), state.mode_shape.begin(), 0.0));
    if (!(norm > 0)) return;
    for (double& v : state.mode_shape) v /= norm;
    structure.stiffness_times(state.mode_shape, stiff_, shares);
    if (coupling) {
      const CoupledNodes nodes{state.x, state.v, is_fixed};
      coupling->accelerate(nodes, stiff_, *fluid, scratch_, moved_);
    } else {
      for (std::size_t i = 0; i < unknowns; ++i) moved_[i] = is_fixed[i / 3] ? 0.0 : stiff_[i] / structure.masses()[i / 3];
    }
    const double growth = std::sqrt(std::inner_product(moved_.begin(), moved_.end(), moved_.begin(), 0.0));
    state.frequency = std::sqrt(growth);
    std::swap(state.mode_shape, moved_);
    // Another part of the leaflets may have become the stiffest: the mode then grows from product to product.
    if (iteration + 1 >= iterations && std::abs(growth - before) < settled * growth) break;
    before = growth;
  }
  const std::size_t largest = static_cast<std::size_t>(std::max_element(shares.begin(), shares.end()) - shares.begin());
  static const char* const names[] = {"tissue", "chordae", "contact"};
  state.stiffest_part = names[largest];
}

}  // namespace mv
