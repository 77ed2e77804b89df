// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Hyperelastic leaflet laws at one material point. SI units (Pa, kg/m3). Formulas, conventions and sources: README.md.
//
//   W(F, f) = W_iso(I1b, I4b) + U(J) + W_control(F),     J = det F,  C = F^T F,
//   I1b = J^(-2/3) tr C,   I4b = f.C f (or J^(-2/3) f.C f),   U(J) = bulk/2 (ln J)^2.
//
// s1 eq. 12 adds beta_s log(I3) F^-T to P; that is this U with bulk = 2 beta_s (beta_s = 500 kPa is bulk = 1 MPa).
// All functions are finite for every finite F, inverted ones included: below J = volume_floor the factor J^(-2/3) continues as
// its tangent and U as its parabola, both in J; the printed law is untouched above it.

#include <array>
#include <string>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

enum class Law { m1, ogden, hgo, neo_hookean, m2, m3, isotropic_exponential };

/// Below this J the volumetric factors are continued smoothly, so that a nearly flat or inverted element is pushed back.
inline constexpr double volume_floor = 0.4;

struct Material {
  Law law = Law::m1;
  double density = 1060;   // kg/m3
  double bulk = 500e3;     // Pa, U(J) = bulk/2 (ln J)^2

  // M1 (s1 eq. 10, s4 eq. 9): c (I1b - 3) + a/(2b) (exp(b <I4b - 1>^2) - 1)
  double m1_c = 17.4e3, m1_a = 31.3e3, m1_b = 55.93;

  // HGO (s2 eq. 1, one family): c10 (I1b - 3) + k1/(2 k2) (exp(k2 <E>^2) - 1), E = kappa (I1b - 3) + (1 - 3 kappa)(I4b - 1)
  double hgo_c10 = 2272, hgo_k1 = 4000, hgo_k2 = 150, hgo_kappa = 0.25;

  // Ogden: sum_i 2 mu_i/alpha_i^2 (l1b^alpha_i + l2b^alpha_i + l3b^alpha_i - 3), ground shear modulus sum mu_i
  // s2 prints alpha = -19.4, -19.3, -25.0. Taken literally these soften at 4 % equibiaxial strain: the large mu cancel, so the
  // decimals that were not printed decide. These round to the printed ones, are stable, and follow HGO with kappa = 1/3
  // (README.md, "Ogden of s2").
  std::array<double, 3> ogden_mu{-481836.3, 484166.6, 742.8};   // Pa
  std::array<double, 3> ogden_alpha{-19.36, -19.318, -25.0};
  // Outside this range of modified principal stretch the law continues as a parabola in the stretch.
  double ogden_stretch_min = 0.7, ogden_stretch_max = 2.0;

  // neo-Hookean: mu/2 (I1b - 3)
  double neo_mu = 20e3;

  // M2 (s4 eq. 9): c0 (exp(c1 (I1b - 3)^2 + c2 (sqrt(I4b*) - 1)^4) - 1),  I4b* = max(I4b, 1)
  double m2_c0 = 7.69e3, m2_c1 = 69.42, m2_c2 = 0.0008;
  // M3 (s4 eq. 9): c0 (exp(c1 (I1b - 3)^2 + c2 (I4b* - 1)^2) - 1)
  double m3_c0 = 0.29e3, m3_c1 = 0.47, m3_c2 = 55.39;

  // Isotropic exponential (Mathur et al. 2022; Lee et al. 2014): c0/2 (I1b - 3) + c1/2 (exp(c2 (I1b - 3)^2) - 1). Ground shear modulus c0.
  // Defaults: their tricuspid valve, anterior leaflet.
  double iso_c0 = 1e3, iso_c1 = 124, iso_c2 = 4.568;

  // Exponents are followed up to this value; above it the law continues with the tangent reached there, which bounds the
  // stiffness. M1 anterior reaches 4 at a fibre stretch of 1.126 and 1.2 MPa; the largest fibre stress printed in s1 and s4 is
  // 0.44 MPa.
  double exponent_limit = 4;

  // false: fibres see their own stretch, as s1 writes it. true: the J^(-2/3) of the isochoric part as well; a shrinking element
  // then stretches its fibres in name only, and its stable step drops by seven at J = 1/2 (README.md).
  bool has_modified_fibre_invariant = false;

  // Distortion control (s0): with e over the principal nominal strains l1-1, l2-1, l3-1 (the smallest stretch carries the sign of
  // J) and the volume strain J-1:  W_control = distortion_factor bulk/2 sum <|e| - distortion_strain>^2.  Factor 0 switches it
  // off.
  double distortion_strain = 0.6;
  double distortion_factor = 4;
};

struct StressPoint {
  double energy = 0;                 // J/m3 of reference volume, control included
  Mat3 first_piola = Mat3::Zero();   // Pa, P = dW/dF
  double J = 1;
  bool is_controlled = false;   // distortion control is active
};

/// Energy density and first Piola-Kirchhoff stress. `fibre` is a unit vector in the reference configuration.
StressPoint evaluate(const Material& material, const Mat3& F, const Vec3& fibre);
double energy_density(const Material& material, const Mat3& F, const Vec3& fibre);
Mat3 first_piola(const Material& material, const Mat3& F, const Vec3& fibre);

/// Cauchy stress P F^T / J; J is not allowed to be smaller than volume_floor in the division.
Mat3 cauchy_stress(const Material& material, const Mat3& F, const Vec3& fibre);

/// Shear modulus at F = I (M2 and M3: zero, their energy starts with the fourth power of strain).
double ground_shear_modulus(const Material& material);

/// What is wrong with the parameters, one line a defect; empty when the material can be used.
std::vector<std::string> defects(const Material& material);

/// What the user should know although the material can be used: an Ogden law that softens (uniaxial, planar or equibiaxial
/// incompressible tension, stress no longer rising) at a nominal strain below distortion_strain, with the strain.
std::vector<std::string> warnings(const Material& material);

/// "m1", "ogden", "hgo", "neo_hookean", "m2", "m3", "isotropic_exponential". Throws ConfigError for another name.
Law law_from_name(const std::string& name);
std::string name_of(Law law);

}   // namespace mv
