// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Small case parts with every array filled, and a directory that goes away with the test.

#include <stdlib.h>

#include <filesystem>
#include <string>

#include "geometry/core/case.h"

namespace mv_test {

class TemporaryDirectory {
 public:
  TemporaryDirectory() {
    std::string pattern = (std::filesystem::temp_directory_path() / "mv_test_XXXXXX").string();
    if (!mkdtemp(pattern.data())) throw std::runtime_error("cannot create a directory for the test");
    path_ = pattern;
  }
  ~TemporaryDirectory() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline mv::LeafletMesh sample_leaflets(int order) {
  mv::LeafletMesh mesh;
  mesh.order = order;
  const int points = order == 2 ? 14 : 5;
  for (int i = 0; i < points; ++i) {
    mesh.points.push_back({0.1 * i, 1.0 / (i + 3), -0.7 * i * i});
    mesh.on_annulus.push_back(i % 2);
    mesh.on_free_edge.push_back(i % 3 == 0);
    mesh.side.push_back(i % 3 - 1);
    mesh.unfolded.push_back({1.5 * i, -0.25 * i});
  }
  for (int c = 0; c < 2; ++c) {
    std::array<int, 10> tet;
    tet.fill(-1);
    for (int i = 0; i < mesh.nodes_per_tet(); ++i) tet[i] = (i + c * (points - mesh.nodes_per_tet())) % points;
    mesh.tets.push_back(tet);
    mesh.region.push_back(c + 1);
    mesh.layer.push_back(c);
    mesh.fibre.push_back(mv::Vec3(1, c, 0.5).normalized());
    mesh.sheet_normal.push_back(mv::Vec3(0, c, 1).normalized());
  }
  return mesh;
}

inline mv::Chordae sample_chordae() {
  mv::Chordae chordae;
  chordae.points = {{10, -2, -32}, {5, 1, -20}, {4, 2, -10.1}, {6, 2, -10.2}};
  chordae.muscle_of_point = {0, -1, -1, -1};
  chordae.segments = {{0, 1, mv::ChordaKind::primary, 0, 1, 13.3, 0.4},
                      {1, 2, mv::ChordaKind::secondary, 0, 1, 10.0 / 3, 0.8},
                      {1, 3, mv::ChordaKind::strut, 1, 2, 9.5, 1.25}};
  chordae.insertions = {{2, 0, 0.25}, {2, 3, 0.75}, {3, 4, 1.0}};
  return chordae;
}

inline mv::Tube sample_tube() {
  mv::Tube tube;
  tube.origin = {1, 2, 3.3};
  tube.axes << 0, 1, 0, -1, 0, 0, 0, 0, 1;
  tube.cross_section = {{10, 0}, {0, 9}, {-10, 0.1}, {0, -9}};
  tube.z_ventricle = -40;
  tube.z_atrium = 20;
  tube.grid_lower = {-13, -12, -40};
  tube.grid_cells = {26, 24, 60};
  tube.grid_spacing = 1.0;
  for (int i = 0; i < 12; ++i) tube.points.push_back({double(i % 2), double(i / 2 % 2), double(i / 4)});
  tube.hexes = {{0, 1, 3, 2, 4, 5, 7, 6}, {4, 5, 7, 6, 8, 9, 11, 10}};
  return tube;
}

inline mv::Annulus sample_annulus() {
  mv::Annulus annulus;
  annulus.points = {{19, 0, 0}, {0, 15, 0.5}, {-19, 0, 0}, {0, -15, 0.5}};
  annulus.origin = {0.1, 0.2, 0.3};
  annulus.normal = {0, 0.6, -0.8};
  annulus.axis_major = {1, 0, 0};
  annulus.residual_rms = 0.123;
  annulus.eigenvalues = {180, 112, 0.06};
  annulus.sign_rule = "towards the papillary tips";
  return annulus;
}

inline mv::Papillary sample_papillary() { return {{{10, -2, -32}, {-10, -2, -32}}, {"anterolateral", "posteromedial"}}; }

}  // namespace mv_test
