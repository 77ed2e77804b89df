// SPDX-License-Identifier: BSD-3-Clause
#include "verification/slab_tissue.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "geometry/core/case.h"

namespace mv::test {
namespace {

// Nodes stand a quarter of their spacing inside the slab, so that none falls on its border.
double plane_y(int j, double depth, int columns) { return depth * (j + 0.25) / columns; }

}  // namespace

Plate SlabTissue::add_plate(Range x, int nx, Range z, int nz) {
  const Plate plate{node_count(), nx, nz, columns};
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j <= columns; ++j)
      for (int i = 0; i <= nx; ++i) {
        mesh.points.insert(mesh.points.end(),
                           {x.low + (x.high - x.low) * i / nx, plane_y(j, depth, columns), z.low + (z.high - z.low) * k / nz});
        side.push_back(between);
        is_held.push_back(0);
        repeats.push_back(plate.node(i, j == columns ? 0 : j, k));
      }
  // The same six tetrahedra around the diagonal in every cell: conforming, and periodic along y.
  constexpr std::array<std::array<int, 3>, 6> orders{{{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < columns; ++j)
      for (int i = 0; i < nx; ++i)
        for (std::size_t o = 0; o < orders.size(); ++o) {
          std::array<int, 3> corner{i, j, k};
          std::array<int, 4> tet{plate.node(i, j, k)};
          for (std::size_t s = 0; s < 3; ++s) {
            ++corner[static_cast<std::size_t>(orders[o][s])];
            tet[s + 1] = plate.node(corner[0], corner[1], corner[2]);
          }
          const bool is_odd = o == 1 || o == 2 || o == 5;  // odd permutations are turned over
          if (is_odd) std::swap(tet[2], tet[3]);
          mesh.tets.insert(mesh.tets.end(), tet.begin(), tet.end());
          mesh.fibres.insert(mesh.fibres.end(), {0, 1, 0});
          mesh.material.push_back(0);
        }
  return plate;
}

void SlabTissue::make_quadratic() {
  constexpr std::array<std::array<int, 2>, 6> edges{{{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};
  // A node's place in the plane, in units far below any spacing.
  const auto place_of = [&](int node) {
    const double* p = mesh.points.data() + 3 * node;
    return std::pair(std::llround(p[0] / (1e-6 * depth)), std::llround(p[2] / (1e-6 * depth)));
  };
  std::map<std::pair<long long, long long>, int> own;
  for (int i = 0; i < node_count(); ++i)
    if (!is_copy(i)) own.emplace(place_of(i), i);
  for (int i = 0; i < node_count(); ++i) repeats[static_cast<std::size_t>(i)] = own.at(place_of(i));
  std::map<std::pair<int, int>, int> middle_of;
  const auto middle = [&](int a, int b) {
    const auto [found, is_new] = middle_of.try_emplace(std::minmax(a, b), node_count());
    if (!is_new) return found->second;
    const int node = found->second;
    for (int axis = 0; axis < 3; ++axis)
      mesh.points.push_back(0.5 * (mesh.points[static_cast<std::size_t>(3 * a + axis)] + mesh.points[static_cast<std::size_t>(3 * b + axis)]));
    side.push_back(between);
    is_held.push_back(static_cast<char>(is_held[static_cast<std::size_t>(a)] && is_held[static_cast<std::size_t>(b)]));
    repeats.push_back(own.try_emplace(place_of(node), node).first->second);
    return node;
  };
  // The first plane's edges first: their middles are the ones that are repeated.
  for (std::size_t t = 0; t < mesh.tets.size(); t += 4)
    for (const auto& [a, b] : edges) {
      const int first = mesh.tets[t + static_cast<std::size_t>(a)], second = mesh.tets[t + static_cast<std::size_t>(b)];
      if (!is_copy(first) && !is_copy(second)) middle(first, second);
    }
  std::vector<int> quadratic;
  for (std::size_t t = 0; t < mesh.tets.size(); t += 4) {
    const int* corner = mesh.tets.data() + t;
    quadratic.insert(quadratic.end(), corner, corner + 4);
    for (const auto& [a, b] : edges) quadratic.push_back(middle(corner[a], corner[b]));
  }
  mesh.tets = std::move(quadratic);
  mesh.nodes_per_tet = 10;
}

int SlabTissue::nearest_node(double x, double z) const {
  int nearest = -1;
  double least = 1e300;
  for (int i = 0; i < node_count(); ++i) {
    const double* p = mesh.points.data() + 3 * i;
    const double distance = std::hypot(p[0] - x, p[2] - z);
    if (!is_copy(i) && distance < least) {
      least = distance;
      nearest = i;
    }
  }
  return nearest;
}

void SlabTissue::gather_copies(std::vector<double>& array) const {
  for (int i = 0; i < node_count(); ++i)
    if (is_copy(i))
      for (std::size_t a = 0; a < 3; ++a) {
        double& copy = array[3 * static_cast<std::size_t>(i) + a];
        array[3 * static_cast<std::size_t>(repeats[static_cast<std::size_t>(i)]) + a] += copy;
        copy = 0;
      }
}

void SlabTissue::share_with_copies(std::span<const double> volumes, std::vector<double>& array) const {
  for (int i = 0; i < node_count(); ++i)
    if (is_copy(i)) {
      const std::size_t copy = static_cast<std::size_t>(i), own = static_cast<std::size_t>(repeats[copy]);
      const double share = volumes[copy] / (volumes[copy] + volumes[own]);
      for (std::size_t a = 0; a < 3; ++a) {
        array[3 * copy + a] = share * array[3 * own + a];
        array[3 * own + a] *= 1 - share;
      }
    }
}

void SlabTissue::follow_first_plane(std::vector<double>& x, std::vector<double>& v) const {
  for (int i = 0; i < node_count(); ++i) {
    const std::size_t to = 3 * static_cast<std::size_t>(i),
                      from = 3 * static_cast<std::size_t>(repeats[static_cast<std::size_t>(i)]);
    for (std::size_t a : {0u, 2u}) {
      x[to + a] = x[from + a];
      v[to + a] = v[from + a];
    }
    x[to + 1] = mesh.points[to + 1];
    v[to + 1] = 0;
  }
}

ContactSurface facing_surface(const SlabTissue& tissue) {
  std::vector<std::array<int, 10>> tets(tissue.mesh.tets.size() / 4);
  for (std::size_t e = 0; e < tets.size(); ++e)
    std::copy_n(tissue.mesh.tets.begin() + static_cast<std::ptrdiff_t>(4 * e), 4, tets[e].begin());
  return extract_contact_surface(tissue.mesh.points, tets, 1, tissue.side, ContactFaces::inner);
}

std::unique_ptr<SelfContact> make_contact(const ContactSurface& surface, const ContactOptions& options) {
  return std::make_unique<SelfContact>(surface, options);
}

std::vector<double> block_points(Range x, Range z, double spacing, double depth, int columns) {
  const auto cells = [&](Range r) { return std::max(1, static_cast<int>(std::ceil((r.high - r.low) / spacing - 1e-9))); };
  const int nx = cells(x), nz = cells(z);
  std::vector<double> points;
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j < columns; ++j)
      for (int i = 0; i <= nx; ++i)
        points.insert(points.end(),
                      {x.low + (x.high - x.low) * i / nx, plane_y(j, depth, columns), z.low + (z.high - z.low) * k / nz});
  return points;
}

FluidGrid slab_grid(Range x, Range z, double h, int cells_deep) {
  FluidGrid grid;
  grid.h = h;
  grid.n = {static_cast<int>(std::lround((x.high - x.low) / h)), cells_deep, static_cast<int>(std::lround((z.high - z.low) / h))};
  grid.lower = {x.low, 0.0, z.low};
  return grid;
}

}  // namespace mv::test
