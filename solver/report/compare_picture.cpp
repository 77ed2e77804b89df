// SPDX-License-Identifier: BSD-3-Clause
// Computed valve, reference and their distance, side by side.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "geometry/core/leaflet_names.h"
#include "solver/report/colours.h"
#include "solver/report/compare_reference.h"
#include "solver/report/stroke_font.h"

namespace mv {
namespace {

constexpr int panel_width = 620, panel_height = 560;
constexpr double letters = 1.5;        // mm
constexpr double distance_scale = 2;   // mm, upper end of the colour bar
const Rgb septal_colour = rgb(0xcfe0c3), touching_colour = rgb(0x0072b2);

Rgb tint(int region) { return region == anterior ? anterior_colour : region == posterior ? posterior_colour : septal_colour; }

ColouredMesh lettering(const std::string& text, const Vec2& origin, double height) {
  ColouredMesh mesh;
  mesh.is_lit = false;
  for (const auto& stroke : text_strokes(text, origin, height)) append(mesh, make_stroke(stroke, 0.13 * height, 0, ink_colour));
  return mesh;
}

std::vector<Rgb> tints(std::size_t points, const std::vector<std::array<int, 3>>& triangles, const std::vector<int>& region) {
  std::vector<Rgb> colour(points, Rgb::Zero());
  std::vector<float> count(points, 0);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (const int p : triangles[t]) {
      colour[static_cast<std::size_t>(p)] += t < region.size() ? tint(region[t]) : no_contact_colour;
      count[static_cast<std::size_t>(p)] += 1;
    }
  for (std::size_t p = 0; p < points; ++p)
    if (count[p] > 0) colour[p] /= count[p];
  return colour;
}

void cover_contact(ColouredMesh& mesh, const std::vector<char>& in_contact) {
  mesh.coat.assign(mesh.points.size(), touching_colour);
  for (std::size_t p = 0; p < mesh.points.size(); ++p) mesh.cover.push_back(p < in_contact.size() && in_contact[p] ? 1.0f : 0.0f);
}

}  // namespace

Image draw_comparison(const MidNodes& nodes, const ReferenceSurface& reference, const ReferenceComparison& comparison, const Vec3& annulus_normal) {
  ColouredMesh computed{nodes.current, nodes.triangles, tints(nodes.current.size(), nodes.triangles, nodes.region), true, {}, {}};
  ColouredMesh distance = computed;
  cover_contact(computed, nodes.in_contact);
  for (std::size_t p = 0; p < distance.colours.size(); ++p) distance.colours[p] = map_colour(viridis_stops, comparison.distance[p] / distance_scale);
  // With the same nodes the reference is drawn on the computed valve's triangles and in its colours.
  ColouredMesh other;
  if (!comparison.reference_contact.empty()) {
    other = ColouredMesh{{}, nodes.triangles, tints(nodes.current.size(), nodes.triangles, nodes.region), true, {}, {}};
    const std::vector<char> on = reference.is_on_surface();
    for (std::size_t i = 0; i < on.size(); ++i)
      if (on[i]) other.points.push_back(reference.points[i]);
    cover_contact(other, comparison.reference_contact);
  } else {
    other = ColouredMesh{reference.points, reference.triangles, tints(reference.points.size(), reference.triangles, {}), true, {}, {}};
  }
  if (other.points.size() != other.colours.size()) other = ColouredMesh{reference.points, reference.triangles, tints(reference.points.size(), reference.triangles, {}), true, {}, {}};

  const Vec3 up = -annulus_normal.normalized();
  Vec3 lower = Vec3::Constant(1e300), upper = Vec3::Constant(-1e300);
  for (const Vec3& p : nodes.current) lower = lower.cwiseMin(p), upper = upper.cwiseMax(p);
  const Vec3 centre = 0.5 * (lower + upper);
  Vec3 front = Vec3::UnitY() - Vec3::UnitY().dot(up) * up;
  if (front.norm() < 0.1) front = up.unitOrthogonal();
  front.normalize();
  const Vec3 right = front.cross(up);
  double half_width = 0, half_front = 0, half_up = 0;
  for (const Vec3& p : nodes.current) {
    half_width = std::max(half_width, std::abs((p - centre).dot(right)));
    half_front = std::max(half_front, std::abs((p - centre).dot(front)));
    half_up = std::max(half_up, std::abs((p - centre).dot(up)));
  }
  const double aspect = static_cast<double>(panel_width) / panel_height;
  const double half_height = std::max({half_front, half_up, half_width / aspect}) + 3 * letters;

  struct View {
    const char* name;
    Vec3 direction, upwards;
  };
  const View views[] = {{"from the atrium", -up, front}, {"from the side", front, up}, {"from the ventricle", up, front}};
  struct Panel {
    const char* name;
    const ColouredMesh* mesh;
  };
  const Panel panels[] = {{"computed", &computed}, {"reference", &other}, {"distance", &distance}};
  Image sheet = Image::filled(3 * panel_width, 3 * panel_height, Rgb(1, 1, 1));
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) {
      Camera camera{centre, views[row].direction, views[row].upwards, half_height, 300};
      Canvas canvas(panel_width, panel_height, camera);
      canvas.draw(*panels[column].mesh);
      const double left = -canvas.half_width() + 1, bottom = -half_height + 1;
      canvas.draw_over(lettering(fmt::format("{}, {}", panels[column].name, views[row].name), Vec2(left, half_height - 2 * letters), letters));
      if (column == 2) {
        ColouredMesh bar;
        bar.is_lit = false;
        constexpr int parts = 40;
        constexpr double length = 16;
        for (int i = 0; i <= parts; ++i) {
          const double x = left + length * i / parts;
          bar.points.insert(bar.points.end(), {Vec3(x, bottom + 1.8, 0), Vec3(x, bottom + 2.8, 0)});
          bar.colours.insert(bar.colours.end(), 2, map_colour(viridis_stops, static_cast<double>(i) / parts));
          if (i > 0) bar.triangles.insert(bar.triangles.end(), {{2 * i - 2, 2 * i, 2 * i + 1}, {2 * i - 2, 2 * i + 1, 2 * i - 1}});
        }
        canvas.draw_over(bar);
        canvas.draw_over(lettering(fmt::format("0 to {:g} mm: median {:.2f}, 90 % below {:.2f}", distance_scale, comparison.distance_median, comparison.distance_p90), Vec2(left, bottom), 0.8 * letters));
      } else {
        const long count = column == 0 ? comparison.contact_nodes : comparison.reference_contact_nodes;
        canvas.draw_over(lettering(fmt::format("blue: {} nodes in contact", count), Vec2(left, bottom), 0.8 * letters));
      }
      paste(sheet, canvas.image(), column * panel_width, row * panel_height);
    }
  return sheet;
}

}  // namespace mv
