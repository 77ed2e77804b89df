// SPDX-License-Identifier: BSD-3-Clause
// A leaflet of 1 mm must not feel itself through its thickness or along a bend, and must feel itself across a fold.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "solver/contact/self_contact.h"
#include "unit/contact/shapes.h"

namespace mv::test {
namespace {

constexpr double mm = 1e-3;
constexpr double pi = std::numbers::pi;

TetMesh leaflet(double length, double width) {
  return tet_box(static_cast<int>(std::lround(length / (0.5 * mm))), static_cast<int>(std::lround(width / (0.5 * mm))), 2, length,
                 width, 1 * mm);
}

/// Bends the sheet [0, length] x [0, width] x [0, 1 mm] into a cylinder whose inner face (z = 1 mm) has the given radius.
std::vector<double> bent(const TetMesh& m, double inner_radius) {
  const double middle = inner_radius + 0.5 * mm;
  return m.mapped([&](const Vec3& p) -> Vec3 {
    const double angle = p[0] / middle, r = inner_radius + 1 * mm - p[2];
    return {r * std::sin(angle), p[1], -r * std::cos(angle)};
  });
}

/// Serpentine: straight runs joined by half circles, faces of neighbouring runs `clearance` apart.
std::vector<double> serpentine(const TetMesh& m, double run, double clearance) {
  const double middle = 0.5 * (1 * mm + clearance), arc = pi * middle, period = run + arc;
  return m.mapped([&](const Vec3& p) -> Vec3 {
    const int k = static_cast<int>(std::floor(p[0] / period));
    const double s = p[0] - k * period, z = p[2] - 0.5 * mm;
    const double base = 2 * middle * k, sign = k % 2 == 0 ? 1.0 : -1.0;  // direction of the run; z points up in even runs
    if (s < run) return {sign * (s - 0.5 * run), p[1], base + sign * z};
    const double angle = (s - run) / middle, r = middle - sign * z;
    return {sign * (0.5 * run + r * std::sin(angle)), p[1], base + middle - r * std::cos(angle)};
  });
}

ContactResult evaluate(const ContactSurface& s, const std::vector<double>& x, const ContactOptions& options,
                       std::vector<double>* gap = nullptr) {
  SelfContact contact(s, options);
  std::vector<double> v(x.size(), 0.0), forces(x.size(), 0.0);
  const auto result = contact.evaluate(x, v, 1e-5, forces);
  if (gap) gap->assign(contact.gap().begin(), contact.gap().end());
  return result;
}

TEST(SelfTriggering, a_flat_or_bent_leaflet_does_not_touch_itself) {
  const TetMesh m = leaflet(12 * mm, 5 * mm);
  const auto s = extract_contact_surface(m.x, m.tets, 1, m.side, ContactFaces::both);
  ContactOptions options;
  options.threshold = 0.2 * mm;
  EXPECT_EQ(evaluate(s, m.x, options).active_nodes, 0);
  // Down to an inner radius of a fifth of the thickness; no bend closes more than a full circle.
  for (double radius : {4 * mm, 2 * mm}) EXPECT_EQ(evaluate(s, bent(m, radius), options).active_nodes, 0) << radius;
  const TetMesh strip = leaflet(4 * mm, 5 * mm);
  const auto strip_surface = extract_contact_surface(strip.x, strip.tets, 1, strip.side, ContactFaces::both);
  for (double radius : {1 * mm, 0.5 * mm, 0.3 * mm}) {
    const double turn = 4 * mm / (radius + 0.5 * mm);
    if (turn < 2 * pi - 0.7) {
      EXPECT_EQ(evaluate(strip_surface, bent(strip, radius), options).active_nodes, 0) << radius;
    }
  }
}

TEST(SelfTriggering, squeezing_and_stretching_the_leaflet_is_not_contact) {
  const TetMesh m = leaflet(8 * mm, 5 * mm);
  const auto s = extract_contact_surface(m.x, m.tets, 1, m.side, ContactFaces::both);
  ContactOptions options;
  for (double thin : {1.0, 0.6, 0.3}) {  // incompressible: thin and wide, or thick and narrow
    const auto squeezed = m.mapped([&](const Vec3& p) -> Vec3 {
      return {p[0] / std::sqrt(thin), p[1] / std::sqrt(thin), p[2] * thin};
    });
    EXPECT_EQ(evaluate(s, squeezed, options).active_nodes, 0) << thin;
    const auto narrowed = m.mapped([&](const Vec3& p) -> Vec3 { return {p[0] * thin, p[1], p[2] / thin}; });
    EXPECT_EQ(evaluate(s, narrowed, options).active_nodes, 0) << thin;
  }
  const auto sheared = m.mapped([&](const Vec3& p) -> Vec3 { return {p[0] + p[2], p[1], 0.7 * p[2]}; });
  EXPECT_EQ(evaluate(s, sheared, options).active_nodes, 0);
}

TEST(SelfTriggering, a_thin_serpentine_touches_exactly_across_its_folds) {
  const double run = 5 * mm;
  for (double clearance : {0.5 * mm, 0.1 * mm}) {
    const double period = run + pi * 0.5 * (1 * mm + clearance);
    const TetMesh m = leaflet(std::floor((4 * period - 2 * mm) / (0.5 * mm)) * 0.5 * mm, 4 * mm);
    const auto s = extract_contact_surface(m.x, m.tets, 1, m.side, ContactFaces::both);
    const auto x = serpentine(m, run, clearance);
    ContactOptions options;
    options.threshold = 0.2 * mm;
    std::vector<double> gap;
    const auto result = evaluate(s, x, options, &gap);
    if (clearance > options.threshold) {
      EXPECT_EQ(result.active_nodes, 0);
      continue;
    }
    // The bends are polygons: in the crease, which contact sees down to two edges along the face, chords come nearer than the arcs.
    EXPECT_GT(result.min_gap, 0.5 * clearance);
    EXPECT_LT(result.min_gap, 1.1 * clearance);
    int should = 0;
    for (int n = 0; n < s.node_count(); ++n) {
      const Vec3 rest = s.reference[n];
      const int k = static_cast<int>(std::floor(rest[0] / period));
      const double along = rest[0] - k * period;
      const bool top = rest[2] > 0.99 * mm, bottom = rest[2] < 0.01 * mm;
      const bool up = k % 2 == 0 ? top : bottom;
      // Well inside a run, and not next to the fold's inner side where the pair is a neighbour along the solid.
      const bool interior = along > 1.5 * mm && along < run - 1.5 * mm && rest[1] > 0.1 * mm && rest[1] < 3.9 * mm;
      if (!interior || !(top || bottom)) continue;
      const bool has_opposite = up ? k < 3 : k > 0;
      const bool last = k == 3 || (k == 2 && up);
      if (last) continue;  // the last run is shorter
      if (has_opposite) {
        EXPECT_NEAR(gap[n], clearance, 1e-9) << "node at " << rest.transpose();
        ++should;
      } else {
        EXPECT_GE(gap[n], options.threshold);
      }
    }
    EXPECT_GT(should, 50);
    // Only the faces across a clearance are active: at most the facing faces of three clearances.
    EXPECT_LT(result.contact_area, 3 * (run + 1 * mm) * 4 * mm);
    EXPECT_GT(result.contact_area, 2 * (run - 3 * mm) * 4 * mm);
  }
}

TEST(SelfTriggering, a_leaflet_pressed_flat_between_two_others_feels_both_and_nothing_through_itself) {
  // Three separate leaflets stacked: the outer ones must not see each other through the middle one, even with a threshold above
  // its thickness.
  TetMesh stack;
  const TetMesh one = leaflet(5 * mm, 5 * mm);
  for (int k = 0; k < 3; ++k) {
    const int offset = static_cast<int>(stack.x.size() / 3);
    for (std::size_t n = 0; n < one.side.size(); ++n) {
      const Vec3 p = one.point(static_cast<int>(n)) + Vec3(0, 0, k * 1.1 * mm);
      stack.x.insert(stack.x.end(), {p[0], p[1], p[2]});
      stack.side.push_back(one.side[n]);
    }
    for (auto t : one.tets) {
      for (int c = 0; c < 4; ++c) t[c] += offset;
      stack.tets.push_back(t);
    }
  }
  const auto s = extract_contact_surface(stack.x, stack.tets, 1, stack.side, ContactFaces::both);
  for (double threshold : {0.2 * mm, 1.3 * mm}) {
    ContactOptions options;
    options.threshold = threshold;
    options.stiffness = 1e8;
    const auto result = evaluate(s, stack.x, options);
    const double expected = 2 * 1e8 * (threshold - 0.1 * mm) * 25 * mm * mm;  // two interfaces
    EXPECT_NEAR(result.min_gap, 0.1 * mm, 1e-12);
    EXPECT_NEAR(result.normal_force, expected, 1e-9 * expected);
  }
}

}  // namespace
}  // namespace mv::test
