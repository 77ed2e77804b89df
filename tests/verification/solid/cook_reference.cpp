// SPDX-License-Identifier: BSD-3-Clause
#include "verification/solid/cook_reference.h"

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>
#include <array>
#include <cmath>
#include <vector>

namespace mv::test {
namespace {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Mat9 = Eigen::Matrix<double, 9, 9>;

struct Response {
  Mat3 P;
  Mat9 A;  // dP_ij/dF_kl at (3 i + j, 3 k + l)
};

Response response(double mu, double kappa, VolumetricEnergy energy, const Mat3& F) {
  const double J = F.determinant(), m = mu * std::pow(J, -2.0 / 3), I1 = F.squaredNorm();
  const bool is_published = energy == VolumetricEnergy::published;
  const double JdU = is_published ? 0.5 * kappa * (J * J - 1) : kappa * std::log(J);
  const double JJddU = is_published ? 0.5 * kappa * (J * J + 1) : kappa * (1 - std::log(J));
  const Mat3 G = F.inverse().transpose();
  Response r;
  r.P = m * (F - I1 / 3 * G) + JdU * G;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l) {
          const double dG = -G(i, l) * G(k, j), same = i == k && j == l ? 1 : 0;
          r.A(3 * i + j, 3 * k + l) = m * (same - 2.0 / 3 * (F(i, j) * G(k, l) + G(i, j) * F(k, l)) + 2.0 / 9 * I1 * G(i, j) * G(k, l) - I1 / 3 * dG) +
                                      (JJddU + JdU) * G(i, j) * G(k, l) + JdU * dG;
        }
  return r;
}

/// Lagrange polynomials of degree 0, 1 or 2 on [0, 1] and their slopes.
struct Basis {
  std::array<double, 3> N{1, 0, 0}, dN{0, 0, 0};
};
Basis lagrange(int degree, double s) {
  if (degree == 0) return {};
  if (degree == 1) return {{1 - s, s, 0}, {-1, 1, 0}};
  return {{(1 - s) * (1 - 2 * s), 4 * s * (1 - s), s * (2 * s - 1)}, {4 * s - 3, 4 - 8 * s, 4 * s - 1}};
}

struct Gauss {
  std::vector<double> x, w;
};
Gauss gauss(int degree) {
  if (degree == 0) return {{0.5}, {1.0}};
  const double a = degree == 1 ? 0.5 / std::sqrt(3.0) : 0.5 * std::sqrt(0.6);
  if (degree == 1) return {{0.5 - a, 0.5 + a}, {0.5, 0.5}};
  return {{0.5 - a, 0.5, 0.5 + a}, {5.0 / 18, 8.0 / 18, 5.0 / 18}};
}

/// The assembled problem. Held faces: one layer of nodes, unknowns in the plane only.
class Slab {
 public:
  Slab(const CookSpec& spec, VolumetricEnergy energy, Faces faces, int n, int degree)
      : spec_(spec), energy_(energy), n_(n), degree_(degree), deep_(faces == Faces::free ? degree : 0), components_(faces == Faces::free ? 3 : 2),
        line_(degree * n + 1), nodes_(line_ * line_ * (deep_ + 1)), u_(Eigen::VectorXd::Zero(3 * nodes_)), X_(static_cast<std::size_t>(nodes_)) {
    for (int k = 0; k <= deep_; ++k)
      for (int j = 0; j < line_; ++j)
        for (int i = 0; i < line_; ++i) {
          const double s = double(i) / (line_ - 1), t = double(j) / (line_ - 1), z = deep_ ? double(k) / deep_ - 0.5 : 0.5;
          X_[static_cast<std::size_t>(id(i, j, k))] = Vec3(48e-3 * s, 1e-3 * (44 * s + t * (44 - 28 * s)), spec.depth * z);
        }
    load_ = Eigen::VectorXd::Zero(unknowns());
    const Gauss g = gauss(degree), gz = gauss(deep_);
    for (int e = 0; e < n; ++e)
      for (std::size_t q = 0; q < g.x.size(); ++q)
        for (std::size_t qz = 0; qz < gz.x.size(); ++qz)
          for (int a = 0; a <= degree; ++a)
            for (int c = 0; c <= deep_; ++c)
              load_[unknown(id(line_ - 1, degree * e + a, c), 1)] += spec.force / n * g.w[q] * gz.w[qz] * lagrange(degree, g.x[q]).N[static_cast<std::size_t>(a)] *
                                                                     lagrange(deep_, gz.x[qz]).N[static_cast<std::size_t>(c)];
  }

  void solve() {
    constexpr int load_steps = 5, newton_max = 20;
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver;
    bool is_analysed = false;
    for (int step = 1; step <= load_steps; ++step)
      for (int round = 0; round < newton_max; ++round) {
        Eigen::VectorXd r = (double(step) / load_steps) * load_;
        entries_.clear();
        for (int e = 0; e < n_ * n_; ++e) add_element(e % n_, e / n_, r);
        if (r.lpNorm<Eigen::Infinity>() < 1e-8 * load_.lpNorm<Eigen::Infinity>()) break;
        Eigen::SparseMatrix<double> K(unknowns(), unknowns());
        K.setFromTriplets(entries_.begin(), entries_.end());
        if (!is_analysed) solver.analyzePattern(K);
        is_analysed = true;
        solver.factorize(K);
        const Eigen::VectorXd du = solver.solve(r);
        for (int node = 0; node < nodes_; ++node)
          for (int a = 0; a < components_; ++a)
            if (unknown(node, a) >= 0) u_[3 * node + a] += du[unknown(node, a)];
      }
  }

  CookTip tip() const { return {u_[3 * id(line_ - 1, line_ - 1, deep_) + 1], u_[3 * id(line_ - 1, (line_ - 1) / 2, deep_) + 1]}; }

 private:
  int id(int i, int j, int k) const { return i + line_ * (j + line_ * k); }
  int unknowns() const { return components_ * (nodes_ - nodes_ / line_); }
  int unknown(int node, int a) const { return node % line_ == 0 ? -1 : components_ * (node - node / line_ - 1) + a; }  // clamped at x = 0

  void add_element(int ex, int ey, Eigen::VectorXd& r) {
    const int per = degree_ + 1, count = per * per * (deep_ + 1), size = components_ * count;
    const Gauss g = gauss(degree_), gz = gauss(deep_);
    std::vector<int> at(static_cast<std::size_t>(count));
    for (int a = 0; a < count; ++a)
      at[static_cast<std::size_t>(a)] = id(degree_ * ex + a % per, degree_ * ey + a / per % per, a / (per * per));
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(size, size), slope(3, count), V(9, size);
    Eigen::VectorXd f = Eigen::VectorXd::Zero(size);
    for (std::size_t q = 0; q < g.x.size() * g.x.size() * gz.x.size(); ++q) {
      const std::size_t line = g.x.size(), qx = q % line, qy = q / line % line, qz = q / (line * line);
      const Basis x = lagrange(degree_, g.x[qx]), y = lagrange(degree_, g.x[qy]), z = lagrange(deep_, gz.x[qz]);
      Mat3 jacobian = Mat3::Zero();
      for (int a = 0; a < count; ++a) {
        const std::size_t i = static_cast<std::size_t>(a % per), j = static_cast<std::size_t>(a / per % per), k = static_cast<std::size_t>(a / (per * per));
        slope.col(a) = Vec3(x.dN[i] * y.N[j] * z.N[k], x.N[i] * y.dN[j] * z.N[k], x.N[i] * y.N[j] * z.dN[k]);
        jacobian += X_[static_cast<std::size_t>(at[static_cast<std::size_t>(a)])] * slope.col(a).transpose();
      }
      if (deep_ == 0) jacobian(2, 2) = spec_.depth;
      slope = jacobian.transpose().inverse() * slope;
      Mat3 F = Mat3::Identity();
      for (int a = 0; a < count; ++a) F += u_.segment<3>(3 * at[static_cast<std::size_t>(a)]) * slope.col(a).transpose();
      const Response m = response(spec_.shear, spec_.bulk(), energy_, F);
      const double w = jacobian.determinant() * g.w[qx] * g.w[qy] * gz.w[qz];
      for (int b = 0; b < count; ++b)
        for (int k = 0; k < components_; ++k) V.col(components_ * b + k) = w * m.A.middleCols<3>(3 * k) * slope.col(b);
      for (int a = 0; a < count; ++a)
        for (int i = 0; i < components_; ++i) {
          f[components_ * a + i] += w * m.P.row(i).dot(slope.col(a));
          K.row(components_ * a + i) += slope.col(a).transpose() * V.middleRows<3>(3 * i);
        }
    }
    for (int a = 0; a < size; ++a) {
      const int row = unknown(at[static_cast<std::size_t>(a / components_)], a % components_);
      if (row < 0) continue;
      r[row] -= f[a];
      for (int b = 0; b < size; ++b) {
        const int column = unknown(at[static_cast<std::size_t>(b / components_)], b % components_);
        if (column >= 0) entries_.emplace_back(row, column, K(a, b));
      }
    }
  }

  CookSpec spec_;
  VolumetricEnergy energy_;
  int n_, degree_, deep_, components_, line_, nodes_;
  Eigen::VectorXd u_, load_;
  std::vector<Vec3> X_;
  std::vector<Eigen::Triplet<double>> entries_;
};

}  // namespace

CookTip cook_tip_of_hexahedra(const CookSpec& spec, VolumetricEnergy energy, Faces faces, int n, int degree) {
  Slab slab(spec, energy, faces, n, degree);
  slab.solve();
  return slab.tip();
}

}  // namespace mv::test
