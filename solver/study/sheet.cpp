// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/sheet.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>

namespace mv {
namespace {

/// Gives every linear element its six mid-edge points (VTK order). What lies on the sides and faces follows from the coordinates.
void make_quadratic(LeafletMesh& mesh) {
  constexpr int edges[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};
  std::map<std::pair<int, int>, int> middle;
  for (auto& tet : mesh.tets)
    for (int e = 0; e < 6; ++e) {
      int a = tet[static_cast<std::size_t>(edges[e][0])], b = tet[static_cast<std::size_t>(edges[e][1])];
      if (a > b) std::swap(a, b);
      const auto [at, is_new] = middle.try_emplace({a, b}, static_cast<int>(mesh.points.size()));
      if (is_new) mesh.points.push_back(0.5 * (mesh.points[static_cast<std::size_t>(a)] + mesh.points[static_cast<std::size_t>(b)]));
      tet[static_cast<std::size_t>(4 + e)] = at->second;
    }
  mesh.order = 2;
}

}  // namespace

LeafletMesh sheet_mesh(const SheetShape& s) {
  LeafletMesh mesh;
  const int nx = static_cast<int>(std::lround(s.width_mm / s.solid_mm)), ny = static_cast<int>(std::lround(s.depth_mm / s.solid_mm)), nz = s.layers;
  auto node = [&](const std::array<int, 3>& c) { return c[0] + (nx + 1) * (c[1] + (ny + 1) * c[2]); };
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i)
        mesh.points.emplace_back(s.width_mm * (static_cast<double>(i) / nx - 0.5), s.depth_mm * (static_cast<double>(j) / ny - 0.5), s.thickness_mm * (static_cast<double>(k) / nz - 0.5));
  constexpr std::array<std::array<int, 3>, 6> orders{{{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i)
        for (const auto& order : orders) {
          std::array<int, 3> corner{i, j, k};
          std::array<int, 10> tet;
          tet.fill(-1);
          tet[0] = node(corner);
          for (std::size_t n = 0; n < 3; ++n) {
            ++corner[static_cast<std::size_t>(order[n])];
            tet[n + 1] = node(corner);
          }
          auto x = [&](std::size_t n) { return mesh.points[static_cast<std::size_t>(tet[n])]; };
          if ((x(1) - x(0)).cross(x(2) - x(0)).dot(x(3) - x(0)) < 0) std::swap(tet[2], tet[3]);
          mesh.tets.push_back(tet);
          mesh.region.push_back(anterior);
          mesh.layer.push_back(nz - 1 - k);
          mesh.fibre.push_back(Vec3::UnitX());
          mesh.sheet_normal.push_back(Vec3::UnitZ());
        }
  if (s.order == 2) make_quadratic(mesh);
  const double eps = 1e-6 * s.solid_mm;
  for (const Vec3& p : mesh.points) {
    mesh.on_annulus.push_back(std::abs(p.x()) > 0.5 * s.width_mm - eps || std::abs(p.y()) > 0.5 * s.depth_mm - eps);
    mesh.on_free_edge.push_back(0);
    mesh.side.push_back(p.z() > 0.5 * s.thickness_mm - eps ? atrial : p.z() < -0.5 * s.thickness_mm + eps ? ventricular : between);
    mesh.unfolded.emplace_back(p.x(), p.y());
  }
  return mesh;
}

Scene sheet_scene(const SheetShape& s, const std::vector<std::string>& settings) {
  Scene scene;
  scene.mesh = sheet_mesh(s);
  for (const std::string& setting : {std::string("chordae.model=none"), std::string("contact.enabled=false"), std::string("gates.min_dihedral=1 deg"), fmt::format("tube.spacing={:.17g} mm", s.fluid_mm),
                                     fmt::format("mesh.spacing={:.17g} mm", s.solid_mm), fmt::format("mesh.order={}", s.order), fmt::format("mesh.thickness={:.17g} mm", s.thickness_mm),
                                     std::string("leaflet.anterior.law=neo_hookean"), std::string("leaflet.posterior.law=neo_hookean")})
    scene.config.set(setting);
  for (const std::string& setting : settings) scene.config.set(setting);
  const double clearance = 0.25, half_x = 0.5 * s.width_mm + clearance, half_y = 0.5 * s.depth_mm + clearance;
  Tube& tube = scene.tube;
  tube.cross_section = {{-half_x, -half_y}, {half_x, -half_y}, {half_x, half_y}, {-half_x, half_y}};
  tube.z_ventricle = -s.length_mm;
  tube.z_atrium = s.length_mm;
  tube.grid_spacing = s.fluid_mm;
  constexpr int margin = 3;
  auto cells = [&](double half) { return 2 * (static_cast<int>(std::ceil(half / s.fluid_mm)) + margin); };
  tube.grid_cells = {cells(half_x), cells(half_y), 2 * static_cast<int>(std::lround(s.length_mm / s.fluid_mm))};
  for (int a = 0; a < 3; ++a) tube.grid_lower[a] = -0.5 * tube.grid_cells[static_cast<std::size_t>(a)] * s.fluid_mm;
  for (const Vec2& p : tube.cross_section) scene.annulus.points.emplace_back(p.x(), p.y(), 0);
  return scene;
}

}  // namespace mv
