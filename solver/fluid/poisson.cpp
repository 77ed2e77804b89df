// SPDX-License-Identifier: BSD-3-Clause
#include "solver/fluid/poisson.h"

#include <Eigen/Eigenvalues>

#include "geometry/core/parallel.h"

namespace mv {
namespace {

// One-dimensional cell-centred second difference (1/m2).
Eigen::MatrixXd second_difference(int n, double h, PoissonSide lower, PoissonSide upper) {
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
  const double w = 1.0 / (h * h);
  for (int i = 0; i + 1 < n; ++i) {
    a(i, i) -= w;
    a(i + 1, i + 1) -= w;
    a(i, i + 1) += w;
    a(i + 1, i) += w;
  }
  if (lower == PoissonSide::dirichlet_at_face) a(0, 0) -= 2 * w;
  if (upper == PoissonSide::dirichlet_at_face) a(n - 1, n - 1) -= 2 * w;
  if (lower == PoissonSide::periodic && n > 1) {
    a(0, 0) -= w;
    a(n - 1, n - 1) -= w;
    a(0, n - 1) += w;
    a(n - 1, 0) += w;
  }
  return a;
}

}  // namespace

PoissonSolver::PoissonSolver(std::array<int, 3> cells, double h, std::array<std::array<PoissonSide, 2>, 3> sides)
    : n_(cells), h_(h) {
  const int nx = n_[0], ny = n_[1], nz = n_[2];
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ex(second_difference(nx, h, sides[0][0], sides[0][1]));
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ey(second_difference(ny, h, sides[1][0], sides[1][1]));
  qx_ = ex.eigenvectors();
  qy_ = ey.eigenvectors();
  const std::size_t modes = static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny);
  lambda_.resize(modes);
  for (int b = 0; b < ny; ++b)
    for (int a = 0; a < nx; ++a) lambda_[static_cast<std::size_t>(a + nx * b)] = ex.eigenvalues()[a] + ey.eigenvalues()[b];

  is_singular_ = true;
  for (const auto& axis : sides)
    for (PoissonSide side : axis)
      if (side == PoissonSide::dirichlet_at_face) is_singular_ = false;

  z_periodic_ = sides[2][0] == PoissonSide::periodic;
  const double w = 1.0 / (h * h);
  // An eigenvalue this small against 1/h^2 is the constant mode.
  const double zero = 1e-9 * w;
  if (z_periodic_) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ez(second_difference(nz, h, sides[2][0], sides[2][1]));
    qz_ = ez.eigenvectors();
    lambda_z_ = ez.eigenvalues();
    for (int k = 0; k < nz; ++k)
      if (std::abs(lambda_z_[k]) < zero) lambda_z_[k] = 0;
  } else {
    pivot_.resize(modes * static_cast<std::size_t>(nz));
    for (std::size_t m = 0; m < modes; ++m) {
      double previous = 0;
      for (int k = 0; k < nz; ++k) {
        double diagonal = lambda_[m];
        if (k > 0) diagonal -= w;
        if (k + 1 < nz) diagonal -= w;
        if (k == 0 && sides[2][0] == PoissonSide::dirichlet_at_face) diagonal -= 2 * w;
        if (k + 1 == nz && sides[2][1] == PoissonSide::dirichlet_at_face) diagonal -= 2 * w;
        double p = diagonal - (k > 0 ? w * w * previous : 0.0);
        // The constant mode of a pure Neumann problem has a zero last pivot: pin it.
        if (is_singular_ && k + 1 == nz && std::abs(p) < 1e-7 * w) previous = 0;
        else previous = 1.0 / p;
        pivot_[static_cast<std::size_t>(k) * modes + m] = previous;
      }
    }
  }
  scratch_.assign(static_cast<std::size_t>(std::max(1, thread_count())), Eigen::MatrixXd(nx, ny));
  work_.resize(modes * static_cast<std::size_t>(nz));
}

void PoissonSolver::solve(std::vector<double>& values) {
  const int nx = n_[0], ny = n_[1], nz = n_[2];
  const std::ptrdiff_t modes = static_cast<std::ptrdiff_t>(nx) * ny;
  const double w = 1.0 / (h_ * h_);
  if (scratch_.size() < static_cast<std::size_t>(thread_count()))
    scratch_.resize(static_cast<std::size_t>(thread_count()), Eigen::MatrixXd(nx, ny));

  parallel_ranges(
      nz,
      [&](std::ptrdiff_t begin, std::ptrdiff_t end, int thread) {
        Eigen::MatrixXd& t = scratch_[static_cast<std::size_t>(thread)];
        for (std::ptrdiff_t k = begin; k < end; ++k) {
          Eigen::Map<Eigen::MatrixXd> slab(values.data() + k * modes, nx, ny);
          t.noalias() = qx_.transpose() * slab;
          slab.noalias() = t * qy_;
        }
      },
      2);

  if (z_periodic_) {
    parallel_ranges(modes, [&](std::ptrdiff_t begin, std::ptrdiff_t end, int) {
      Eigen::VectorXd line(nz), hat(nz);
      for (std::ptrdiff_t m = begin; m < end; ++m) {
        for (int k = 0; k < nz; ++k) line[k] = values[static_cast<std::size_t>(k * modes + m)];
        hat.noalias() = qz_.transpose() * line;
        for (int k = 0; k < nz; ++k) {
          const double eigenvalue = lambda_[static_cast<std::size_t>(m)] + lambda_z_[k];
          hat[k] = std::abs(eigenvalue) < 1e-9 * w ? 0.0 : hat[k] / eigenvalue;
        }
        line.noalias() = qz_ * hat;
        for (int k = 0; k < nz; ++k) values[static_cast<std::size_t>(k * modes + m)] = line[k];
      }
    });
  } else {
    // Thomas algorithm, all modes side by side.
    parallel_ranges(modes, [&](std::ptrdiff_t begin, std::ptrdiff_t end, int) {
      for (int k = 1; k < nz; ++k) {
        double* now = values.data() + k * modes;
        const double* before = now - modes;
        const double* pivot = pivot_.data() + (k - 1) * modes;
#pragma omp simd
        for (std::ptrdiff_t m = begin; m < end; ++m) now[m] -= w * pivot[m] * before[m];
      }
      double* last = values.data() + (nz - 1) * modes;
      const double* last_pivot = pivot_.data() + (nz - 1) * modes;
#pragma omp simd
      for (std::ptrdiff_t m = begin; m < end; ++m) last[m] *= last_pivot[m];
      for (int k = nz - 2; k >= 0; --k) {
        double* now = values.data() + k * modes;
        const double* after = now + modes;
        const double* pivot = pivot_.data() + k * modes;
#pragma omp simd
        for (std::ptrdiff_t m = begin; m < end; ++m) now[m] = (now[m] - w * after[m]) * pivot[m];
      }
    });
  }

  parallel_ranges(
      nz,
      [&](std::ptrdiff_t begin, std::ptrdiff_t end, int thread) {
        Eigen::MatrixXd& t = scratch_[static_cast<std::size_t>(thread)];
        for (std::ptrdiff_t k = begin; k < end; ++k) {
          Eigen::Map<Eigen::MatrixXd> slab(values.data() + k * modes, nx, ny);
          t.noalias() = qx_ * slab;
          slab.noalias() = t * qy_.transpose();
        }
      },
      2);
  if (is_singular_ && !z_periodic_) {
    const double mean = parallel_sum(static_cast<std::ptrdiff_t>(values.size()), [&](std::ptrdiff_t i) { return values[static_cast<std::size_t>(i)]; }) /
                        static_cast<double>(values.size());
    for (double& v : values) v -= mean;
  }
}

}  // namespace mv
