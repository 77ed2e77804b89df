// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/volume/gates.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "geometry/generic/generic_valve.h"
#include "geometry/volume/leaflet_tets.h"

namespace {

using mv::Vec3;

const mv::LeafletMesh& valve_mesh() {
  static const mv::LeafletMesh mesh = mv::thicken(mv::build_generic_valve({}, 2.0).mid_surface, {});
  return mesh;
}

TEST(Dihedral, regular_and_corner_tetrahedra_have_their_known_angles) {
  for (double angle : mv::dihedral_angles({1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1})) EXPECT_NEAR(angle, 70.528779, 1e-5);
  const auto corner = mv::dihedral_angles({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1});
  for (std::size_t e = 0; e < 3; ++e) EXPECT_NEAR(corner[e], 90, 1e-9);
  for (std::size_t e = 3; e < 6; ++e) EXPECT_NEAR(corner[e], 54.735610, 1e-5);
  // A sliver: four points of a square, one lifted a little. Two edges nearly 180 degrees, four nearly 0.
  const auto sliver = mv::dihedral_angles({0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0.01});
  EXPECT_LT(*std::min_element(sliver.begin(), sliver.end()), 2);
  EXPECT_GT(*std::max_element(sliver.begin(), sliver.end()), 178);
}

TEST(Gates, good_mesh_passes_and_json_carries_every_number) {
  mv::GateLimits limits;
  limits.fluid_spacing = 4;
  const mv::GateReport report = mv::check_leaflets(valve_mesh(), limits);
  EXPECT_TRUE(report.passed()) << report.failures();
  const nlohmann::json json = mv::to_json(report);
  EXPECT_TRUE(json["passed"].get<bool>());
  ASSERT_EQ(json["gates"].size(), report.gates.size());
  for (const auto& gate : json["gates"])
    for (const char* key : {"name", "verdict", "value", "limit", "relation", "unit", "worst_element", "message"})
      EXPECT_TRUE(gate.contains(key)) << key;
}

TEST(Gates, removed_element_beside_the_border_breaks_the_layer_count_not_the_closure) {
  mv::LeafletMesh m = valve_mesh();
  m.tets.erase(m.tets.begin() + 100);
  m.layer.erase(m.layer.begin() + 100);
  m.region.erase(m.region.begin() + 100);
  EXPECT_TRUE(mv::gate_volumes(m).passed);
  // A hole of one tetrahedron is still bounded by a closed oriented surface, so closure alone does not prove the layers.
  mv::LeafletMesh thin = valve_mesh();
  std::vector<std::array<int, 10>> tets;
  std::vector<int> layer;
  for (std::size_t e = 0; e < thin.tets.size(); ++e)
    if (thin.layer[e] == 0) {
      tets.push_back(thin.tets[e]);
      layer.push_back(0);
    }
  thin.tets = tets;
  thin.layer = layer;
  EXPECT_TRUE(mv::gate_boundary(thin).passed);
  EXPECT_FALSE(mv::gate_layers(thin, 2).passed);
}

TEST(Gates, inverted_element_is_named) {
  mv::LeafletMesh m = valve_mesh();
  std::swap(m.tets[321][0], m.tets[321][1]);
  const mv::Gate volume = mv::gate_volumes(m);
  EXPECT_FALSE(volume.passed);
  EXPECT_EQ(volume.worst_element, 321);
  EXPECT_NE(volume.message.find("element 321"), std::string::npos);
  // Swapped on the border, it also turns a boundary triangle around.
  mv::LeafletMesh turned = valve_mesh();
  const int outer = mv::extract_boundary(turned).element[0];
  std::swap(turned.tets[static_cast<std::size_t>(outer)][0], turned.tets[static_cast<std::size_t>(outer)][1]);
  EXPECT_FALSE(mv::gate_boundary(turned).passed);
}

TEST(Gates, sliver_fails_both_dihedral_gates) {
  mv::LeafletMesh m = valve_mesh();
  const auto& t = m.tets[50];
  const auto point = [&](int k) -> Vec3& { return m.points[static_cast<std::size_t>(t[static_cast<std::size_t>(k)])]; };
  point(3) = (point(0) + point(1) + point(2)) / 3 + 1e-3 * Vec3::UnitZ();
  EXPECT_FALSE(mv::gate_dihedral_min(m, 10).passed);
  EXPECT_FALSE(mv::gate_dihedral_max(m, 170).passed);
}

TEST(Gates, spacing_is_the_longest_structural_edge) {
  const mv::LeafletMesh& m = valve_mesh();
  const mv::Gate wide = mv::gate_spacing(m, 4.0, 1.0);
  EXPECT_TRUE(wide.passed) << wide.message;
  EXPECT_GT(wide.value, 1.5);
  EXPECT_LE(wide.value, 2.0 + 1e-9);
  EXPECT_FALSE(mv::gate_spacing(m, 2.0, 1.0).passed);
  EXPECT_NEAR(mv::gate_spacing(mv::to_quadratic(m, 107), 4.0, 1.0).value, 0.5 * wide.value, 1e-12);
  mv::LeafletMesh stretched = m;
  for (Vec3& p : stretched.points) p *= 1.5;
  EXPECT_NEAR(mv::gate_spacing(stretched, 4.0, 1.0).value, 1.5 * wide.value, 1e-9);
}

TEST(Gates, fibres_must_be_unit_finite_and_tangent) {
  for (int defect = 0; defect < 3; ++defect) {
    mv::LeafletMesh m = valve_mesh();
    if (defect == 0) m.fibre[7] *= 1.001;
    if (defect == 1) m.fibre[7].x() = std::nan("");
    if (defect == 2) m.fibre[7] = (m.fibre[7] + 1e-3 * m.sheet_normal[7]).normalized();
    const mv::Gate gate = mv::gate_fibres(m);
    EXPECT_FALSE(gate.passed) << defect;
    EXPECT_EQ(gate.worst_element, 7);
  }
}

TEST(Gates, insertions_sum_to_one_over_both_faces) {
  mv::LeafletMesh m = valve_mesh();
  int upper = -1, lower = -1;
  for (std::size_t i = 0; i < m.side.size(); ++i) {
    if (m.side[i] == mv::atrial) upper = static_cast<int>(i);
    if (m.side[i] == mv::ventricular) lower = static_cast<int>(i);
  }
  mv::Chordae c;
  c.points = {{0, 0, -30}, {0, 0, -10}};
  c.muscle_of_point = {0, -1};
  c.segments = {{0, 1, mv::ChordaKind::primary, 0, mv::anterior, 20, 0.4}};
  c.insertions = {{1, upper, 0.6}, {1, lower, 0.4}};
  auto verdicts = [&](const mv::Chordae& chordae) {
    const auto gates = mv::gate_insertions(m, chordae);
    return std::pair{gates[0].passed, gates[1].passed};
  };
  EXPECT_EQ(verdicts(c), (std::pair{true, true}));
  mv::Chordae bad = c;
  bad.insertions[0].weight = 0.6001;
  EXPECT_FALSE(verdicts(bad).first);
  bad = c;
  bad.insertions = {{1, upper, 1.0}};
  EXPECT_EQ(verdicts(bad), (std::pair{true, false}));
  bad = c;
  bad.insertions[1].node = 1 << 28;
  EXPECT_FALSE(verdicts(bad).first);
  bad = c;
  bad.insertions.clear();
  EXPECT_FALSE(verdicts(bad).first);  // a leaflet end that hangs on nothing
  bad = c;
  bad.insertions = {{1, upper, 1.4}, {1, lower, -0.4}};
  EXPECT_FALSE(verdicts(bad).first);
}

}  // namespace
