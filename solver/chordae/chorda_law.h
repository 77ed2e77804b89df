// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Tension of a chorda over its stretch l = L / L0 >= 1, per undeformed area. SI.
//
//   linear   P = E (l - 1)
//   Ogden    W = sum 2 mu_i/alpha_i^2 (l^alpha_i + 2 l^(-alpha_i/2) - 3)      (Abaqus' form, incompressible, free sides)
//            P = sum 2 mu_i/alpha_i (l^(alpha_i - 1) - l^(-alpha_i/2 - 1))
// Beyond the stretch at which its tangent is `stiffening_limit` times that at rest an Ogden chorda goes on with that tangent, which bounds the
// stiffness and so the step. With the exponents near 100 of measured chordae this is a strain of 2.9 % and some 19 MPa, about what tears them.

#include <array>
#include <string>
#include <vector>

namespace mv {

struct ChordaLaw {
  bool is_ogden = false;
  double youngs_modulus = 20e6;        // Pa, linear
  std::array<double, 3> mu{}, alpha{}; // Pa, Ogden; terms with mu = 0 are left out
  double limit_stretch = 1e300;        // Ogden: set by limit_stiffening()
};

struct ChordaResponse {
  double energy = 0;   // J/m3
  double stress = 0;   // Pa, nominal
  double tangent = 0;  // Pa, dP/dl
};

/// For stretch >= 1.
ChordaResponse chorda_response(const ChordaLaw& law, double stretch);

/// What is wrong with the law, one line a defect: a tangent at rest that is not positive, a tension that falls before a stretch of 1.2, values that are
/// not finite.
std::vector<std::string> defects(const ChordaLaw& law);

inline constexpr double stiffening_limit = 10;
/// Sets limit_stretch; a law that does not stiffen so much below a stretch of 2 stays as it is up to there.
void limit_stiffening(ChordaLaw& law);

}  // namespace mv
