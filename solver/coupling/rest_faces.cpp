// SPDX-License-Identifier: BSD-3-Clause
#include "solver/coupling/rest_faces.h"

#include <algorithm>
#include <cmath>

namespace mv {
namespace {

using Eigen::Vector3d;

constexpr double border = 1e-9;  // relative widening of triangles, so that lines through a common border meet one of them

/// Where the line through `p` along `axis` meets the triangle: the coordinate along the axis. False when it misses.
bool line_meets(const RestTriangle& t, const Vector3d& p, int axis, double& at) {
  const int a = (axis + 1) % 3, b = (axis + 2) % 3;
  std::array<double, 3> w;
  double sum = 0, scale = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3d &q = t[(i + 1) % 3], &r = t[(i + 2) % 3];
    w[i] = (q[a] - p[a]) * (r[b] - p[b]) - (q[b] - p[b]) * (r[a] - p[a]);
    sum += w[i];
    scale = std::max(scale, (r - q).squaredNorm());
  }
  if (std::abs(sum) <= border * scale) return false;  // the triangle is seen from its edge
  at = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    w[i] /= sum;
    if (w[i] < -border) return false;
    at += w[i] * t[i][axis];
  }
  return true;
}

}  // namespace

RestFaces faces_crossed(const FluidGrid& grid, const std::vector<RestTriangle>& triangles) {
  RestFaces faces;
  const std::array<std::ptrdiff_t, 3> stride{1, grid.stride_y(), grid.stride_z()};
  for (const RestTriangle& world : triangles) {
    // In cells, cell centres at whole numbers.
    RestTriangle t;
    for (std::size_t i = 0; i < 3; ++i) t[i] = (world[i] - grid.lower) / grid.h - Vector3d::Constant(0.5);
    const Vector3d low = t[0].cwiseMin(t[1]).cwiseMin(t[2]), high = t[0].cwiseMax(t[1]).cwiseMax(t[2]);
    for (int axis = 0; axis < 3; ++axis) {
      const int a = (axis + 1) % 3, b = (axis + 2) % 3;
      const auto first = [&](int c) { return std::max(0, static_cast<int>(std::ceil(low[c] - border))); };
      const auto last = [&](int c) { return std::min(grid.n[static_cast<std::size_t>(c)] - 1, static_cast<int>(std::floor(high[c] + border))); };
      for (int q = first(b); q <= last(b); ++q)
        for (int p = first(a); p <= last(a); ++p) {
          Vector3d point = Vector3d::Zero();
          point[a] = p;
          point[b] = q;
          double at = 0;
          if (!line_meets(t, point, axis, at)) continue;
          const int face = static_cast<int>(std::floor(at)) + 1;  // between the centres of cells face - 1 and face
          if (face < 0 || face > grid.n[static_cast<std::size_t>(axis)]) continue;
          const std::size_t k = static_cast<std::size_t>(axis);
          faces[k].push_back(grid.index(0, 0, 0) + face * stride[k] + p * stride[static_cast<std::size_t>(a)] + q * stride[static_cast<std::size_t>(b)]);
        }
    }
  }
  for (auto& list : faces) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return faces;
}

}  // namespace mv
