// SPDX-License-Identifier: BSD-3-Clause
#include "solver/chordae/chorda_law.h"

#include <cmath>

namespace mv {
namespace {

/// exp(a) + 2 exp(-a/2) - 3 without the cancellation at small a.
double energy_factor(double a) {
  constexpr double small = 1e-3;
  if (std::abs(a) < small) return a * a * (0.75 + a * (0.125 + a * 3.0 / 64.0));
  return std::expm1(a) + 2 * std::expm1(-0.5 * a);
}

ChordaResponse ogden(const ChordaLaw& law, double l) {
  ChordaResponse r;
  const double log_l = std::log(l);
  for (std::size_t i = 0; i < 3; ++i) {
    const double mu = law.mu[i], alpha = law.alpha[i];
    if (mu == 0) continue;
    const double a = alpha * log_l;
    r.energy += 2 * mu / (alpha * alpha) * energy_factor(a);
    r.stress += 2 * mu / alpha * (std::expm1(a) - std::expm1(-0.5 * a)) / l;
    r.tangent += 2 * mu / alpha * ((alpha - 1) * std::exp(a) + (0.5 * alpha + 1) * std::exp(-0.5 * a)) / (l * l);
  }
  return r;
}

}  // namespace

ChordaResponse chorda_response(const ChordaLaw& law, double stretch) {
  if (!law.is_ogden) {
    const double strain = stretch - 1;
    return {0.5 * law.youngs_modulus * strain * strain, law.youngs_modulus * strain, law.youngs_modulus};
  }
  if (stretch <= law.limit_stretch) return ogden(law, stretch);
  ChordaResponse r = ogden(law, law.limit_stretch);
  const double above = stretch - law.limit_stretch;
  r.energy += (r.stress + 0.5 * r.tangent * above) * above;
  r.stress += r.tangent * above;
  return r;
}

std::vector<std::string> defects(const ChordaLaw& law) {
  std::vector<std::string> found;
  if (!law.is_ogden) {
    if (!(law.youngs_modulus > 0) || !std::isfinite(law.youngs_modulus)) found.emplace_back("the modulus must be positive");
    return found;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if (!std::isfinite(law.mu[i]) || !std::isfinite(law.alpha[i])) found.emplace_back("mu and alpha must be finite");
    if (law.mu[i] != 0 && law.alpha[i] == 0) found.emplace_back("alpha must not be zero where mu is not");
  }
  if (!found.empty()) return found;
  if (!(ogden(law, 1).tangent > 0)) found.emplace_back("the stiffness at rest, 3 sum mu, must be positive");
  constexpr double largest = 1.2, step = 1e-3;
  ChordaLaw limited = law;
  limit_stiffening(limited);
  for (double l = 1; l < largest; l += step)
    if (!(chorda_response(limited, l + step).stress > chorda_response(limited, l).stress)) {
      found.push_back("the tension falls at a stretch of " + std::to_string(l));
      break;
    }
  return found;
}

void limit_stiffening(ChordaLaw& law) {
  if (!law.is_ogden) return;
  constexpr double largest = 2.0;
  const double most = stiffening_limit * ogden(law, 1).tangent;
  double low = 1, high = largest;
  law.limit_stretch = largest;
  if (!(ogden(law, largest).tangent > most)) return;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (ogden(law, middle).tangent > most ? high : low) = middle;
  }
  law.limit_stretch = low;
}

}  // namespace mv
