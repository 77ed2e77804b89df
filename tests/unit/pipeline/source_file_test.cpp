// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/source_file.h"

#include <gtest/gtest.h>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "unit/core/sample_case.h"

using mv_test::TemporaryDirectory;

namespace {

mv::SourceGeometry sample_source() {
  mv::SourceGeometry source;
  source.surface.points = {{0, 0, 0}, {1, 0, 0.1}, {0, 1, 0.2}, {1, 1, 1.0 / 3}};
  source.surface.triangles = {{0, 1, 2}, {1, 3, 2}};
  source.surface.normals.assign(4, mv::Vec3(0, 0.6, 0.8));
  source.surface.unfolded = {{0, 0}, {1, 0}, {0, 1}, {1, 1.7}};
  source.surface.on_annulus = {1, 1, 0, 0};
  source.surface.on_free_edge = {0, 0, 1, 1};
  source.surface.region = {1, 2};
  source.surface.perimeter = 107.2;
  source.surface.axis = {0, 0, -1};
  source.annulus_curve = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9.5}};
  source.anterior_direction = {0, 1, 0};
  source.scale = 1.125;
  return source;
}

}  // namespace

TEST(SourceFile, comes_back_to_the_last_bit) {
  const TemporaryDirectory dir;
  const auto a = sample_source();
  mv::write_source(dir / "mid_surface.vtp", a);
  const auto b = mv::read_source(dir / "mid_surface.vtp");
  EXPECT_EQ(a.surface.points, b.surface.points);
  EXPECT_EQ(a.surface.triangles, b.surface.triangles);
  EXPECT_EQ(a.surface.normals, b.surface.normals);
  EXPECT_EQ(a.surface.unfolded, b.surface.unfolded);
  EXPECT_EQ(a.surface.on_annulus, b.surface.on_annulus);
  EXPECT_EQ(a.surface.on_free_edge, b.surface.on_free_edge);
  EXPECT_EQ(a.surface.region, b.surface.region);
  EXPECT_EQ(a.surface.perimeter, b.surface.perimeter);
  EXPECT_EQ(a.surface.axis, b.surface.axis);
  EXPECT_EQ(a.annulus_curve, b.annulus_curve);
  EXPECT_EQ(a.anterior_direction, b.anterior_direction);
  EXPECT_EQ(a.scale, b.scale);
}

TEST(SourceFile, thickness_comes_back_and_is_absent_where_there_is_none) {
  const TemporaryDirectory dir;
  auto a = sample_source();
  mv::write_source(dir / "uniform.vtp", a);
  EXPECT_TRUE(mv::read_source(dir / "uniform.vtp").surface.thickness.empty());
  EXPECT_EQ(mv::read_file(dir / "uniform.vtp").find("thickness"), std::string::npos);
  a.surface.thickness = {0.5, 1.0 / 3, 1.25, 2};
  mv::write_source(dir / "field.vtp", a);
  EXPECT_EQ(mv::read_source(dir / "field.vtp").surface.thickness, a.surface.thickness);
}

TEST(SourceFile, damage_is_refused) {
  const TemporaryDirectory dir;
  mv::write_source(dir / "mid_surface.vtp", sample_source());
  std::string bytes = mv::read_file(dir / "mid_surface.vtp");
  bytes[bytes.size() / 2] ^= 1;
  mv::write_text_atomically(dir / "mid_surface.vtp", bytes);
  EXPECT_THROW(mv::read_source(dir / "mid_surface.vtp"), mv::InputError);
  EXPECT_THROW(mv::read_source(dir / "none.vtp"), mv::IoError);
}
