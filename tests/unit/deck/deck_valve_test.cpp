// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/deck/deck_valve.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numeric>

#include "geometry/core/errors.h"
#include "geometry/core/leaflet_names.h"
#include "geometry/deck/deck_chordae.h"
#include "geometry/deck/ring_pattern.h"
#include "tests/unit/deck/small_deck.h"

namespace {

using namespace mv;
using deck_test::Folder;
using deck_test::RingDeck;

DeckValve valve_of(const RingDeck& ring, const DeckValveOptions& options = {}) {
  const Folder folder;
  return build_deck_valve(read_abaqus_deck(folder.write("ring.inp", ring.text())), options);
}

std::string error_of(const std::string& text, const DeckValveOptions& options = {}) {
  const Folder folder;
  try {
    build_deck_valve(read_abaqus_deck(folder.write("ring.inp", text)), options);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const auto at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), by);
}

TEST(deck_valve, ring_of_three_leaflets_with_its_borders_and_motion) {
  const DeckValve v = valve_of({});
  EXPECT_EQ(v.points.size(), 48u);
  EXPECT_EQ(v.triangles.size(), 72u);
  for (const int region : {static_cast<int>(anterior), static_cast<int>(posterior), septal}) EXPECT_EQ(std::count(v.region.begin(), v.region.end(), region), 24) << region;
  ASSERT_EQ(v.annulus.size(), 12u);
  ASSERT_EQ(v.free_edge.size(), 12u);
  for (const int p : v.annulus) EXPECT_EQ(v.points[static_cast<std::size_t>(p)].z(), 0);
  for (const int p : v.free_edge) EXPECT_EQ(v.points[static_cast<std::size_t>(p)].z(), -6);
  for (const Vec3& u : v.annulus_displacement) EXPECT_EQ(u, Vec3(0.5, 0, 0));
  EXPECT_TRUE(v.motion_amplitude.is_smooth);
  EXPECT_EQ(v.period, 2);
  EXPECT_NEAR(*v.pressure, 3000, 1e-9);  // 0.003 MPa
  EXPECT_TRUE(v.has_uniform_thickness);
  EXPECT_EQ(v.thickness[0], 0.65);
}

TEST(deck_valve, triangles_look_to_the_atrium_whichever_way_the_elements_do) {
  // Ventricle outside of the ring: pressure on SPOS of outward elements, on SNEG of inward ones.
  RingDeck inward;
  inward.is_outward = false;
  for (const std::string& text : {RingDeck().text(), replaced(inward.text(), "Inst.Leaflets, SPOS", "Inst.Leaflets, SNEG"),
                                  replaced(inward.text(), "Leaflets, P, 0.003", "Leaflets, P, -0.003")}) {
    const Folder folder;
    const DeckValve v = build_deck_valve(read_abaqus_deck(folder.write("ring.inp", text)), {});
    for (const auto& t : v.triangles) {
      const Vec3 &a = v.points[static_cast<std::size_t>(t[0])], &b = v.points[static_cast<std::size_t>(t[1])], &c = v.points[static_cast<std::size_t>(t[2])];
      const Vec3 middle = (a + b + c) / 3;
      EXPECT_LT((b - a).cross(c - a).dot(Vec3(middle.x(), middle.y(), 0)), 0);
    }
  }
}

TEST(deck_valve, fibres_are_tangent_and_follow_the_orientation_of_their_element) {
  const DeckValve v = valve_of({});
  ASSERT_EQ(v.fibre.size(), v.triangles.size());
  // Element 1 has (0, 0, 1) of its own, the others (1, 0, 0) projected on the shell.
  EXPECT_NEAR(std::abs(v.fibre[0].z()), 1, 1e-12);
  EXPECT_NEAR(v.fibre[4].z(), 0, 1e-12);
  for (std::size_t t = 0; t < v.fibre.size(); ++t) {
    const auto& k = v.triangles[t];
    const Vec3 &a = v.points[static_cast<std::size_t>(k[0])], &b = v.points[static_cast<std::size_t>(k[1])], &c = v.points[static_cast<std::size_t>(k[2])];
    EXPECT_NEAR(v.fibre[t].dot((b - a).cross(c - a).normalized()), 0, 1e-12);
  }
}

TEST(deck_valve, chains_of_trusses_become_one_chorda_of_the_same_length) {
  DeckValveOptions options;
  const DeckValve merged = valve_of({}, options);
  options.merge_chains = false;
  const DeckValve pieces = valve_of({}, options);
  EXPECT_EQ(pieces.chordae.segments.size(), 12u);
  ASSERT_EQ(merged.chordae.segments.size(), 9u);
  auto total = [](const DeckValve& v) {
    return std::accumulate(v.chordae.segments.begin(), v.chordae.segments.end(), 0.0, [](double sum, const auto& s) { return sum + s.rest_length; });
  };
  EXPECT_NEAR(total(merged), total(pieces), 1e-9);
  EXPECT_EQ(merged.tips.size(), 3u);
  // Root to branch: two trusses, sqrt(4 + 49) and sqrt(9 + 64) long.
  EXPECT_NEAR(merged.chordae.segments[0].rest_length, std::sqrt(53.0) + std::sqrt(73.0), 1e-4);
  for (const auto& s : merged.chordae.segments) {
    EXPECT_EQ(s.area, 0.35);
    EXPECT_GT(s.leaflet, 0);
    EXPECT_EQ(s.material, "cord");
    EXPECT_GE(s.tip, 0);
  }
}

TEST(deck_valve, chordae_hang_on_the_column_of_their_node) {
  const DeckValve v = valve_of({});
  // Three levels of the mid-surface's points and one tetrahedron that makes the middle of column 0 the heaviest.
  LeafletMesh mesh;
  for (int level = 0; level < 3; ++level)
    for (const Vec3& p : v.points) mesh.points.push_back(p * (1 + 0.03 * (level - 1)));
  const int n = static_cast<int>(v.points.size());
  for (const auto& t : v.triangles)
    for (int level = 0; level < 2; ++level) mesh.tets.push_back({t[0] + level * n, t[2] + level * n, t[1] + level * n, t[0] + (level + 1) * n, -1, -1, -1, -1, -1, -1});
  const Chordae c = hang_chordae(v, mesh, 2);
  EXPECT_EQ(c.segments.size(), 9u);
  ASSERT_EQ(c.insertions.size(), 18u);  // six ends of three nodes
  double sum = 0;
  Vec3 at = Vec3::Zero();
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(c.insertions[i].point, c.insertions[0].point);
    sum += c.insertions[i].weight;
    at += c.insertions[i].weight * mesh.points[static_cast<std::size_t>(c.insertions[i].node)];
  }
  EXPECT_NEAR(sum, 1, 1e-15);
  EXPECT_LT((at - c.points[static_cast<std::size_t>(c.insertions[0].point)]).norm(), 1e-12);
  long primary = 0;
  for (const auto& s : c.segments) primary += s.kind == ChordaKind::primary;
  EXPECT_EQ(primary, 6);  // the end at the free edge and what leads to it, three times
}

TEST(deck_valve, faults_are_named) {
  const std::string good = RingDeck().text();
  const struct {
    std::string text, message;
  } faults[] = {
      {replaced(replaced(good, "elset=Septal_Leaflet", "elset=Third"), ", Septal_Leaflet", ", Third"), "belongs to no leaflet"},
      {replaced(good, "*Boundary, op=NEW, amplitude=Amp-1\nInst.Annulus, 1, 1, 0.5\nInst.Annulus, 2, 3\n", ""), "expected the annulus to be held"},
      {replaced(good, "Inst.Roots, PINNED\n", ""), "no end of a chorda is held"},
      {replaced(good, "1000, 1010,\n1020\n", "1000, 1010\n"), "hang on no held root"},
      {replaced(good, "*Solid Section, elset=Chordae, material=Cord\n0.35,\n", ""), "T3D2 element 500 has no section"},
      {replaced(good, "0.35,", ","), "has no cross-section"},
      {replaced(good, "2, 13, 25, 26, 14\n", ""), "the leaflets have 3 borders"},
      {replaced(good, "2, 13, 25, 26, 14\n", "2, 13, 14, 26, 25\n"), "not consistently oriented"},
  };
  for (const auto& fault : faults) EXPECT_NE(error_of(fault.text).find(fault.message), std::string::npos) << fault.message << "\n" << error_of(fault.text);
  DeckValveOptions options;
  options.leaflets = {"mitral=Leaflets"};
  EXPECT_NE(error_of(good, options).find("expected NAME=SET"), std::string::npos);
  options.leaflets = {"anterior=Leaflets", "septal=Septal_Leaflet"};
  EXPECT_NE(error_of(replaced(good, "elset=Septal_Leaflet", "elset=Septal_Leaflet"), options).find("two leaflets"), std::string::npos);
  options = {};
  options.units = "inch";
  EXPECT_NE(error_of(good, options).find("deck.units"), std::string::npos);
}

TEST(ring_pattern, keeps_the_annulus_and_folds_nowhere) {
  RingDeck ring;
  ring.around = 48;
  ring.down = 9;
  const DeckValve v = valve_of(ring);
  const RingPattern pattern = unfold_ring(v.points, v.triangles, v.annulus, v.free_edge);
  const double chord = 2 * ring.radius * std::sin(std::acos(-1.0) / ring.around);
  EXPECT_NEAR(pattern.perimeter, ring.around * chord, 1e-3);
  EXPECT_GT(smallest_unfolded_area(pattern, v.triangles), 0);
  for (const int p : v.annulus) EXPECT_NEAR(pattern.unfolded[static_cast<std::size_t>(p)].y(), 0, 1e-12);
  for (const int p : v.free_edge) EXPECT_NEAR(pattern.unfolded[static_cast<std::size_t>(p)].y(), ring.height, 1e-4);
  // A cylinder is flat already: areas add up to its own.
  double area = 0;
  for (const Vec2& uv : pattern.unfolded) EXPECT_TRUE(uv.x() >= 0 && uv.x() < pattern.perimeter);
  for (const auto& t : v.triangles) {
    const Vec2 o = pattern.unfolded[static_cast<std::size_t>(t[0])];
    Vec2 a = pattern.unfolded[static_cast<std::size_t>(t[1])] - o, b = pattern.unfolded[static_cast<std::size_t>(t[2])] - o;
    for (Vec2* e : {&a, &b}) e->x() -= pattern.perimeter * std::round(e->x() / pattern.perimeter);
    area += 0.5 * (a.x() * b.y() - a.y() * b.x());
  }
  EXPECT_NEAR(area, pattern.perimeter * ring.height, 1e-2);
}

}  // namespace
