// SPDX-License-Identifier: BSD-3-Clause
#include "verification/solid/box_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace mv::test {
namespace {

constexpr std::array<std::array<int, 2>, 6> edges{{{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};  // VTK order of midpoints

std::array<double, 6> face_shapes(double r, double s, bool is_quadratic) {
  const double t = 1 - r - s;
  if (!is_quadratic) return {t, r, s, 0, 0, 0};
  return {t * (2 * t - 1), r * (2 * r - 1), s * (2 * s - 1), 4 * t * r, 4 * r * s, 4 * s * t};
}
std::array<double, 6> face_slopes_r(double r, double s, bool is_quadratic) {
  const double t = 1 - r - s;
  if (!is_quadratic) return {-1, 1, 0, 0, 0, 0};
  return {1 - 4 * t, 4 * r - 1, 0, 4 * (t - r), 4 * s, -4 * s};
}
std::array<double, 6> face_slopes_s(double r, double s, bool is_quadratic) {
  const double t = 1 - r - s;
  if (!is_quadratic) return {-1, 0, 1, 0, 0, 0};
  return {1 - 4 * t, 0, 4 * s - 1, -4 * r, 4 * r, 4 * (t - s)};
}

}  // namespace

bool BoxMesh::is_on(int n, int axis, int side) const {
  const std::size_t a = static_cast<std::size_t>(axis);
  return lattice[static_cast<std::size_t>(n)][a] == (side ? 2 * cells[a] : 0);
}

int BoxMesh::node_at(const std::array<int, 3>& half_cells) const {
  const auto found = std::find(lattice.begin(), lattice.end(), half_cells);
  return found == lattice.end() ? -1 : static_cast<int>(found - lattice.begin());
}

std::vector<Face> BoxMesh::faces_on(int axis, int side) const {
  // Outward for a positive element: opposite to corner 0..3.
  constexpr int corners[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  constexpr int mid_of[4][4] = {{-1, 4, 6, 7}, {4, -1, 5, 8}, {6, 5, -1, 9}, {7, 8, 9, -1}};
  std::vector<Face> faces;
  const std::size_t per = static_cast<std::size_t>(mesh.nodes_per_tet);
  for (std::size_t e = 0; e < mesh.tets.size() / per; ++e) {
    const int* tet = mesh.tets.data() + per * e;
    for (const auto& c : corners) {
      if (!std::all_of(c, c + 3, [&](int k) { return is_on(tet[k], axis, side); })) continue;
      Face face{tet[c[0]], tet[c[1]], tet[c[2]], -1, -1, -1};
      if (per == 10)
        for (int k = 0; k < 3; ++k) face[static_cast<std::size_t>(3 + k)] = tet[mid_of[c[k]][c[(k + 1) % 3]]];
      faces.push_back(face);
    }
  }
  return faces;
}

BoxMesh box_mesh(const BoxSpec& spec) {
  BoxMesh box;
  box.cells = spec.cells;
  box.mesh.nodes_per_tet = spec.order == 2 ? 10 : 4;
  std::map<std::array<int, 3>, int> index;
  const auto add_node = [&](const std::array<int, 3>& l, const Vec3& position) {
    const auto [it, is_new] = index.try_emplace(l, box.node_count());
    if (is_new) {
      box.lattice.push_back(l);
      box.mesh.points.insert(box.mesh.points.end(), {position.x(), position.y(), position.z()});
    }
    return it->second;
  };
  const auto mapped = [&](const std::array<int, 3>& l) {
    return spec.place(Vec3(0.5 * l[0] / spec.cells[0], 0.5 * l[1] / spec.cells[1], 0.5 * l[2] / spec.cells[2]));
  };
  constexpr std::array<std::array<std::size_t, 3>, 6> orders{{{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
  for (int k = 0; k < spec.cells[2]; ++k)
    for (int j = 0; j < spec.cells[1]; ++j)
      for (int i = 0; i < spec.cells[0]; ++i)
        for (std::size_t o = 0; o < orders.size(); ++o) {
          std::array<std::array<int, 3>, 4> corner;
          corner[0] = {2 * i, 2 * j, 2 * k};
          for (std::size_t s = 0; s < 3; ++s) {
            corner[s + 1] = corner[s];
            corner[s + 1][orders[o][s]] += 2;
          }
          if (o == 1 || o == 2 || o == 5) std::swap(corner[2], corner[3]);  // odd permutations are turned over
          for (const auto& c : corner) box.mesh.tets.push_back(add_node(c, mapped(c)));
          if (spec.order == 2)
            for (const auto& [a, b] : edges) {
              const auto &p = corner[static_cast<std::size_t>(a)], &q = corner[static_cast<std::size_t>(b)];
              const std::array<int, 3> middle{(p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (p[2] + q[2]) / 2};
              box.mesh.tets.push_back(add_node(middle, spec.is_curved ? mapped(middle) : Vec3(0.5 * (mapped(p) + mapped(q)))));
            }
          box.mesh.fibres.insert(box.mesh.fibres.end(), {spec.fibre.x(), spec.fibre.y(), spec.fibre.z()});
          box.mesh.material.push_back(0);
        }
  return box;
}

void add_face_load(std::span<const Face> faces, std::span<const double> x, const std::function<Vec3(const Vec3&)>& load,
                   std::span<double> f) {
  // Six points, degree 4 (Dunavant 1985).
  constexpr double a = 0.445948490915965, wa = 0.223381589678011, b = 0.091576213509771, wb = 0.109951743655322;
  constexpr double points[6][3] = {{a, a, wa}, {1 - 2 * a, a, wa}, {a, 1 - 2 * a, wa}, {b, b, wb}, {1 - 2 * b, b, wb}, {b, 1 - 2 * b, wb}};
  for (const Face& face : faces) {
    const bool is_quadratic = face[3] >= 0;
    const std::size_t count = is_quadratic ? 6 : 3;
    for (const auto& q : points) {
      const auto shape = face_shapes(q[0], q[1], is_quadratic), dr = face_slopes_r(q[0], q[1], is_quadratic),
                 ds = face_slopes_s(q[0], q[1], is_quadratic);
      Vec3 along_r = Vec3::Zero(), along_s = Vec3::Zero();
      for (std::size_t n = 0; n < count; ++n) {
        along_r += dr[n] * node(x, face[n]);
        along_s += ds[n] * node(x, face[n]);
      }
      const Vec3 force = load(0.5 * q[2] * along_r.cross(along_s));
      for (std::size_t n = 0; n < count; ++n) Vec3::Map(f.data() + 3 * face[n]) += shape[n] * force;
    }
  }
}

void add_pressure(std::span<const Face> faces, double pressure, std::span<const double> x, std::span<double> f) {
  add_face_load(faces, x, [&](const Vec3& area) { return Vec3(-pressure * area); }, f);
}

void add_traction(std::span<const Face> faces, const Vec3& traction, std::span<const double> rest, std::span<double> f) {
  add_face_load(faces, rest, [&](const Vec3& area) { return Vec3(area.norm() * traction); }, f);
}

int append(SolidMesh& all, const SolidMesh& body) {
  const int first = static_cast<int>(all.points.size() / 3);
  all.nodes_per_tet = body.nodes_per_tet;
  all.points.insert(all.points.end(), body.points.begin(), body.points.end());
  for (int n : body.tets) all.tets.push_back(first + n);
  all.fibres.insert(all.fibres.end(), body.fibres.begin(), body.fibres.end());
  all.material.insert(all.material.end(), body.material.begin(), body.material.end());
  return first;
}

double observed_order(double coarse_error, double fine_error) { return std::log2(std::abs(coarse_error) / std::abs(fine_error)); }

}  // namespace mv::test
