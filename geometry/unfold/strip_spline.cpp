// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/unfold/strip_spline.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "geometry/core/errors.h"

namespace mv {
namespace {

std::size_t at(long i) { return static_cast<std::size_t>(i); }

/// Uniform cubic B-spline on the unit cell: the four basis functions, or a derivative of them with respect to the cell coordinate.
std::array<double, 4> basis(double x, int derivative) {
  const double y = 1 - x;
  switch (derivative) {
    case 0: return {y * y * y / 6, (3 * x * x * x - 6 * x * x + 4) / 6, (3 * y * y * y - 6 * y * y + 4) / 6, x * x * x / 6};
    case 1: return {-y * y / 2, (3 * x * x - 4 * x) / 2, -(3 * y * y - 4 * y) / 2, x * x / 2};
    default: return {y, 3 * x - 2, 3 * y - 2, x};
  }
}

struct Cell {
  int index;
  double inside;
};

Cell periodic_cell(double u, double period, int cells) {
  double x = u / period * cells;
  x -= cells * std::floor(x / cells);
  const int i = std::min(static_cast<int>(x), cells - 1);
  return {i, x - i};
}

Cell clamped_cell(double t, int cells) {
  const int i = std::clamp(static_cast<int>(std::floor(t * cells)), 0, cells - 1);
  return {i, t * cells - i};
}

}  // namespace

StripSpline::StripSpline(double period, int cells_u, int cells_t, const std::vector<StripSample>& samples,
                         const std::function<double(double)>& height, double wavelength)
    : period_(period), cells_u_(cells_u), cells_t_(cells_t) {
  const int across = cells_t + 3, count = cells_u * across;
  const auto index = [&](int i, int j) { return (i % cells_u) * across + j; };
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::MatrixX4d rhs = Eigen::MatrixX4d::Zero(count, 4);
  // Dense 16 x 16 blocks per cell, so that the number of triplets does not grow with the number of samples.
  std::vector<Eigen::Matrix<double, 16, 16>> blocks(at(cells_u * cells_t), Eigen::Matrix<double, 16, 16>::Zero());
  const auto products = [&](double x, double y, int dx, int dy) {
    const auto a = basis(x, dx), b = basis(y, dy);
    Eigen::Matrix<double, 16, 1> row;
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) row[4 * i + j] = a[at(i)] * b[at(j)];
    return row;
  };
  for (const StripSample& s : samples) {
    const Cell cu = periodic_cell(s.u, period, cells_u), ct = clamped_cell(s.t, cells_t);
    const Eigen::Matrix<double, 16, 1> row = products(cu.inside, ct.inside, 0, 0);
    blocks[at(cu.index * cells_t + ct.index)] += s.weight * row * row.transpose();
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) rhs.row(index(cu.index + i, ct.index + j)) += s.weight * row[4 * i + j] * s.value.transpose();
  }
  const double lambda = std::pow(std::max(wavelength, 1e-3) / (2 * std::numbers::pi), 4);
  const double du = period / cells_u, dt = 1.0 / cells_t;
  constexpr std::array<double, 3> gauss{0.1127016653792583, 0.5, 0.8872983346207417}, gauss_weight{5.0 / 18, 8.0 / 18, 5.0 / 18};
  for (int i = 0; i < cells_u; ++i)
    for (std::size_t p = 0; p < 3; ++p) {
      const double h = height((i + gauss[p]) * du);
      for (int j = 0; j < cells_t; ++j)
        for (std::size_t q = 0; q < 3; ++q) {
          const double w = lambda * gauss_weight[p] * gauss_weight[q] * du * dt * h;
          const Eigen::Matrix<double, 16, 1> uu = products(gauss[p], gauss[q], 2, 0) / (du * du),
                                             ut = products(gauss[p], gauss[q], 1, 1) / (du * dt * h),
                                             tt = products(gauss[p], gauss[q], 0, 2) / (dt * dt * h * h);
          blocks[at(i * cells_t + j)] += w * (uu * uu.transpose() + 2 * ut * ut.transpose() + tt * tt.transpose());
        }
    }
  for (int i = 0; i < cells_u; ++i)
    for (int j = 0; j < cells_t; ++j)
      for (int a = 0; a < 16; ++a)
        for (int b = 0; b < 16; ++b)
          entries.emplace_back(index(i + a / 4, j + a % 4), index(i + b / 4, j + b % 4), blocks[at(i * cells_t + j)](a, b));
  Eigen::SparseMatrix<double> matrix(count, count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(matrix);
  if (solver.info() != Eigen::Success) throw GateError("leaflets: the smooth surface could not be fitted (singular system)");
  const Eigen::MatrixX4d x = solver.solve(rhs);
  for (int i = 0; i < count; ++i) coefficients_.push_back(x.row(i).transpose());
}

Vec4 StripSpline::evaluate(double u, double t, int du, int dt) const {
  const Cell cu = periodic_cell(u, period_, cells_u_), ct = clamped_cell(t, cells_t_);
  const auto a = basis(cu.inside, du), b = basis(ct.inside, dt);
  const int across = cells_t_ + 3;
  Vec4 sum = Vec4::Zero();
  for (int i = 0; i < 4; ++i) {
    const Vec4* row = &coefficients_[at(((cu.index + i) % cells_u_) * across + ct.index)];
    sum += a[at(i)] * (b[0] * row[0] + b[1] * row[1] + b[2] * row[2] + b[3] * row[3]);
  }
  return sum * std::pow(cells_u_ / period_, du) * std::pow(static_cast<double>(cells_t_), dt);
}

}  // namespace mv
