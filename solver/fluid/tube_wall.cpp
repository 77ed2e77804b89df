// SPDX-License-Identifier: BSD-3-Clause
#include "solver/fluid/tube_wall.h"

#include <algorithm>
#include <cmath>

namespace mv {
namespace {

// Nearer walls are treated as this share of a cell away; keeps the weights finite.
constexpr double smallest_wall_fraction = 1e-3;
// Faces with a larger sum of weights have them all scaled down. Such a face lies within a few hundredths of a cell of the wall; its velocity is set by the ratio of the
// weights, so the error stays of second order (a parabola, exact without, is off by up to 2e-3 with 8 cells across, 2e-4 with 16), and the viscous step
// no longer depends on how near the wall happens to pass to a face.
constexpr double largest_weight_sum = 60;

// Fraction s in (0,1] of the way from p to p + step at which the polygon is crossed first; 1 when it is not.
double first_crossing(const Eigen::Vector2d& p, const Eigen::Vector2d& step, const std::vector<Eigen::Vector2d>& polygon) {
  double best = 1.0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d a = polygon[i];
    const Eigen::Vector2d e = polygon[(i + 1) % polygon.size()] - a;
    const double det = step.x() * e.y() - step.y() * e.x();
    if (det == 0) continue;
    const Eigen::Vector2d d = a - p;
    const double s = (d.x() * e.y() - d.y() * e.x()) / det;
    const double t = (d.x() * step.y() - d.y() * step.x()) / det;
    if (s >= 0 && s <= best && t >= 0 && t <= 1) best = s;
  }
  return best;
}

}  // namespace

bool is_inside_polygon(const Eigen::Vector2d& p, const std::vector<Eigen::Vector2d>& polygon) {
  bool inside = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const auto& a = polygon[i];
    const auto& b = polygon[j];
    if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()) + a.x()) inside = !inside;
  }
  return inside;
}

TubeWall make_tube_wall(const FluidGrid& grid, const std::vector<Eigen::Vector2d>& cross_section) {
  TubeWall wall;
  wall.is_present = cross_section.size() >= 3;
  const int px = grid.padded(0), py = grid.padded(1);
  const std::size_t size = static_cast<std::size_t>(px) * static_cast<std::size_t>(py);
  const std::array<Eigen::Vector2d, 3> offset{Eigen::Vector2d(0, 0.5), Eigen::Vector2d(0.5, 0), Eigen::Vector2d(0.5, 0.5)};
  const std::array<Eigen::Vector2d, 4> direction{Eigen::Vector2d(-1, 0), Eigen::Vector2d(1, 0), Eigen::Vector2d(0, -1), Eigen::Vector2d(0, 1)};
  for (std::size_t component = 0; component < 3; ++component) {
    WallStencil& s = wall.stencil[component];
    s.open.assign(size, 1.0);
    for (auto& w : s.weight) w.assign(size, 1.0);
    if (!wall.is_present) continue;
    auto position = [&](int i, int j) {
      return Eigen::Vector2d(grid.lower.head<2>() + grid.h * (Eigen::Vector2d(i - FluidGrid::ghosts, j - FluidGrid::ghosts) + offset[component]));
    };
    for (int j = 0; j < py; ++j)
      for (int i = 0; i < px; ++i) s.open[static_cast<std::size_t>(i + px * j)] = is_inside_polygon(position(i, j), cross_section) ? 1.0 : 0.0;
    for (int j = 1; j + 1 < py; ++j) {
      for (int i = 1; i + 1 < px; ++i) {
        const std::size_t here = static_cast<std::size_t>(i + px * j);
        if (s.open[here] == 0) continue;
        std::array<double, 4> fraction{1, 1, 1, 1};
        for (std::size_t d = 0; d < 4; ++d) {
          const int ni = i + static_cast<int>(direction[d].x()), nj = j + static_cast<int>(direction[d].y());
          if (s.open[static_cast<std::size_t>(ni + px * nj)] == 0)
            fraction[d] = std::clamp(first_crossing(position(i, j), grid.h * direction[d], cross_section), smallest_wall_fraction, 1.0);
        }
        double sum = 0;
        for (std::size_t d = 0; d < 4; ++d) {
          s.weight[d][here] = 2.0 / ((fraction[d & ~std::size_t{1}] + fraction[d | 1]) * fraction[d]);
          sum += s.weight[d][here];
        }
        if (sum > largest_weight_sum)
          for (auto& w : s.weight) w[here] *= largest_weight_sum / sum;
      }
    }
  }
  for (int j = 0; j < grid.n[1]; ++j)
    for (int i = 0; i < grid.n[0]; ++i)
      wall.area += grid.h * grid.h * wall.stencil[2].open[static_cast<std::size_t>((i + FluidGrid::ghosts) + px * (j + FluidGrid::ghosts))];
  for (const WallStencil& s : wall.stencil)
    for (std::size_t p = 0; p < size; ++p) {
      const double sum = 2.0 + s.weight[0][p] + s.weight[1][p] + s.weight[2][p] + s.weight[3][p];
      wall.stiffest_weight = std::max(wall.stiffest_weight, sum);
    }
  return wall;
}

}  // namespace mv
