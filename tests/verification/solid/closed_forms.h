// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Homogeneous stress of every law from its printed energy, written in principal stretches and apart from the solver. Pa.

#include <array>
#include <cmath>

#include "verification/solid/box_mesh.h"

namespace mv::test {

/// dW_iso/dI1b and dW_iso/dI4b of the laws in invariants (solver/solid/README.md prints the energies); Ogden has none.
struct InvariantSlopes {
  double on_I1, on_I4;
};
inline InvariantSlopes invariant_slopes(const Material& m, double I1, double I4) {
  const double e4 = std::fmax(I4 - 1, 0.0);
  switch (m.law) {
    case Law::neo_hookean: return {m.neo_mu / 2, 0};
    case Law::m1: return {m.m1_c, m.m1_a * e4 * std::exp(m.m1_b * e4 * e4)};
    case Law::hgo: {
      const double E = std::fmax(m.hgo_kappa * (I1 - 3) + (1 - 3 * m.hgo_kappa) * (I4 - 1), 0.0);
      const double slope = m.hgo_k1 * E * std::exp(m.hgo_k2 * E * E);
      return {m.hgo_c10 + m.hgo_kappa * slope, (1 - 3 * m.hgo_kappa) * slope};
    }
    case Law::m2: {
      const double stretch = std::sqrt(std::fmax(I4, 1.0)), e = stretch - 1;
      const double scale = m.m2_c0 * std::exp(m.m2_c1 * (I1 - 3) * (I1 - 3) + m.m2_c2 * e * e * e * e);
      return {2 * m.m2_c1 * (I1 - 3) * scale, 4 * m.m2_c2 * e * e * e * scale / (2 * stretch)};
    }
    case Law::m3: {
      const double scale = m.m3_c0 * std::exp(m.m3_c1 * (I1 - 3) * (I1 - 3) + m.m3_c2 * e4 * e4);
      return {2 * m.m3_c1 * (I1 - 3) * scale, 2 * m.m3_c2 * e4 * scale};
    }
    case Law::isotropic_exponential: return {m.iso_c0 / 2 + m.iso_c1 * m.iso_c2 * (I1 - 3) * std::exp(m.iso_c2 * (I1 - 3) * (I1 - 3)), 0};
    case Law::ogden: break;
  }
  return {0, 0};
}

/// Isochoric nominal stresses dW_iso/dl_i (volumetric term left out), fibre along principal axis `fibre_axis`.
inline Vec3 isochoric_nominal(const Material& m, const Vec3& l, int fibre_axis) {
  const double J = l.prod();
  Vec3 P = Vec3::Zero();
  if (m.law == Law::ogden) {
    for (std::size_t p = 0; p < 3; ++p) {
      const Vec3 power = (l.array() * std::pow(J, -1.0 / 3)).pow(m.ogden_alpha[p]);
      P += 2 * m.ogden_mu[p] / m.ogden_alpha[p] * ((power.array() - power.mean()) / l.array()).matrix();
    }
    return P;
  }
  const double factor = std::pow(J, -2.0 / 3), fibre_factor = m.has_modified_fibre_invariant ? factor : 1.0;
  const double I1 = l.squaredNorm(), fibre = l[fibre_axis];
  const InvariantSlopes w = invariant_slopes(m, factor * I1, fibre_factor * fibre * fibre);
  P = 2 * w.on_I1 * factor * (l.array() - I1 / 3 / l.array()).matrix();
  P[fibre_axis] += 2 * w.on_I4 * fibre_factor * fibre;
  if (m.has_modified_fibre_invariant) P -= (2.0 / 3 * w.on_I4 * factor * fibre * fibre / l.array()).matrix();
  return P;
}

/// With U = bulk/2 (ln J)^2.
inline Vec3 nominal_stress(const Material& m, const Vec3& l, int fibre_axis) {
  return isochoric_nominal(m, l, fibre_axis) + (m.bulk * std::log(l.prod()) / l.array()).matrix();
}

struct HomogeneousState {
  Vec3 stretches, nominal;
  double incompressible = 0;  // Pa, nominal stress along axis 0 for bulk -> infinity
};

/// Stretch `l` along the first `driven` axes (1: uniaxial, 2: equibiaxial), no stress along the others.
inline HomogeneousState driven_state(const Material& m, double l, int driven, int fibre_axis) {
  Vec3 s(l, driven == 2 ? l : 1 / std::sqrt(l), driven == 2 ? 1 / (l * l) : 1 / std::sqrt(l));
  // Newton on the free logarithmic stretches, differences for the tangent.
  const auto solve_free = [&](const auto& residual, int unknowns, Vec3& at, int first) {
    for (int round = 0; round < 60; ++round) {
      const Vec3 r = residual(at);
      Eigen::MatrixXd K(unknowns, unknowns);
      for (int j = 0; j < unknowns; ++j) {
        constexpr double h = 1e-6;
        Vec3 a = at, b = at;
        a[first + j] *= std::exp(h), b[first + j] *= std::exp(-h);
        K.col(j) = (residual(a) - residual(b)).segment(first, unknowns) / (2 * h);
      }
      const Eigen::VectorXd d = K.fullPivLu().solve(r.segment(first, unknowns));
      for (int j = 0; j < unknowns; ++j) at[first + j] *= std::exp(-std::fmax(-0.05, std::fmin(0.05, d[j])));
      if (d.norm() < 1e-14) break;
    }
  };
  solve_free([&](const Vec3& at) { return nominal_stress(m, at, fibre_axis); }, 3 - driven, s, driven);
  HomogeneousState state{s, nominal_stress(m, s, fibre_axis), 0};
  // Incompressible: pressure from the free direction 2; in uniaxial tension direction 1 follows from equal true stress.
  Vec3 t(l, driven == 2 ? l : 1 / std::sqrt(l), driven == 2 ? 1 / (l * l) : 1 / std::sqrt(l));
  const auto kirchhoff = [&](const Vec3& at) { return Vec3(isochoric_nominal(m, at, fibre_axis).cwiseProduct(at)); };
  if (driven == 1)
    solve_free(
        [&](const Vec3& at) {
          const Vec3 full(at[0], at[1], 1 / (at[0] * at[1]));
          const Vec3 tau = kirchhoff(full);
          return Vec3(0, tau[1] - tau[2], 0);
        },
        1, t, 1);
  t[2] = 1 / (t[0] * t[1]);
  const Vec3 tau = kirchhoff(t);
  state.incompressible = (tau[0] - tau[2]) / t[0];
  return state;
}

/// Nominal stress in simple shear F = I + shear e_x (x) e_z with the fibre along z at rest; J = 1, so that the volumetric term is silent.
inline Mat3 simple_shear_nominal(const Material& m, double shear) {
  Mat3 F = Mat3::Identity();
  F(0, 2) = shear;
  const Mat3 b = F * F.transpose();
  Mat3 sigma = Mat3::Zero();
  if (m.law == Law::ogden) {
    // Principal stretches l, 1/l, 1; the axis of l is turned from x towards z by half of atan(2 / shear).
    const double l = shear / 2 + std::sqrt(1 + shear * shear / 4), angle = 0.5 * std::atan2(2.0, shear);
    const Vec3 stretches(l, 1 / l, 1);
    const std::array<Vec3, 3> axes{Vec3(std::cos(angle), 0, std::sin(angle)), Vec3(-std::sin(angle), 0, std::cos(angle)), Vec3::UnitY()};
    const Vec3 tau = isochoric_nominal(m, stretches, 0).cwiseProduct(stretches);
    for (std::size_t i = 0; i < 3; ++i) sigma += tau[static_cast<Eigen::Index>(i)] * axes[i] * axes[i].transpose();
  } else {
    const Vec3 fibre = F * Vec3::UnitZ();
    const InvariantSlopes w = invariant_slopes(m, b.trace(), fibre.squaredNorm());
    const auto deviator = [](const Mat3& s) { return Mat3(s - s.trace() / 3 * Mat3::Identity()); };
    const Mat3 a = fibre * fibre.transpose();
    sigma = 2 * w.on_I1 * deviator(b) + 2 * w.on_I4 * (m.has_modified_fibre_invariant ? deviator(a) : a);
  }
  return sigma * F.inverse().transpose();
}

}  // namespace mv::test
