// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Pictures without an X server or a graphics card: a z-buffer rasteriser with deferred shading and supersampling.

#include <array>
#include <span>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

/// Colour with components in [0, 1], as displayed (sRGB).
using Rgb = Eigen::Vector3f;

/// 8-bit RGB, rows from the top.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<unsigned char> rgb;

  static Image filled(int width, int height, const Rgb& colour);
  std::array<unsigned char, 3> at(int x, int y) const;
};

/// Copies `source` into `target` with its top left corner at (x, y); what falls outside is cut off.
void paste(Image& target, const Image& source, int x, int y);

/// `direction` points from the eye into the scene; `centre` appears in the middle of the picture, and half_height (mm) above it
/// the picture ends. eye_distance > 0 (mm, eye to centre) gives a perspective view with that scale at `centre`; 0 an orthographic
/// one.
struct Camera {
  Vec3 centre = Vec3::Zero();
  Vec3 direction = -Vec3::UnitZ();
  Vec3 up = Vec3::UnitY();
  double half_height = 1;
  double eye_distance = 0;
};

/// Triangles with a colour per point. Corner normals are those of the surrounding faces within the crease angle, so that the rim
/// of a leaflet stays sharp. Both sides are lit.
struct ColouredMesh {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;
  std::vector<Rgb> colours;  // per point
  bool is_lit = true;        // false: drawn in its plain colour
  // A second coat, per point or empty: shown instead of `colours` where the interpolated cover (0 or 1 at points) is at least one
  // half.
  std::vector<Rgb> coat;
  std::vector<float> cover;
};

/// Appends b to a; neither may have a second coat.
void append(ColouredMesh& a, const ColouredMesh& b);

/// Tube around a polyline (joints rounded by spheres), sphere, and flat thick polyline in the plane z = const (for drawings).
ColouredMesh make_tube(std::span<const Vec3> line, double radius, const Rgb& colour, bool is_closed = false);
ColouredMesh make_sphere(const Vec3& centre, double radius, const Rgb& colour);
ColouredMesh make_stroke(std::span<const Vec2> line, double width, double z, const Rgb& colour, bool is_closed = false);

/// The part of `mesh` on the side of the plane the normal points to; cut triangles are split.
ColouredMesh clip(const ColouredMesh& mesh, const Vec3& origin, const Vec3& normal);

/// Effects that make shape readable; lengths in mm of the scene.
struct Finish {
  double valley_radius = 2.5;    // surroundings a pixel's depth is compared with
  double valley_strength = 0.5;  // 0: off
  double outline_step = 0.8;     // depth step that draws a dark line; 0: off
};

class Canvas {
 public:
  Canvas(int width, int height, const Camera& camera, const Rgb& background = Rgb(1, 1, 1), int supersampling = 3);

  void draw(const ColouredMesh& mesh);

  /// Lettering and bars over everything else, in plain colours: points are (x to the right, y upwards) mm from the picture's
  /// middle at the scale of `centre`; z is ignored, later triangles cover earlier ones.
  void draw_over(const ColouredMesh& mesh);
  double half_width() const;  // mm

  /// Shades what was drawn and averages the samples of each pixel.
  Image image(const Finish& finish = {}) const;

 private:
  struct Projected {
    float x, y, depth;
  };
  struct Corner {
    Projected at;
    Eigen::Vector3f normal;
    Rgb colour, coat;
    float cover;
  };
  static Corner make_corner(const ColouredMesh& mesh, std::size_t point, const Projected& at, const Eigen::Vector3f& normal);
  Projected project(const Vec3& point) const;
  static constexpr float overlay_depth_ = -1e30f;  // nearer than anything in a scene
  static bool is_overlay(float depth) { return depth < 0.5f * overlay_depth_; }
  void draw_triangle(const std::array<Corner, 3>& corners);

  int width_, height_, samples_;  // picture size; samples per pixel and direction
  Rgb background_;
  Camera camera_;
  Mat3 view_;                            // rows: right, up, direction
  double scale_;                         // samples per mm at the centre
  std::vector<float> depth_;             // mm beyond the centre, infinite where nothing was drawn
  std::vector<Eigen::Vector3f> normal_;  // camera frame; zero where unlit
  std::vector<Rgb> colour_;
};

}  // namespace mv
