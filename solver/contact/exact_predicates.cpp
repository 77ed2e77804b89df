// SPDX-License-Identifier: BSD-3-Clause
// Compiled without floating-point contraction: the error-free transformations below rely on each operation being rounded once.
#include "solver/contact/exact_predicates.h"

#include <array>
#include <cmath>
#include <limits>

namespace mv {
namespace {

/// A number as an unevaluated sum of non-overlapping doubles of increasing magnitude.
template <int Capacity>
class Expansion {
 public:
  Expansion() = default;

  /// Exact difference a - b.
  static Expansion difference(double a, double b) {
    Expansion e;
    const double x = a - b;
    const double b_virtual = a - x;
    const double a_virtual = x + b_virtual;
    e.append((a - a_virtual) + (b_virtual - b));
    e.append(x);
    return e;
  }

  /// Adds a double exactly (Shewchuk's grow-expansion with zero elimination).
  void add(double b) {
    double q = b;
    int kept = 0;
    for (int i = 0; i < size_; ++i) {
      const double sum = q + terms_[i];
      const double virtual_part = sum - q;
      const double error = (q - (sum - virtual_part)) + (terms_[i] - virtual_part);
      q = sum;
      if (error != 0) terms_[kept++] = error;
    }
    size_ = kept;
    append(q);
  }

  /// Adds sign * p * q exactly.
  template <int P, int Q>
  void add_product(const Expansion<P>& p, const Expansion<Q>& q, double sign) {
    for (int i = 0; i < p.size(); ++i) {
      for (int j = 0; j < q.size(); ++j) {
        const double product = p[i] * q[j];
        add(sign * std::fma(p[i], q[j], -product));
        add(sign * product);
      }
    }
  }

  int size() const { return size_; }
  double operator[](int i) const { return terms_[i]; }
  int sign() const { return size_ == 0 ? 0 : (terms_[size_ - 1] > 0 ? 1 : -1); }

 private:
  void append(double value) {
    if (value != 0) terms_[size_++] = value;
  }
  std::array<double, Capacity> terms_;
  int size_ = 0;
};

using Difference = Expansion<2>;
using Minor = Expansion<18>;         // 4 + 4 products of two terms each, and one slot for the carry
using Determinant = Expansion<220>;  // 3 * 2 * 18 products of two terms each

constexpr double unit_roundoff = std::numeric_limits<double>::epsilon() / 2;
// Shewchuk's static bounds for the determinants evaluated as below (ccwerrboundA, o3derrboundA).
constexpr double bound_2d = (3.0 + 16.0 * unit_roundoff) * unit_roundoff;
constexpr double bound_3d = (7.0 + 56.0 * unit_roundoff) * unit_roundoff;

int orientation_3d_exact(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, const Eigen::Vector3d& d) {
  std::array<Difference, 3> ad, bd, cd;
  for (int k = 0; k < 3; ++k) {
    ad[k] = Difference::difference(a[k], d[k]);
    bd[k] = Difference::difference(b[k], d[k]);
    cd[k] = Difference::difference(c[k], d[k]);
  }
  const auto minor = [](const std::array<Difference, 3>& p, const std::array<Difference, 3>& q) {
    Minor m;
    m.add_product(p[0], q[1], 1.0);
    m.add_product(p[1], q[0], -1.0);
    return m;
  };
  Determinant det;
  det.add_product(minor(bd, cd), ad[2], 1.0);
  det.add_product(minor(cd, ad), bd[2], 1.0);
  det.add_product(minor(ad, bd), cd[2], 1.0);
  return det.sign();
}

int sign_of(double value) { return value > 0 ? 1 : (value < 0 ? -1 : 0); }

}  // namespace

int orientation_3d(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, const Eigen::Vector3d& d) {
  const double adx = a[0] - d[0], bdx = b[0] - d[0], cdx = c[0] - d[0];
  const double ady = a[1] - d[1], bdy = b[1] - d[1], cdy = c[1] - d[1];
  const double adz = a[2] - d[2], bdz = b[2] - d[2], cdz = c[2] - d[2];
  const double bdxcdy = bdx * cdy, cdxbdy = cdx * bdy;
  const double cdxady = cdx * ady, adxcdy = adx * cdy;
  const double adxbdy = adx * bdy, bdxady = bdx * ady;
  const double det = adz * (bdxcdy - cdxbdy) + bdz * (cdxady - adxcdy) + cdz * (adxbdy - bdxady);
  const double permanent = (std::abs(bdxcdy) + std::abs(cdxbdy)) * std::abs(adz) +
                           (std::abs(cdxady) + std::abs(adxcdy)) * std::abs(bdz) +
                           (std::abs(adxbdy) + std::abs(bdxady)) * std::abs(cdz);
  if (std::abs(det) > bound_3d * permanent) return sign_of(det);
  return orientation_3d_exact(a, b, c, d);
}

int orientation_2d(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, int drop) {
  const int i = (drop + 1) % 3, j = (drop + 2) % 3;
  const double left = (a[i] - c[i]) * (b[j] - c[j]);
  const double right = (a[j] - c[j]) * (b[i] - c[i]);
  const double det = left - right;
  if (std::abs(det) > bound_2d * (std::abs(left) + std::abs(right))) return sign_of(det);
  Minor exact;
  exact.add_product(Difference::difference(a[i], c[i]), Difference::difference(b[j], c[j]), 1.0);
  exact.add_product(Difference::difference(a[j], c[j]), Difference::difference(b[i], c[i]), -1.0);
  return exact.sign();
}

}  // namespace mv
