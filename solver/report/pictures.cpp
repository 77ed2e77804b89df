// SPDX-License-Identifier: BSD-3-Clause
#include "solver/report/pictures.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <map>

#include "geometry/core/parallel.h"
#include "solver/report/colours.h"
#include "solver/report/png.h"
#include "solver/report/stroke_font.h"

namespace mv {

namespace {

constexpr int picture_width = 900, picture_height = 720;
constexpr double eye_distance = 300;  // mm: a little perspective separates near from far
constexpr double annulus_radius = 0.45, edge_radius = 0.16, chorda_radius = 0.3, tip_radius = 1.3;  // mm
constexpr double letter_height = 1.7;                                                               // mm

/// The valve's own directions and middle.
struct ValveAxes {
  Vec3 centre, up, front, right;  // up: ventricle -> atrium; front: towards the anterior leaflet; right: front x up
};

std::vector<int> element_of_point(const LeafletMesh& mesh) {
  std::vector<int> element(mesh.points.size(), -1);
  for (std::size_t e = 0; e < mesh.tets.size(); ++e)
    for (int k = 0; k < mesh.nodes_per_tet(); ++k)
      element[static_cast<std::size_t>(mesh.tets[e][static_cast<std::size_t>(k)])] = static_cast<int>(e);
  return element;
}

ValveAxes axes_of(const LeafletsFrame& frame) {
  const LeafletMesh& mesh = frame.mesh;
  ValveAxes axes;
  axes.up = -frame.annulus_normal.normalized();
  Vec3 all = Vec3::Zero(), front = Vec3::Zero();
  int n_all = 0, n_front = 0;
  const std::vector<int> element = element_of_point(mesh);
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    if (mesh.on_annulus[i] == 0 || element[i] < 0) continue;
    all += mesh.points[i];
    ++n_all;
    if (mesh.region[static_cast<std::size_t>(element[i])] == anterior) {
      front += mesh.points[i];
      ++n_front;
    }
  }
  axes.centre = n_all > 0 ? Vec3(all / n_all) : mesh.points[0];
  Vec3 towards = n_front > 0 && n_front < n_all ? Vec3(front / n_front - axes.centre) : Vec3(Vec3::UnitY());
  towards -= axes.up * axes.up.dot(towards);
  if (towards.norm() < 1e-6) towards = axes.up.unitOrthogonal();
  axes.front = towards.normalized();
  axes.right = axes.front.cross(axes.up);
  return axes;
}

enum class Paint { contact, stress };

/// Tint of each mesh point by its leaflet.
std::vector<Rgb> leaflet_tints(const LeafletMesh& mesh) {
  std::vector<Rgb> colour(mesh.points.size(), Rgb::Zero());
  std::vector<float> count(mesh.points.size(), 0);
  for (std::size_t e = 0; e < mesh.tets.size(); ++e)
    for (int k = 0; k < mesh.nodes_per_tet(); ++k) {
      const auto p = static_cast<std::size_t>(mesh.tets[e][static_cast<std::size_t>(k)]);
      colour[p] += mesh.region[e] == anterior ? anterior_colour : posterior_colour;
      count[p] += 1;
    }
  for (std::size_t p = 0; p < colour.size(); ++p)
    if (count[p] > 0) colour[p] /= count[p];
  return colour;
}

/// Mean von Mises stress of the elements around each point, as a colour.
std::vector<Rgb> stress_colours(const LeafletsFrame& frame, double scale) {
  const LeafletMesh& mesh = frame.mesh;
  std::vector<double> sum(mesh.points.size(), 0), count(mesh.points.size(), 0);
  for (std::size_t e = 0; e < mesh.tets.size(); ++e)
    for (int k = 0; k < mesh.nodes_per_tet(); ++k) {
      const auto p = static_cast<std::size_t>(mesh.tets[e][static_cast<std::size_t>(k)]);
      sum[p] += frame.von_mises[e];
      count[p] += 1;
    }
  std::vector<Rgb> colour;
  for (std::size_t p = 0; p < sum.size(); ++p)
    colour.push_back(map_colour(cividis_stops, sum[p] / std::max(1.0, count[p]) / scale));
  return colour;
}

/// The leaflets' boundary: atrial faces (with a coat of contact pressure when asked for) and the rest, as two meshes.
std::array<ColouredMesh, 2> leaflet_surface(const LeafletsFrame& frame, const FaceTriangles& boundary, Paint paint, double scale) {
  const LeafletMesh& mesh = frame.mesh;
  std::array<ColouredMesh, 2> parts;
  for (ColouredMesh& part : parts) {
    part.points = mesh.points;
    part.colours = paint == Paint::stress ? stress_colours(frame, scale) : leaflet_tints(mesh);
  }
  if (paint == Paint::contact && scale > 0 && !frame.contact_pressure.empty())
    for (double p : frame.contact_pressure) {
      parts[0].coat.push_back(map_colour(viridis_stops, p / scale));
      parts[0].cover.push_back(p > 0 ? 1.0f : 0.0f);
    }
  for (const auto& t : boundary.triangles) {
    const bool is_atrial =
        std::all_of(t.begin(), t.end(), [&](int p) { return mesh.side[static_cast<std::size_t>(p)] == atrial; });
    parts[is_atrial ? 0 : 1].triangles.push_back(t);
  }
  return parts;
}

/// Tissue cut by a plane: polygons of the elements that it crosses, in a deeper shade of the leaflet's colour.
ColouredMesh cut_face(const LeafletsFrame& frame, const Vec3& origin, const Vec3& normal) {
  // a quadratic element is cut as eight linear ones
  constexpr int whole[1][4] = {{0, 1, 2, 3}};
  constexpr int eight[8][4] = {{0, 4, 6, 7}, {4, 1, 5, 8}, {6, 5, 2, 9}, {7, 8, 9, 3},
                               {4, 5, 6, 8}, {4, 6, 7, 8}, {5, 9, 6, 8}, {6, 9, 7, 8}};
  ColouredMesh out;
  const LeafletMesh& mesh = frame.mesh;
  const int parts = mesh.order == 2 ? 8 : 1;
  for (std::size_t e = 0; e < mesh.tets.size(); ++e)
    for (int s = 0; s < parts; ++s) {
      const int* corner = mesh.order == 2 ? eight[s] : whole[s];
      std::array<Vec3, 4> x;
      std::array<double, 4> d;
      for (std::size_t k = 0; k < 4; ++k) {
        x[k] = mesh.points[static_cast<std::size_t>(mesh.tets[e][static_cast<std::size_t>(corner[k])])];
        d[k] = (x[k] - origin).dot(normal);
      }
      std::vector<Vec3> polygon;
      for (std::size_t a = 0; a < 4; ++a)
        for (std::size_t b = a + 1; b < 4; ++b)
          if ((d[a] < 0) != (d[b] < 0)) polygon.push_back(x[a] + d[a] / (d[a] - d[b]) * (x[b] - x[a]));
      if (polygon.size() < 3) continue;
      // the four points of a quadrilateral come as pairs of opposite edges: 02-13 order makes it a fan
      if (polygon.size() == 4) std::swap(polygon[2], polygon[3]);
      const int first = static_cast<int>(out.points.size());
      const Rgb colour = (mesh.region[e] == anterior ? anterior_colour : posterior_colour) * 0.72f;
      for (const Vec3& p : polygon) {
        out.points.push_back(p);
        out.colours.push_back(colour);
      }
      for (int k = 1; k + 1 < static_cast<int>(polygon.size()); ++k) out.triangles.push_back({first, first + k, first + k + 1});
    }
  out.is_lit = false;
  return out;
}

/// Points with the flag on one side, in order along the pattern.
std::vector<Vec3> flagged_line(const LeafletMesh& mesh, const std::vector<char>& flag, int side) {
  std::vector<std::pair<double, Vec3>> line;
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    if (flag[i] != 0 && mesh.side[i] == side) line.emplace_back(mesh.unfolded[i].x(), mesh.points[i]);
  std::sort(line.begin(), line.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Vec3> points;
  for (const auto& [u, x] : line) points.push_back(x);
  return points;
}

/// The annulus in the middle of the thickness; at the atrial face when no points lie between the faces.
std::vector<Vec3> annulus_line(const LeafletMesh& mesh) {
  std::vector<Vec3> line = flagged_line(mesh, mesh.on_annulus, between);
  return line.size() >= 3 ? line : flagged_line(mesh, mesh.on_annulus, atrial);
}

ColouredMesh chordae_mesh(const ChordaeFrame& chordae) {
  ColouredMesh mesh;
  for (std::size_t s = 0; s < chordae.segments.size(); ++s) {
    const bool is_primary = chordae.kind[s] == ChordaKind::primary || chordae.kind[s] == ChordaKind::marginal;
    const std::array<Vec3, 2> line{chordae.points[static_cast<std::size_t>(chordae.segments[s][0])],
                                   chordae.points[static_cast<std::size_t>(chordae.segments[s][1])]};
    append(mesh, make_tube(line, chorda_radius, is_primary ? primary_colour : secondary_colour));
  }
  for (std::size_t i = 0; i < chordae.points.size(); ++i)
    if (chordae.muscle_of_point[i] >= 0) append(mesh, make_sphere(chordae.points[i], tip_radius, muscle_colour));
  return mesh;
}

ColouredMesh lettering(const std::string& text, const Vec2& origin, double height, const Rgb& colour = ink_colour) {
  ColouredMesh mesh;
  mesh.is_lit = false;
  for (const auto& stroke : text_strokes(text, origin, height)) append(mesh, make_stroke(stroke, 0.13 * height, 0, colour));
  return mesh;
}

void write_centred(Canvas& canvas, const std::string& text, double x, double y, double height) {
  canvas.draw_over(lettering(text, Vec2(x - text_width(text, height) / 2, y), height));
}

ColouredMesh rectangle(const Vec2& lower, const Vec2& upper, const Rgb& left, const Rgb& right) {
  ColouredMesh mesh;
  mesh.is_lit = false;
  mesh.points = {{lower.x(), lower.y(), 0}, {upper.x(), lower.y(), 0}, {upper.x(), upper.y(), 0}, {lower.x(), upper.y(), 0}};
  mesh.colours = {left, right, right, left};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

enum class View { atrium, ventricle, cut };

struct Framing {
  Vec3 centre;
  double half_height;
};

/// Centre and scale that show all points, with room for a line of lettering above and below.
Framing frame_points(const std::vector<Vec3>& points, const Vec3& right, const Vec3& up, const Vec3& through) {
  Vec2 lower(1e300, 1e300), upper(-1e300, -1e300);
  for (const Vec3& p : points) {
    const Vec2 q((p - through).dot(right), (p - through).dot(up));
    lower = lower.cwiseMin(q);
    upper = upper.cwiseMax(q);
  }
  const Vec2 middle = (lower + upper) / 2, half = (upper - lower) / 2;
  const double aspect = static_cast<double>(picture_width) / picture_height;
  return {through + middle.x() * right + middle.y() * up, std::max(half.y() + 2.6 * letter_height, (half.x() + 1.5) / aspect)};
}

struct Scene {
  const LeafletsFrame& leaflets;
  const FaceTriangles& boundary;
  const ChordaeFrame* chordae;
  ValveAxes axes;
  Framing framing;
};

Image draw_view(const Scene& scene, View view, Paint paint, double scale) {
  const ValveAxes& axes = scene.axes;
  Camera camera;
  camera.centre = scene.framing.centre;
  camera.half_height = scene.framing.half_height;
  camera.eye_distance = eye_distance;
  camera.direction = view == View::atrium ? Vec3(-axes.up) : view == View::ventricle ? axes.up : axes.right;
  camera.up = view == View::cut ? axes.up : axes.front;
  Canvas canvas(picture_width, picture_height, camera, Rgb(1, 1, 1), 2);

  const LeafletMesh& mesh = scene.leaflets.mesh;
  const auto draw = [&](const ColouredMesh& part) {
    if (view == View::cut)
      canvas.draw(clip(part, axes.centre, axes.right));
    else
      canvas.draw(part);
  };
  for (const ColouredMesh& part : leaflet_surface(scene.leaflets, scene.boundary, paint, scale)) draw(part);
  draw(make_tube(annulus_line(mesh), annulus_radius, ink_colour, true));
  draw(make_tube(flagged_line(mesh, mesh.on_free_edge, atrial), edge_radius, ink_colour * 1.6f, true));
  if (scene.chordae != nullptr) draw(chordae_mesh(*scene.chordae));
  if (view == View::cut) canvas.draw(cut_face(scene.leaflets, axes.centre, axes.right));

  const double top = camera.half_height - 1.6 * letter_height, bottom = -camera.half_height + 0.7 * letter_height;
  if (view == View::cut) {
    write_centred(canvas, "atrium", 0, top, letter_height);
    write_centred(canvas, "ventricle", 0, bottom, letter_height);
    canvas.draw_over(lettering("anterior", Vec2(-canvas.half_width() + 1, top), letter_height));
    canvas.draw_over(
        lettering("posterior", Vec2(canvas.half_width() - 1 - text_width("posterior", letter_height), top), letter_height));
  } else {
    write_centred(canvas, "anterior", 0, top, letter_height);
    write_centred(canvas, "posterior", 0, bottom, letter_height);
  }
  const Vec2 bar(-canvas.half_width() + 1, bottom);
  canvas.draw_over(rectangle(bar, bar + Vec2(10, 0.35), ink_colour, ink_colour));
  canvas.draw_over(lettering("10 mm", bar + Vec2(0, 0.8), 0.8 * letter_height));
  return canvas.image();
}

Picture finished(const std::string& name, const std::string& caption, Image image) {
  std::string png = encode_png(image);
  return {name, caption, std::move(image), std::move(png)};
}

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", x);
  return text;
}

}  // namespace

double stress_scale_of(const LeafletsFrame& frame) {
  if (frame.von_mises.empty()) return 0;
  std::vector<double> sorted = frame.von_mises;
  std::sort(sorted.begin(), sorted.end());
  return round_up_nicely(sorted[static_cast<std::size_t>(0.99 * static_cast<double>(sorted.size() - 1))]);
}

double pressure_scale_of(const std::vector<double>& contact_pressures) {
  std::vector<double> carried;
  for (double p : contact_pressures)
    if (p > 0) carried.push_back(p);
  if (carried.empty()) return 0;
  std::sort(carried.begin(), carried.end());
  return round_up_nicely(carried[static_cast<std::size_t>(0.99 * static_cast<double>(carried.size() - 1))]);
}

std::vector<Picture> draw_valve(const ValveFrames& frames, double pressure_scale, double stress_scale) {
  std::vector<Picture> pictures;
  if (!frames.open) return pictures;
  const ValveAxes axes = axes_of(*frames.open);
  // one framing for the open and the closed state, so that they can be compared
  std::vector<Vec3> leaflets = frames.open->mesh.points, all;
  if (frames.closed) leaflets.insert(leaflets.end(), frames.closed->mesh.points.begin(), frames.closed->mesh.points.end());
  all = leaflets;
  for (const auto* chordae : {&frames.open_chordae, &frames.closed_chordae})
    if (*chordae) all.insert(all.end(), (*chordae)->points.begin(), (*chordae)->points.end());
  const Framing from_atrium = frame_points(leaflets, axes.right, axes.front, axes.centre);
  const Framing from_ventricle = frame_points(all, -axes.right, axes.front, axes.centre);
  const Framing side = frame_points(all, -axes.front, axes.up, axes.centre);

  const FaceTriangles open_boundary = boundary_faces(frames.open->mesh), closed_boundary = frames.closed ? boundary_faces(frames.closed->mesh) : FaceTriangles();
  struct Wanted {
    std::string name, what;
    Scene scene;
    View view;
    Paint paint;
    double scale;
  };
  std::vector<Wanted> wanted;
  const auto add = [&](bool is_open, bool has_chordae, const std::string& name, const std::string& what, Paint paint, double scale, View view) {
    const std::optional<ChordaeFrame>& chordae = is_open ? frames.open_chordae : frames.closed_chordae;
    wanted.push_back({name, what,
                      Scene{is_open ? *frames.open : *frames.closed, is_open ? open_boundary : closed_boundary, has_chordae && chordae ? &*chordae : nullptr, axes,
                            view == View::atrium      ? from_atrium
                            : view == View::ventricle ? from_ventricle
                                                      : side},
                      view, paint, scale});
  };
  const auto three = [&](bool is_open, const std::string& state) {
    add(is_open, true, state + "_atrial", "from the atrium", Paint::contact, pressure_scale, View::atrium);
    add(is_open, true, state + "_ventricular", "from the ventricle", Paint::contact, pressure_scale, View::ventricle);
    add(is_open, true, state + "_cut", "cut through the middle of both leaflets", Paint::contact, pressure_scale, View::cut);
  };
  three(true, "open");
  if (frames.closed) {
    three(false, "closed");
    if (stress_scale > 0) {
      add(false, false, "stress_atrial", "from the atrium", Paint::stress, stress_scale, View::atrium);
      add(false, false, "stress_ventricular", "from the ventricle", Paint::stress, stress_scale, View::ventricle);
    }
  }
  pictures.resize(wanted.size());
  std::vector<std::exception_ptr> errors(wanted.size());
  parallel_pieces(
      static_cast<std::ptrdiff_t>(wanted.size()), 1,
      [&](std::ptrdiff_t begin, std::ptrdiff_t end, int) {
        for (std::ptrdiff_t k = begin; k < end; ++k) try {
            const Wanted& w = wanted[static_cast<std::size_t>(k)];
            pictures[static_cast<std::size_t>(k)] = finished(w.name, w.what, draw_view(w.scene, w.view, w.paint, w.scale));
          } catch (...) {
            errors[static_cast<std::size_t>(k)] = std::current_exception();  // none may leave a parallel loop
          }
      },
      2);
  for (const std::exception_ptr& error : errors)
    if (error) std::rethrow_exception(error);
  return pictures;
}

Picture draw_contact_map(const ContactMap& map, const MapView& view, double pressure_scale) {
  constexpr double margin = 4, foot = 13, head = 5, letters = 2.0;  // mm
  const Vec2 size = view.upper - view.lower;
  const double half_width = size.x() / 2 + margin, half_height = (size.y() + head + foot) / 2;
  constexpr int width = 1800;
  // v runs downwards on the sheet: the annulus is at the top, as in papers/s0, figure 7
  const Vec2 shift(-(view.lower.x() + view.upper.x()) / 2, half_height - head);
  const auto place = [&](const Vec2& p) { return Vec2(p.x() + shift.x(), shift.y() - (p.y() - view.lower.y())); };
  Camera camera;
  camera.half_height = half_height;
  Canvas canvas(width, static_cast<int>(std::lround(width * half_height / half_width)), camera);

  ColouredMesh sheet;
  sheet.triangles = map.triangles;
  sheet.colours.assign(map.points.size(), no_contact_colour);
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    const Vec2 p = place(map.points[i]);
    sheet.points.emplace_back(p.x(), p.y(), 0);
    sheet.coat.push_back(map_colour(viridis_stops, map.contact_pressure[i] / pressure_scale));
    sheet.cover.push_back(map.contact_pressure[i] > 0 ? 1.0f : 0.0f);
  }
  canvas.draw_over(sheet);
  const auto draw_lines = [&](const std::vector<MapLine>& lines, double thickness, const Rgb& colour) {
    for (MapLine line : lines) {
      for (Vec2& p : line) p = place(p);
      canvas.draw_over(make_stroke(line, thickness, 0, colour));
    }
  };
  draw_lines(view.commissures, 0.18, rgb(0x8a8f96));
  draw_lines(view.belt, 0.22, rgb(0x000000));
  draw_lines(view.outline, 0.3, ink_colour);
  for (const MapLabel& label : view.labels) {
    const Vec2 p = place({label.u, label.v});
    if (!label.is_commissure) {
      write_centred(canvas, label.name, p.x(), place({label.u, 1.2 * letters + 0.6}).y(), letters);
      continue;
    }
    const std::string name = label.name.substr(0, label.name.find(' '));
    const double half = text_width(name, 0.75 * letters) / 2;
    write_centred(canvas, name, std::clamp(p.x(), -half_width + half + 0.5, half_width - half - 0.5), p.y() + 1.4,
                  0.75 * letters);
  }

  const double base = -half_height + 3.2;
  const Vec2 bar(-half_width + margin, base);
  canvas.draw_over(rectangle(bar, bar + Vec2(10, 0.4), ink_colour, ink_colour));
  canvas.draw_over(lettering("10 mm", bar + Vec2(0, 1.0), 0.8 * letters));
  constexpr int steps = 64;
  constexpr double length = 36, thickness = 1.8;
  const Vec2 scale(half_width - margin - length - 4, base);
  for (int i = 0; i < steps; ++i)
    canvas.draw_over(rectangle(scale + Vec2(length * i / steps, 0), scale + Vec2(length * (i + 1) / steps, thickness),
                               map_colour(viridis_stops, static_cast<double>(i) / steps),
                               map_colour(viridis_stops, (i + 1.0) / steps)));
  for (int i = 0; i <= 2; ++i)
    write_centred(canvas, number(pressure_scale * i / 2), scale.x() + length * i / 2, base - 2.2, 0.75 * letters);
  write_centred(canvas, "contact pressure, kPa", scale.x() + length / 2, base + thickness + 0.9, 0.75 * letters);
  Finish plain;
  plain.outline_step = plain.valley_strength = 0;
  return finished("contact_map", "contact map of the unfolded valve", canvas.image(plain));
}

Picture draw_overview(const Picture& closed_atrial, const Picture& closed_cut, const Picture& contact_map) {
  const int width = std::max(contact_map.image.width, closed_atrial.image.width + closed_cut.image.width);
  Image sheet = Image::filled(width, closed_atrial.image.height + contact_map.image.height, Rgb(1, 1, 1));
  const int gap = (width - closed_atrial.image.width - closed_cut.image.width) / 2;
  paste(sheet, closed_atrial.image, gap, 0);
  paste(sheet, closed_cut.image, gap + closed_atrial.image.width, 0);
  paste(sheet, contact_map.image, (width - contact_map.image.width) / 2, closed_atrial.image.height);
  return finished("overview", "closed valve from the atrium and in a cut, and its contact map", std::move(sheet));
}

}  // namespace mv
