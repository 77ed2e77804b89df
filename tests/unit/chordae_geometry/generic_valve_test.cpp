// SPDX-License-Identifier: GPL-3.0-or-later
// Chordae and fibres on the real generic valve, linear and quadratic, flat and saddle-shaped.
#include <gtest/gtest.h>

#include "fibers/fiber_field.h"
#include "geometry/chordae/generic_chordae.h"
#include "geometry/generic/generic_valve.h"
#include "geometry/volume/leaflet_tets.h"
#include "support/grid_leaflet.h"

namespace {

using namespace mv;

struct Case {
  LeafletMesh mesh;
  Annulus annulus;
};

Case make_case(const GenericValveParameters& parameters, int order) {
  const GenericValve valve = build_generic_valve(parameters, 1.0);
  ThickenOptions thick;
  thick.order = order;
  return {thicken(valve.mid_surface, thick), valve.annulus};
}

void expect_good(Case c) {
  const Papillary tips = test::ring_papillary();
  const Chordae chordae = generic_chordae(c.mesh, c.annulus, tips, {});
  const InsertionReport insertions = check_insertions(c.mesh, chordae);
  EXPECT_TRUE(insertions.passed) << insertions.first_bad_point;
  EXPECT_EQ(insertions.ends, 22);
  EXPECT_EQ(insertions.ends_on_one_face, 0);
  EXPECT_GE(insertions.nodes_min, 20);
  const LeafletChart chart(c.mesh);
  ASSERT_EQ(chart.junctions().size(), 4u);
  EXPECT_LT(largest_border_gap(chart, chordae), 1.3 * chart.border_length() / 14);
  for (const ChordaSegment& s : chordae.segments) {
    const Vec3 end = chordae.points[static_cast<std::size_t>(s.b)];
    EXPECT_EQ(s.muscle, end.x() > 0 ? 0 : 1);
    EXPECT_GE(s.rest_length, (end - tips.tips[static_cast<std::size_t>(s.muscle)]).norm());
    if (s.leaflet == anterior) {
      EXPECT_GT(end.y(), 0);
    }
  }
  for (const Insertion& i : chordae.insertions)
    EXPECT_FALSE(c.mesh.on_annulus[static_cast<std::size_t>(i.node)]);
  assign_fibers(c.mesh, c.annulus, {});
  const FiberReport arcs = check_fibers(c.mesh, FiberModel::arc);
  EXPECT_TRUE(arcs.passed) << arcs.message;
  assign_fibers(c.mesh, c.annulus, {FiberModel::parallel});
  const FiberReport parallel = check_fibers(c.mesh, FiberModel::parallel);
  EXPECT_TRUE(parallel.passed) << parallel.message;
}

TEST(ChordaeAndFibers, on_the_generic_valve) { expect_good(make_case({}, 1)); }

TEST(ChordaeAndFibers, on_the_quadratic_generic_valve) { expect_good(make_case({}, 2)); }

TEST(ChordaeAndFibers, on_a_saddle_shaped_annulus) {
  GenericValveParameters parameters;
  parameters.saddle_height = 5;
  expect_good(make_case(parameters, 1));
}

}  // namespace
