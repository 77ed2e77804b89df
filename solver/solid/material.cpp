// SPDX-License-Identifier: BSD-3-Clause
#include "solver/solid/material.h"

#include <algorithm>
#include <cmath>

#include "geometry/core/errors.h"
#include "solver/solid/material_kernel.h"

namespace mv {

using namespace solid_kernel;

namespace {

constexpr std::array<std::pair<Law, const char*>, 7> law_names{{{Law::m1, "m1"},
                                                                {Law::ogden, "ogden"},
                                                                {Law::hgo, "hgo"},
                                                                {Law::neo_hookean, "neo_hookean"},
                                                                {Law::m2, "m2"},
                                                                {Law::m3, "m3"},
                                                                {Law::isotropic_exponential, "isotropic_exponential"}}};

Tensor<double> tensor(const Mat3& F) {
  Tensor<double> t;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) t(i, j) = F(i, j);
  return t;
}

/// Nominal stress / lateral-free incompressible tension of the Ogden law at stretch l; the free direction shrinks as l^-share.
double ogden_tension(const Material& m, double l, double share) {
  double stress = 0;
  for (int i = 0; i < 3; ++i)
    stress +=
        2 * m.ogden_mu[i] / m.ogden_alpha[i] * (std::pow(l, m.ogden_alpha[i] - 1) - std::pow(l, -share * m.ogden_alpha[i] - 1));
  return stress;
}

}   // namespace

namespace solid_kernel {

LawConstants law_constants(const Material& m) {
  LawConstants k;
  k.has_modified_fibre_invariant = m.has_modified_fibre_invariant;
  k.bulk = m.bulk;
  k.control_strain = m.distortion_strain;
  k.control_stiffness = m.distortion_factor * m.bulk;
  k.exponent_limit = m.exponent_limit;
  switch (m.law) {
    case Law::m1: k.c = m.m1_c, k.a = m.m1_a, k.b = m.m1_b, k.k1 = 0, k.k4 = 1; break;
    case Law::hgo: k.c = m.hgo_c10, k.a = m.hgo_k1, k.b = m.hgo_k2, k.k1 = m.hgo_kappa, k.k4 = 1 - 3 * m.hgo_kappa; break;
    case Law::neo_hookean: k.c = m.neo_mu / 2; break;
    // c1/2 (exp(c2 i^2) - 1) = a/(2b) (exp(b i^2) - 1) with b = c2, a = c1 c2, i = I1b - 3 >= 0.
    case Law::isotropic_exponential: k.c = m.iso_c0 / 2, k.a = m.iso_c1 * m.iso_c2, k.b = m.iso_c2, k.k1 = 1, k.k4 = 0; break;
    case Law::m2: k.form = Form::m2, k.c0 = m.m2_c0, k.c1 = m.m2_c1, k.c2 = m.m2_c2; break;
    case Law::m3: k.form = Form::m3, k.c0 = m.m3_c0, k.c1 = m.m3_c1, k.c2 = m.m3_c2; break;
    case Law::ogden:
      k.form = Form::ogden;
      for (int i = 0; i < 3; ++i) {
        k.twice_mu_over_alpha[i] = 2 * m.ogden_mu[i] / m.ogden_alpha[i];
        k.alpha[i] = m.ogden_alpha[i];
      }
      k.stretch_min = m.ogden_stretch_min;
      k.stretch_max = m.ogden_stretch_max;
      break;
  }
  k.e_limit = std::sqrt(m.exponent_limit / k.b);
  return k;
}

}   // namespace solid_kernel

StressPoint evaluate(const Material& material, const Mat3& F, const Vec3& fibre) {
  const LawConstants k = law_constants(material);
  const Deformation<double> d = deformation(tensor(F));
  const double f[3] = {fibre.x(), fibre.y(), fibre.z()};
  Response<double> r = law_response<double>(k, d, f);
  StressPoint point;
  point.J = d.J;
  if (k.control_stiffness > 0 && may_be_distorted(k, d)) r.W += add_distortion_control(k, d, r.P, point.is_controlled);
  point.energy = r.W;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) point.first_piola(i, j) = r.P(i, j);
  return point;
}

double energy_density(const Material& material, const Mat3& F, const Vec3& fibre) { return evaluate(material, F, fibre).energy; }

Mat3 first_piola(const Material& material, const Mat3& F, const Vec3& fibre) { return evaluate(material, F, fibre).first_piola; }

Mat3 cauchy_stress(const Material& material, const Mat3& F, const Vec3& fibre) {
  const StressPoint point = evaluate(material, F, fibre);
  return point.first_piola * F.transpose() / std::max(point.J, volume_floor);
}

double ground_shear_modulus(const Material& material) {
  switch (material.law) {
    case Law::m1: return 2 * material.m1_c;
    case Law::hgo: return 2 * material.hgo_c10;
    case Law::neo_hookean: return material.neo_mu;
    case Law::ogden: return material.ogden_mu[0] + material.ogden_mu[1] + material.ogden_mu[2];
    case Law::isotropic_exponential: return material.iso_c0;
    case Law::m2:
    case Law::m3: return 0;
  }
  return 0;
}

std::vector<std::string> defects(const Material& m) {
  std::vector<std::string> found;
  auto require = [&](bool is_good, const std::string& what) {
    if (!is_good) found.push_back(what);
  };
  require(std::isfinite(m.density) && m.density > 0, "density must be positive");
  require(std::isfinite(m.bulk) && m.bulk > 0, "bulk must be positive");
  require(m.exponent_limit > 0 && m.exponent_limit <= 100, "exponent_limit must be in (0, 100]");
  require(m.distortion_strain > 0 && m.distortion_strain < 1, "distortion_strain must be in (0, 1)");
  require(m.distortion_factor >= 0 && std::isfinite(m.distortion_factor), "distortion_factor must not be negative");
  switch (m.law) {
    case Law::m1:
      require(m.m1_c > 0, "m1_c must be positive");
      require(m.m1_a >= 0, "m1_a must not be negative");
      require(m.m1_b > 0, "m1_b must be positive");
      break;
    case Law::hgo:
      require(m.hgo_c10 > 0, "hgo_c10 must be positive");
      require(m.hgo_k1 >= 0, "hgo_k1 must not be negative");
      require(m.hgo_k2 > 0, "hgo_k2 must be positive");
      require(m.hgo_kappa >= 0 && m.hgo_kappa <= 1.0 / 3 + 1e-12, "hgo_kappa must be in [0, 1/3]");
      break;
    case Law::neo_hookean: require(m.neo_mu > 0, "neo_mu must be positive"); break;
    case Law::isotropic_exponential:
      require(m.iso_c0 > 0, "iso_c0 must be positive");
      require(m.iso_c1 >= 0, "iso_c1 must not be negative");
      require(m.iso_c2 > 0, "iso_c2 must be positive");
      break;
    case Law::m2:
      require(m.m2_c0 > 0 && m.m2_c1 >= 0 && m.m2_c2 >= 0, "m2_c0 must be positive, m2_c1 and m2_c2 not negative");
      break;
    case Law::m3:
      require(m.m3_c0 > 0 && m.m3_c1 >= 0 && m.m3_c2 >= 0, "m3_c0 must be positive, m3_c1 and m3_c2 not negative");
      break;
    case Law::ogden:
      require(std::none_of(m.ogden_alpha.begin(), m.ogden_alpha.end(), [](double a) { return a == 0 || !std::isfinite(a); }),
              "ogden_alpha must not be zero");
      require(ground_shear_modulus(m) > 0, "sum of ogden_mu, the ground shear modulus, must be positive");
      require(m.ogden_stretch_min > 0 && m.ogden_stretch_min < 1 && m.ogden_stretch_max > 1,
              "ogden_stretch_min must be in (0, 1) and ogden_stretch_max above 1");
      break;
  }
  return found;
}

std::vector<std::string> warnings(const Material& m) {
  std::vector<std::string> found;
  if (m.law != Law::ogden || !defects(m).empty()) return found;
  constexpr std::array<std::pair<double, const char*>, 3> modes{{{0.5, "uniaxial"}, {1.0, "planar"}, {2.0, "equibiaxial"}}};
  constexpr double step = 1e-3;
  for (const auto& [share, name] : modes)
    for (double strain = 0; strain < m.distortion_strain; strain += step)
      if (ogden_tension(m, 1 + strain + step, share) <= ogden_tension(m, 1 + strain, share)) {
        found.push_back("Ogden law softens in " + std::string(name) + " tension at a strain of " + std::to_string(strain));
        break;
      }
  return found;
}

Law law_from_name(const std::string& name) {
  for (const auto& [law, text] : law_names)
    if (name == text) return law;
  throw ConfigError("unknown leaflet law \"" + name + "\"; known: m1, ogden, hgo, neo_hookean, m2, m3, isotropic_exponential");
}

std::string name_of(Law law) {
  for (const auto& [l, text] : law_names)
    if (l == law) return text;
  return "?";
}

}   // namespace mv
