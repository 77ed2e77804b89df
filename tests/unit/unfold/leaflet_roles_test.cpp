// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/unfold/leaflet_roles.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "geometry/core/errors.h"

namespace {

using mv::Vec2;

/// Circle; leaflet `first` over [begin, end) degrees, with the heights of both and notches at the commissures.
mv::Outline outline(double begin, double end, double height_inside, double height_outside, bool labelled) {
  mv::Outline o;
  o.period = 360;
  for (int i = 0; i < 360; ++i) {
    const double u = i + 0.5, angle = u * std::numbers::pi / 180;
    const bool inside = u >= begin && u < end;
    const double width = inside ? end - begin : 360 - (end - begin);
    const double along = inside ? u - begin : std::fmod(u - end + 360, 360);
    o.height.push_back(5 + (inside ? height_inside - 5 : height_outside - 5) * std::sin(std::numbers::pi * along / width));
    o.direction.push_back({std::cos(angle), std::sin(angle)});
    const double label = labelled ? (inside ? 10.0 : -10.0) : 0.0;
    for (auto* list : {&o.label_all, &o.label_annulus, &o.label_free_edge}) list->push_back(label);
    o.labelled_area += std::abs(label);
  }
  return o;
}

Vec2 towards(double degrees) { return {std::cos(degrees * std::numbers::pi / 180), std::sin(degrees * std::numbers::pi / 180)}; }

TEST(LeafletRoles, minima_are_found_across_the_seam_and_by_prominence) {
  std::vector<double> v;
  for (int i = 0; i < 100; ++i) v.push_back(std::cos(2 * std::numbers::pi * 3 * (i - 1) / 100.0) + 0.01 * ((i * 7) % 3));
  const auto all = mv::periodic_minima(v, 0.5);
  EXPECT_EQ(all.size(), 3u);
  EXPECT_TRUE(mv::periodic_minima(std::vector<double>(50, 1.0), 0.1).empty());
  std::vector<double> seam(60, 1.0);
  seam[0] = 0;
  EXPECT_EQ(mv::periodic_minima(seam, 0.5), std::vector<int>{0});
}

TEST(LeafletRoles, outline_alone_finds_the_longer_leaflet_on_less_of_the_annulus) {
  std::vector<std::string> notes;
  const mv::Commissures c = mv::find_commissures(outline(40, 165, 24, 15, false), {}, false, false, {}, notes);
  EXPECT_NEAR(c.annulus_begin, 40, 1.5) << c.rule;
  EXPECT_NEAR(c.annulus_end, 165, 1.5);
  EXPECT_NEAR(c.free_edge_begin, 40, 1.5);
}

TEST(LeafletRoles, labels_across_the_seam_give_the_same_commissures) {
  std::vector<std::string> notes;
  mv::Outline o = outline(40, 165, 24, 15, true);
  for (auto* list : {&o.height, &o.label_all, &o.label_annulus, &o.label_free_edge}) std::rotate(list->begin(), list->begin() + 100, list->end());
  std::rotate(o.direction.begin(), o.direction.begin() + 100, o.direction.end());
  const mv::Commissures c = mv::find_commissures(o, {}, true, true, {}, notes);
  EXPECT_NEAR(c.annulus_begin, 300, 1.5) << c.rule;
  EXPECT_NEAR(c.annulus_end, 65, 1.5);
  EXPECT_TRUE(notes.empty()) << notes.front();
}

TEST(LeafletRoles, unanimous_evidence_swaps_labels_and_divided_evidence_is_an_error) {
  mv::Outline o = outline(40, 165, 24, 15, true);
  for (auto* list : {&o.label_all, &o.label_annulus, &o.label_free_edge})
    for (double& x : *list) x = -x;
  std::vector<std::string> notes;
  const mv::Commissures c = mv::find_commissures(o, {}, true, true, {}, notes);
  EXPECT_NEAR(c.annulus_begin, 40, 1.5);
  ASSERT_FALSE(notes.empty());
  EXPECT_NE(notes.front().find("swapped"), std::string::npos);

  // The same height, share a little below half: the hint stands alone against the labels, one shape rule for them.
  mv::AnteriorEvidence against;
  against.hint = towards(282);
  EXPECT_THROW(mv::find_commissures(outline(40, 165, 15, 15, true), {}, true, true, against, notes), mv::InputError);
}

TEST(LeafletRoles, nothing_to_go_by_is_an_error) {
  std::vector<std::string> notes;
  mv::Outline flat = outline(0, 180, 5, 5, false);
  EXPECT_THROW(mv::find_commissures(flat, {}, false, false, {}, notes), mv::InputError);
  mv::Outline even = outline(0, 180, 15, 15, false);
  EXPECT_THROW(mv::find_commissures(even, {}, false, false, {}, notes), mv::InputError);
  mv::AnteriorEvidence hint;
  hint.hint = towards(90);
  const mv::Commissures c = mv::find_commissures(flat, {}, false, false, hint, notes);
  EXPECT_NEAR(0.5 * (c.annulus_begin + c.annulus_end), 90, 1) << c.rule;
}

TEST(LeafletRoles, scrambled_labels_are_refused) {
  mv::Outline o = outline(40, 165, 24, 15, true);
  for (int i = 0; i < 360; ++i)
    for (auto* list : {&o.label_all, &o.label_annulus, &o.label_free_edge}) (*list)[static_cast<std::size_t>(i)] = (i / 20) % 2 ? 10 : -10;
  std::vector<std::string> notes;
  EXPECT_THROW(mv::find_commissures(o, {}, true, true, {}, notes), mv::InputError);
}

}  // namespace
