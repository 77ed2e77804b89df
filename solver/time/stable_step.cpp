// SPDX-License-Identifier: BSD-3-Clause
#include "solver/time/stable_step.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace mv {

namespace {
constexpr double settled = 0.02;   // change of the squared frequency in one product at which the mode counts as found
constexpr int products_max = 15, products_from_nothing = 25;
constexpr double probe_share = 0.5;
constexpr double independent = 1e-8;   // least pivot of the basis' Gram matrix (unit diagonal) at which its vectors count as independent

using Vector = Eigen::VectorXd;

/// A direction with its products, so that combinations need no further ones.
struct Direction {
  Vector x, stiff, moved;   // x, K x, B K x
  std::array<double, 3> shares{};   // of tissue, chordae and contact in x.K.x

  void scale(double factor) {
    x *= factor, stiff *= factor, moved *= factor;
    for (double& share : shares) share *= factor * factor;
  }
  /// Adds `factor` times `other`; of the shares' cross terms nothing is kept: they only name the stiffest part.
  void add(double factor, const Direction& other) {
    x += factor * other.x, stiff += factor * other.stiff, moved += factor * other.moved;
    for (std::size_t part = 0; part < shares.size(); ++part) shares[part] += factor * factor * other.shares[part];
  }
};

/// Largest eigenvalue of B K on the span of `basis` and its coefficients: Rayleigh-Ritz in the energy's inner product, in which B K is self-adjoint. Empty
/// coefficients when the energy is not positive there (buckling) or the basis is dependent.
struct RitzPair {
  double value = 0;
  Vector coefficients;
};
RitzPair largest_on(std::span<const Direction* const> basis) {
  const auto size = static_cast<Eigen::Index>(basis.size());
  Eigen::MatrixXd energy(size, size), response(size, size);
  for (Eigen::Index i = 0; i < size; ++i)
    for (Eigen::Index j = i; j < size; ++j) {
      const Direction &a = *basis[static_cast<std::size_t>(i)], &b = *basis[static_cast<std::size_t>(j)];
      energy(i, j) = energy(j, i) = a.x.dot(b.stiff);
      response(i, j) = response(j, i) = a.stiff.dot(b.moved);
    }
  RitzPair pair;
  if (!(energy.diagonal().minCoeff() > 0)) return pair;
  const Vector unit = energy.diagonal().cwiseSqrt().cwiseInverse();
  energy = unit.asDiagonal() * energy * unit.asDiagonal();
  response = unit.asDiagonal() * response * unit.asDiagonal();
  const Eigen::LLT<Eigen::MatrixXd> factors(energy);
  if (factors.info() != Eigen::Success || !(factors.matrixLLT().diagonal().array().square().minCoeff() > independent)) return pair;
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(response, energy);
  if (solver.info() != Eigen::Success) return pair;
  pair.value = solver.eigenvalues()(size - 1);
  pair.coefficients = unit.cwiseProduct(solver.eigenvectors().col(size - 1));
  return pair;
}
}  // namespace

StableStep::StableStep(const FluidGrid* grid) {
  if (grid) scratch_ = FaceField(*grid);
}

const std::vector<double>& StableStep::noise(std::size_t size) {
  if (noise_.size() != size) {
    noise_.resize(size);
    for (std::size_t a = 0; a < size; ++a) noise_[a] = std::sin(12.9898 * static_cast<double>(a) + 1.0);
  }
  return noise_;
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
  const std::vector<double>& any = noise(probe.size());
  for (std::size_t node = 0; node < std::min(probe.size() / 3, state.relax_steps.size()); ++node) {
    const double step = state.relax_steps[node];
    if (!(step > 0)) continue;
    const double ratio = (shortest / step) * (shortest / step), weight = ratio * ratio;
    for (std::size_t a = 3 * node; a < 3 * node + 3; ++a) {
      probe[a] = weight * any[a];
      squared += probe[a] * probe[a];
    }
  }
  if (!(squared > 0)) return;
  const double scale = probe_share * norm / std::sqrt(squared);
  for (std::size_t a = 0; a < probe.size(); ++a) state.mode_shape[a] += scale * probe[a];
}

void StableStep::update(State& state, Structure& structure, const Coupling* coupling, NavierStokes* fluid, int iterations) {
  const std::size_t unknowns = state.x.size();
  const auto size = static_cast<Eigen::Index>(unknowns);
  const auto& is_fixed = structure.is_fixed();
  if (state.mode_shape.size() != unknowns) {
    // Any start that is not orthogonal to the stiffest mode will do.
    state.mode_shape = noise(unknowns);
    for (std::size_t i = 0; i < unknowns; ++i)
      if (is_fixed[i / 3]) state.mode_shape[i] = 0.0;
    iterations = std::max(iterations, products_from_nothing);
  }
  structure.begin_products(state.x);
  auto multiply = [&](Direction& d) {
    const double norm = d.x.norm();
    if (norm > 0) d.x /= norm;
    d.stiff.resize(size), d.moved.resize(size);
    structure.stiffness_times(std::span<const double>(d.x.data(), unknowns), std::span<double>(d.stiff.data(), unknowns), d.shares);
    if (coupling) {
      coupling->accelerate({state.x, state.v, is_fixed}, std::span<const double>(d.stiff.data(), unknowns), *fluid, scratch_, std::span<double>(d.moved.data(), unknowns));
    } else {
      for (std::size_t i = 0; i < unknowns; ++i) d.moved[static_cast<Eigen::Index>(i)] = is_fixed[i / 3] ? 0.0 : d.stiff[static_cast<Eigen::Index>(i)] / structure.masses()[i / 3];
    }
    return norm > 0;
  };

  Direction mode, last;   // the mode and what it was last moved along (locally optimal conjugate gradients, Knyazev 2001)
  mode.x = Eigen::Map<const Vector>(state.mode_shape.data(), size);
  if (!multiply(mode)) return;
  bool has_last = false;
  double value = mode.moved.norm();
  for (int products = 1; products < std::max(iterations, products_max); ++products) {
    const double energy = mode.x.dot(mode.stiff);
    const double quotient = energy > 0 ? mode.stiff.dot(mode.moved) / energy : value;
    Direction residual;
    residual.x = mode.moved - quotient * mode.x;
    if (!multiply(residual)) break;   // the mode is exact
    const std::array<const Direction*, 3> basis{&mode, &residual, &last};
    RitzPair pair = has_last ? largest_on(basis) : RitzPair{};
    if (pair.coefficients.size() == 0) pair = largest_on(std::span(basis).first(2)), has_last = false;
    const double before = value;
    if (pair.coefficients.size() == 0) {
      // The energy is no inner product here: a step of the plain power iteration, whose product is at hand.
      value = mode.moved.norm();
      mode.x = mode.moved;
      if (!multiply(mode)) return;
      ++products;
    } else {
      value = pair.value;
      if (has_last) last.scale(pair.coefficients[2]), last.add(pair.coefficients[1], residual);
      else last = std::move(residual), last.scale(pair.coefficients[1]);
      mode.scale(pair.coefficients[0]);
      mode.add(1.0, last);
      const double norm = mode.x.norm(), last_norm = last.x.norm();
      if (!(norm > 0)) return;
      mode.scale(1 / norm);
      has_last = last_norm > 0;
      if (has_last) last.scale(1 / last_norm);
    }
    // Another part of the leaflets may have become the stiffest: the mode then grows from product to product.
    if (products + 1 >= iterations && std::abs(value - before) < settled * value) break;
  }
  state.frequency = std::sqrt(value);
  Eigen::Map<Vector>(state.mode_shape.data(), size) = mode.x;
  const std::size_t largest = static_cast<std::size_t>(std::max_element(mode.shares.begin(), mode.shares.end()) - mode.shares.begin());
  static const char* const names[] = {"tissue", "chordae", "contact"};
  state.stiffest_part = names[largest];
}

}  // namespace mv
