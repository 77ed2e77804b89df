// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cstdio>
#include <limits>
#include <map>

#include "geometry/core/errors.h"
#include "geometry/surface/repair.h"
#include "tests/unit/surface/solid_shapes.h"

namespace {

using namespace solid_shapes;
using mv::RawSurface;
using mv::RepairedSurface;
using mv::SurfaceKind;

constexpr double pi = M_PI;

mv::SolidSurface ring() { return solid_of(cone(16, 12, 10, 1.5, 1.5), 48, 8, 2); }
RawSurface raw_of(const mv::SolidSurface& s) { return {s.points, s.triangles, {}, {}, {}}; }

double volume_of(const RepairedSurface& s) {
  double six = 0;
  for (const auto& t : s.triangles) {
    const auto p = [&](std::size_t k) { return s.points[static_cast<std::size_t>(t[k])]; };
    six += p(0).dot(p(1).cross(p(2)));
  }
  return six / 6;
}

/// Edges that have not exactly one triangle on either side.
long loose_edges(const std::vector<std::array<int, 3>>& triangles) {
  std::map<std::pair<int, int>, int> uses;
  for (const auto& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) ++uses[{t[k], t[(k + 1) % 3]}];
  long loose = 0;
  for (const auto& [edge, n] : uses) {
    const auto other = uses.find({edge.second, edge.first});
    loose += n != 1 || other == uses.end() || other->second != 1;
  }
  return loose;
}

RepairedSurface repaired(const char* name, const RawSurface& raw, const mv::RepairOptions& options = {}) {
  const RepairedSurface r = mv::repair_surface(raw, options);
  std::printf("%s: %s, %zu triangles, %ld loose edges, volume %.2f mm3, %d parts, %ld intersections\n", name, std::string(to_string(r.kind)).c_str(),
              r.triangles.size(), loose_edges(r.triangles), volume_of(r), r.parts, r.self_intersections);
  for (const auto& line : r.report) std::printf("  %s\n", line.c_str());
  return r;
}

bool tells(const RepairedSurface& r, const std::string& words) {
  for (const auto& line : r.report)
    if (line.find(words) != std::string::npos) return true;
  return false;
}

std::string refusal(const RawSurface& raw, const mv::RepairOptions& options = {}) {
  try {
    mv::repair_surface(raw, options);
  } catch (const mv::InputError& e) {
    std::printf("%s\n", e.what());
    return e.what();
  }
  return "accepted";
}

TEST(Repair, a_sound_surface_is_left_alone) {
  const auto r = repaired("sound", raw_of(ring()));
  EXPECT_TRUE(r.report.empty());
  EXPECT_EQ(r.kind, SurfaceKind::thick);
  EXPECT_EQ(r.triangles.size(), ring().triangles.size());
  EXPECT_GT(volume_of(r), 0);
}

TEST(Repair, soup_duplicates_and_flips_come_back_to_the_same_volume) {
  const auto whole = repaired("whole", raw_of(ring()));
  RawSurface soup;  // own corners a triangle, every third turned over, ten twice, five flat
  const auto s = ring();
  for (std::size_t t = 0; t < s.triangles.size(); ++t) {
    const int n = static_cast<int>(soup.points.size());
    for (int v : s.triangles[t]) soup.points.push_back(s.points[static_cast<std::size_t>(v)]);
    if (t % 3 == 0) soup.triangles.push_back({n, n + 2, n + 1});
    else soup.triangles.push_back({n, n + 1, n + 2});
    if (t < 10) soup.triangles.push_back({n, n + 1, n + 2});
    if (t < 5) soup.triangles.push_back({n, n + 1, n});
  }
  const auto r = repaired("soup", soup);
  EXPECT_EQ(r.points.size(), s.points.size());
  EXPECT_EQ(r.triangles.size(), s.triangles.size());
  EXPECT_EQ(loose_edges(r.triangles), 0);
  EXPECT_NEAR(volume_of(r), volume_of(whole), 1e-9 * volume_of(whole));
  EXPECT_TRUE(tells(r, "10 duplicated triangles"));
  EXPECT_TRUE(tells(r, "5 degenerate triangles removed"));
  EXPECT_TRUE(tells(r, "duplicated points joined"));
  EXPECT_TRUE(tells(r, "turned over"));
}

TEST(Repair, inside_out_is_turned) {
  auto s = raw_of(ring());
  for (auto& t : s.triangles) std::swap(t[0], t[1]);
  const auto r = repaired("inside out", s);
  EXPECT_GT(volume_of(r), 0);
  EXPECT_TRUE(tells(r, "face outwards"));
}

TEST(Repair, small_hole_is_filled_and_large_one_refused) {
  const auto whole = repaired("whole", raw_of(ring()));
  auto s = raw_of(ring());
  s.triangles.erase(s.triangles.begin() + 100, s.triangles.begin() + 102);
  const auto r = repaired("hole", s);
  EXPECT_EQ(loose_edges(r.triangles), 0);
  EXPECT_NEAR(volume_of(r), volume_of(whole), 1e-3 * volume_of(whole));
  EXPECT_TRUE(tells(r, "1 holes filled"));
  auto open = raw_of(ring());
  std::erase_if(open.triangles, [&](const auto& t) {
    const Vec3 m = (open.points[static_cast<std::size_t>(t[0])] + open.points[static_cast<std::size_t>(t[1])] + open.points[static_cast<std::size_t>(t[2])]) / 3;
    return m.x() > 11 && m.head<2>().norm() > 12;
  });
  mv::RepairOptions thick;
  thick.kind = SurfaceKind::thick;
  EXPECT_NE(refusal(open, thick).find("double_wall"), std::string::npos);
}

TEST(Repair, specks_are_dropped_and_told) {
  auto s = ring();
  auto speck = solid_of(cylinder_leaflet(0.5, 0.1, 0, 1, 0.3), 3, 3, 1);
  for (Vec3& p : speck.points) p.z() += 20;
  append(s, speck);
  const auto r = repaired("speck", raw_of(s));
  EXPECT_EQ(r.parts, 1);
  EXPECT_EQ(r.triangles.size(), ring().triangles.size());
  EXPECT_TRUE(tells(r, "1 of 2 parts dropped"));
}

TEST(Repair, one_sided_surfaces_are_refused) {
  RawSurface moebius, klein;
  const int n = 40, m = 6;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j <= m; ++j) {
      const double a = 2 * pi * i / n, w = 4.0 * j / m - 2;
      moebius.points.emplace_back((15 + w * std::cos(a / 2)) * std::cos(a), (15 + w * std::cos(a / 2)) * std::sin(a), w * std::sin(a / 2));
    }
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < m; ++j) {
      const auto id = [&](int k, int l) { return k < n ? k * (m + 1) + l : m - l; };
      moebius.triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      moebius.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  const int k = 20;  // figure-eight immersion
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < k; ++j) {
      const double a = 2 * pi * i / n, v = 2 * pi * (j + 0.37) / k;
      const double r = 15 + 4 * (std::cos(a / 2) * std::sin(v) - std::sin(a / 2) * std::sin(2 * v));
      klein.points.emplace_back(r * std::cos(a), r * std::sin(a), 4 * (std::sin(a / 2) * std::sin(v) + std::cos(a / 2) * std::sin(2 * v)));
    }
  // After one turn v becomes -v up to the offset of the rows: 2 (j + 0.37) / k has no partner row, so rows join at -j - 1.
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < k; ++j) {
      const auto id = [&](int c, int l) { return c < n ? c * k + (l % k) : ((2 * k - 1 - l) % k); };
      klein.triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      klein.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  EXPECT_NE(refusal(moebius).find("no two sides"), std::string::npos);
  EXPECT_NE(refusal(klein).find("no two sides"), std::string::npos);
}

TEST(Repair, points_that_are_no_numbers_or_nothing_are_refused) {
  auto s = raw_of(ring());
  s.points[7].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(refusal(s).find("point 7 is not finite"), std::string::npos);
  EXPECT_NE(refusal(RawSurface{{Vec3(1, 1, 1), Vec3(1, 1, 1), Vec3(1, 1, 1)}, {{0, 1, 2}}, {}, {}, {}}).find("no size"), std::string::npos);
}

TEST(Repair, double_wall_is_closed_along_the_annulus_and_mid_left_open) {
  const auto whole = repaired("whole", raw_of(ring()));
  auto walls = raw_of(ring());
  std::erase_if(walls.triangles, [&](const auto& t) {  // the rim across the thickness at the annulus
    for (int v : t)
      if (walls.points[static_cast<std::size_t>(v)].z() < -0.6) return false;
    return true;
  });
  const auto closed = repaired("double wall", walls);
  EXPECT_EQ(closed.kind, SurfaceKind::double_wall);
  EXPECT_EQ(loose_edges(closed.triangles), 0);
  EXPECT_NEAR(volume_of(closed), volume_of(whole), 0.01 * volume_of(whole));

  RawSurface mid;
  const auto c = cone(16, 12, 10, 1, 1);
  for (int i = 0; i < 48; ++i)
    for (int j = 0; j <= 8; ++j) mid.points.push_back(c.middle(i / 48.0, j / 8.0));
  for (int i = 0; i < 48; ++i)
    for (int j = 0; j < 8; ++j) {
      const auto id = [&](int a, int b) { return (a % 48) * 9 + b; };
      mid.triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      mid.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  const auto open = repaired("mid", mid);
  EXPECT_EQ(open.kind, SurfaceKind::mid);
  EXPECT_EQ(open.triangles.size(), mid.triangles.size());
}

}  // namespace
