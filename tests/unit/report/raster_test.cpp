// SPDX-License-Identifier: BSD-3-Clause
#include "solver/report/raster.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "solver/report/colours.h"
#include "solver/report/stroke_font.h"

using namespace mv;

namespace {

const Rgb red(1, 0, 0), blue(0, 0, 1), white(1, 1, 1);
const Finish plain{.valley_radius = 1, .valley_strength = 0, .outline_step = 0};

/// 100 x 100 pixels over x, y in [-5, 5] mm, looking down z.
Camera top_view() {
  Camera camera;
  camera.half_height = 5;
  return camera;
}

ColouredMesh triangle(const Vec3& a, const Vec3& b, const Vec3& c, const Rgb& colour) {
  ColouredMesh mesh;
  mesh.points = {a, b, c};
  mesh.triangles = {{0, 1, 2}};
  mesh.colours.assign(3, colour);
  mesh.is_lit = false;
  return mesh;
}

using Pixel = std::array<unsigned char, 3>;
constexpr Pixel red_pixel{255, 0, 0}, blue_pixel{0, 0, 255}, white_pixel{255, 255, 255};

/// Pixels covered on white by a colour without green, partly covered ones by their share.
double covered_pixels(const Image& image) {
  double sum = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) sum += 1 - image.at(x, y)[1] / 255.0;
  return sum;
}

int count(const Image& image, const Pixel& colour) {
  int n = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) n += image.at(x, y) == colour ? 1 : 0;
  return n;
}

TEST(Raster, a_triangle_lies_where_it_should_and_covers_its_area) {
  Canvas canvas(100, 100, top_view());
  canvas.draw(triangle({-4, -4, 0}, {4, -4, 0}, {-4, 4, 0}, red));
  const Image image = canvas.image(plain);
  EXPECT_EQ(image.at(12, 87), red_pixel);    // x = -3.8, y = -3.8: the lower left corner
  EXPECT_EQ(image.at(50, 49), white_pixel);  // just beyond the slanted side
  EXPECT_EQ(image.at(48, 52), red_pixel);
  EXPECT_EQ(image.at(5, 50), white_pixel);
  EXPECT_NEAR(covered_pixels(image), 3200, 32);  // 32 mm2 at 100 pixels a mm2
}

TEST(Raster, the_nearer_surface_wins_whatever_the_order) {
  const ColouredMesh low = triangle({-4, -4, 0}, {4, -4, 0}, {0, 4, 0}, red),
                     high = triangle({-4, -4, 1}, {4, -4, 1}, {0, 4, 1}, blue);
  for (bool is_low_first : {true, false}) {
    Canvas canvas(100, 100, top_view());
    canvas.draw(is_low_first ? low : high);
    canvas.draw(is_low_first ? high : low);
    const Image image = canvas.image(plain);
    EXPECT_GT(count(image, blue_pixel), 2500);
    EXPECT_EQ(count(image, red_pixel), 0);
  }
}

TEST(Raster, surfaces_that_cross_show_their_line_of_intersection) {
  Canvas canvas(100, 100, top_view());
  ColouredMesh flat = triangle({-40, -40, 0}, {40, -40, 0}, {0, 40, 0}, red);
  canvas.draw(flat);
  canvas.draw(triangle({-40, -40, -40}, {40, -40, 40}, {0, 40, 0}, blue));  // z = x
  const Image image = canvas.image(plain);
  EXPECT_EQ(image.at(20, 50), red_pixel);
  EXPECT_EQ(image.at(80, 50), blue_pixel);
}

TEST(Raster, camera_turns_up_and_direction_into_picture_axes) {
  Camera camera = top_view();
  camera.direction = Vec3(1, 0, 0);
  camera.up = Vec3(0, 0, 1);  // to the right: x cross z = -y
  Canvas canvas(100, 100, camera);
  canvas.draw(triangle({0, -4, 2}, {0, -2, 2}, {0, -3, 4}, red));
  const Image image = canvas.image(plain);
  EXPECT_EQ(image.at(80, 25), red_pixel);
  EXPECT_EQ(image.at(20, 25), white_pixel);
  EXPECT_EQ(image.at(80, 75), white_pixel);
}

TEST(Raster, perspective_keeps_the_scale_at_the_centre_and_shrinks_what_is_far) {
  const auto covered = [](double z) {
    Camera camera = top_view();
    camera.eye_distance = 20;
    Canvas canvas(100, 100, camera);
    ColouredMesh square = triangle({-2, -2, z}, {2, -2, z}, {2, 2, z}, red);
    append(square, triangle({-2, -2, z}, {2, 2, z}, {-2, 2, z}, red));
    canvas.draw(square);
    return covered_pixels(canvas.image(plain));
  };
  EXPECT_NEAR(covered(0), 1600, 16);
  EXPECT_NEAR(covered(-20), 400, 8);  // twice as far from the eye
}

TEST(Raster, light_falls_on_both_sides_and_edges_beyond_the_crease_stay_sharp) {
  ColouredMesh roof;
  roof.points = {{-4, -4, 0}, {0, -4, 4}, {0, 4, 4}, {-4, 4, 0}, {4, -4, 0}, {4, 4, 0}};
  roof.triangles = {{0, 1, 2}, {0, 2, 3}, {1, 4, 5}, {1, 5, 2}};
  roof.colours.assign(6, Rgb(0.6f, 0.6f, 0.6f));
  Canvas canvas(100, 100, top_view());
  canvas.draw(roof);
  const Image image = canvas.image(plain);
  EXPECT_EQ(image.at(20, 50), image.at(45, 50));  // one flat side, one shade
  EXPECT_NE(image.at(45, 50), image.at(55, 50));  // the other side faces another way
  for (auto& t : roof.triangles) std::swap(t[0], t[1]);
  Canvas turned(100, 100, top_view());
  turned.draw(roof);
  EXPECT_EQ(turned.image(plain).rgb, image.rgb);
}

TEST(Raster, clipping_keeps_the_side_of_the_normal) {
  ColouredMesh mesh = triangle({-4, -4, 0}, {4, -4, 0}, {0, 4, 0}, red);
  const ColouredMesh half = clip(mesh, Vec3::Zero(), Vec3::UnitX());
  double area = 0;
  for (const auto& t : half.triangles) {
    const auto x = [&](std::size_t k) -> const Vec3& { return half.points[static_cast<std::size_t>(t[k])]; };
    area += (x(1) - x(0)).cross(x(2) - x(0)).norm() / 2;
    for (std::size_t k = 0; k < 3; ++k) EXPECT_GE(x(k).x(), -1e-12);
  }
  EXPECT_NEAR(area, 16, 1e-12);
  EXPECT_EQ(clip(mesh, Vec3(5, 0, 0), Vec3::UnitX()).triangles.size(), 0u);
}

TEST(Raster, a_second_coat_ends_half_way_to_points_without_it) {
  ColouredMesh mesh = triangle({-4, -4, 0}, {4, -4, 0}, {4, 40, 0}, red);
  mesh.coat.assign(3, blue);
  mesh.cover = {0, 1, 1};  // cover = (x + 4) / 8
  Canvas canvas(100, 100, top_view());
  canvas.draw(mesh);
  const Image image = canvas.image(plain);
  EXPECT_EQ(image.at(46, 80), red_pixel);
  EXPECT_EQ(image.at(54, 80), blue_pixel);
}

TEST(Raster, overlays_cover_everything_and_do_not_move_with_the_camera) {
  Camera camera = top_view();
  camera.centre = Vec3(100, 0, 0);
  Canvas canvas(100, 100, camera);
  canvas.draw(triangle({96, -4, 50}, {104, -4, 50}, {100, 4, 50}, red));
  canvas.draw_over(triangle({-1, -1, 0}, {1, -1, 0}, {0, 1, 0}, blue));
  EXPECT_EQ(canvas.image(plain).at(50, 52), blue_pixel);
}

TEST(Raster, valleys_get_less_light_and_steps_a_line) {
  // a plate with a deep narrow groove along y
  ColouredMesh plate;
  for (double x : {-5.0, -0.5, 0.5, 5.0})
    for (double y : {-6.0, 6.0}) plate.points.emplace_back(x, y, 0);
  plate.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 6, 5}, {5, 6, 7}};
  ColouredMesh floor = triangle({-1, -60, -3}, {1, -60, -3}, {0, 6000, -3}, Rgb(0.6f, 0.6f, 0.6f));
  floor.is_lit = true;
  plate.colours.assign(8, Rgb(0.6f, 0.6f, 0.6f));
  Canvas canvas(100, 100, top_view());
  canvas.draw(plate);
  canvas.draw(floor);
  Finish valleys = plain;
  valleys.valley_strength = 0.5;
  valleys.valley_radius = 2;
  EXPECT_LT(canvas.image(valleys).at(50, 50)[0], canvas.image(plain).at(50, 50)[0]);
  EXPECT_EQ(canvas.image(plain).at(20, 50), canvas.image(plain).at(50, 50));
  Finish lines = plain;
  lines.outline_step = 1;
  EXPECT_LT(canvas.image(lines).at(44, 50)[0], canvas.image(plain).at(44, 50)[0] - 15);  // one sample of three is ink
  EXPECT_EQ(canvas.image(lines).at(20, 50), canvas.image(plain).at(20, 50));
}

TEST(Raster, tubes_and_spheres_are_closed_and_of_their_radius) {
  const ColouredMesh sphere = make_sphere({1, 2, 3}, 2, red);
  for (const Vec3& p : sphere.points) EXPECT_NEAR((p - Vec3(1, 2, 3)).norm(), 2, 1e-12);
  const std::array<Vec3, 2> line{Vec3(-3, 0, 0), Vec3(3, 0, 0)};
  Canvas canvas(100, 100, top_view());
  ColouredMesh tube = make_tube(line, 1, red);
  tube.is_lit = false;
  canvas.draw(tube);
  // cylinder and its two round ends; the ten-sided prism may be narrower by cos(18 degrees)
  EXPECT_LT(covered_pixels(canvas.image(plain)), 1200 + 315);
  EXPECT_GT(covered_pixels(canvas.image(plain)), (1200 + 314) * std::cos(0.32));
  EXPECT_TRUE(make_tube({}, 1, red).triangles.empty());
}

TEST(Raster, paste_cuts_what_falls_outside) {
  Image target = Image::filled(4, 4, white);
  paste(target, Image::filled(3, 3, red), 2, -1);
  EXPECT_EQ(count(target, red_pixel), 4);
  EXPECT_EQ(target.at(2, 0), red_pixel);
  EXPECT_EQ(target.at(1, 0), white_pixel);
}

TEST(StrokeFont, knows_what_the_pictures_write_and_measures_it) {
  for (char c : std::string("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789.,:;-+/()%=<>"))
    EXPECT_FALSE(text_strokes(std::string(1, c), Vec2::Zero(), 7).empty()) << c;
  EXPECT_TRUE(text_strokes(" ", Vec2::Zero(), 7).empty());
  EXPECT_NEAR(text_width("II", 14), 2 * text_width("II", 7), 1e-12);
  EXPECT_GT(text_width("A1 A2", 7), text_width("A1A2", 7));
  for (const auto& stroke : text_strokes("Hxg", Vec2(10, 20), 7))
    for (const Vec2& p : stroke) {
      EXPECT_GE(p.x(), 10);
      EXPECT_LE(p.y(), 27);
      EXPECT_GE(p.y(), 18);
    }
}

TEST(Colours, maps_grow_lighter_all_the_way) {
  for (std::span<const unsigned> stops : {std::span<const unsigned>(viridis_stops), std::span<const unsigned>(cividis_stops)}) {
    float before = -1;
    for (int i = 0; i <= 100; ++i) {
      const Rgb c = map_colour(stops, i / 100.0);
      const float lightness = 0.2126f * c[0] + 0.7152f * c[1] + 0.0722f * c[2];
      EXPECT_GT(lightness, before);
      before = lightness;
    }
  }
  EXPECT_EQ(map_colour(viridis_stops, -1), rgb(0x440154));
  EXPECT_EQ(map_colour(viridis_stops, 2), rgb(0xfde725));
}

}  // namespace
