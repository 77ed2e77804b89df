// SPDX-License-Identifier: BSD-3-Clause
#include "solver/report/compare.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "solver/report/colours.h"
#include "solver/report/png.h"
#include "solver/report/results_data.h"
#include "solver/report/stroke_font.h"

namespace mv {
namespace {

constexpr int tile_width = 560, tile_height = 420, caption_height = 44;
constexpr double eye_distance = 300;  // mm
const Rgb above_colour(0.80f, 0.16f, 0.13f), ink(0.15f, 0.15f, 0.18f);

const std::vector<std::string> default_quantities{
    "seal.sealed", "seal.hole_area_mm2", "seal.smallest_sealing_threshold_mm", "bulging.volume_ml", "bulging.area_ratio", "contact.area_mm2", "contact.force_N",
    "contact.belt_width_mm_mean", "chordae.force_primary_N", "chordae.force_secondary_N", "flow.closing_volume_ml", "flow.leak_rate_ml_s", "run.simulated_s"};

std::string text_of(const Json& value) {
  if (value.is_null()) return "";
  if (value.is_number_float()) return fmt::format("{:.5g}", value.get<double>());
  if (value.is_array()) {
    std::string out;
    for (const Json& v : value) out += (out.empty() ? "" : " ") + text_of(v);
    return out;
  }
  return value.is_string() ? value.get<std::string>() : value.dump();
}

// The valve's own directions: up towards the atrium, front towards the anterior leaflet.
struct View {
  Vec3 centre = Vec3::Zero(), up, front;
  double size = 0;
};

View view_of(const LeafletsFrame& frame) {
  View view;
  view.up = -frame.annulus_normal.normalized();
  const LeafletMesh& mesh = frame.mesh;
  std::vector<int> region(mesh.points.size(), 0);
  for (std::size_t e = 0; e < mesh.tets.size(); ++e)
    for (std::size_t k = 0; k < 4; ++k) region[static_cast<std::size_t>(mesh.tets[e][k])] = mesh.region[e];
  Vec3 front = Vec3::Zero();
  int all = 0, in_front = 0;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    if (!mesh.on_annulus[i]) continue;
    view.centre += mesh.points[i];
    ++all;
    if (region[i] == anterior) {
      front += mesh.points[i];
      ++in_front;
    }
  }
  view.centre /= std::max(all, 1);
  Vec3 towards = in_front > 0 ? Vec3(front / in_front - view.centre) : Vec3::UnitY();
  towards -= view.up * view.up.dot(towards);
  view.front = towards.norm() > 1e-6 ? Vec3(towards.normalized()) : view.up.unitOrthogonal();
  for (const Vec3& x : mesh.points) view.size = std::max(view.size, (x - view.centre).norm());
  return view;
}

ColouredMesh leaflets_of(const LeafletsFrame& frame) {
  ColouredMesh out;
  const LeafletMesh& mesh = frame.mesh;
  out.points = mesh.points;
  out.colours.assign(mesh.points.size(), posterior_colour);
  for (std::size_t e = 0; e < mesh.tets.size(); ++e)
    if (mesh.region[e] == anterior)
      for (std::size_t k = 0; k < 4; ++k) out.colours[static_cast<std::size_t>(mesh.tets[e][k])] = anterior_colour;
  for (const Vec3& x : mesh.points) {
    out.coat.push_back(above_colour);
    out.cover.push_back(frame.annulus_normal.dot(x - frame.annulus_origin) < 0 ? 1.0f : 0.0f);
  }
  out.triangles = boundary_faces(mesh).triangles;
  return out;
}

Image tile(const LeafletsFrame& frame, const View& view, bool from_side) {
  // From the side a little from above, as s2 draws it; or from the atrium with the anterior leaflet at the top.
  const Vec3 direction = from_side ? Vec3(view.front - 0.45 * view.up).normalized() : Vec3(-view.up);
  const Vec3 up = from_side ? view.up : view.front;
  Canvas canvas(tile_width, tile_height, {view.centre - (from_side ? 0.15 * view.size : 0.0) * view.up, direction, up, (from_side ? 0.85 : 1.0) * view.size, eye_distance});
  canvas.draw(leaflets_of(frame));
  std::vector<Vec3> plane;
  const Vec3 right = view.front.cross(view.up);
  for (int k = 0; k < 72; ++k) {
    const double a = k * M_PI / 36;
    plane.push_back(frame.annulus_origin + 0.9 * view.size * (std::cos(a) * right + std::sin(a) * view.front));
  }
  if (from_side) canvas.draw(make_tube(plane, 0.12, ink, true));
  return canvas.image();
}

Image caption(const std::string& text, double letter) {
  Canvas canvas(tile_width, caption_height, {Vec3::Zero(), -Vec3::UnitZ(), Vec3::UnitY(), 0.5 * caption_height, 0});
  ColouredMesh letters;
  for (const auto& stroke : text_strokes(text, {-0.5 * text_width(text, letter), -0.4 * letter}, letter)) append(letters, make_stroke(stroke, 1.8, 0, ink));
  letters.is_lit = false;
  canvas.draw_over(letters);
  return canvas.image();
}

void write_picture(const std::filesystem::path& file, const std::vector<LeafletsFrame>& frames, const std::vector<std::string>& names, const std::vector<std::string>& notes) {
  const int n = static_cast<int>(frames.size());
  Image sheet = Image::filled(n * tile_width, 2 * tile_height + 2 * caption_height, Rgb(1, 1, 1));
  View view = view_of(frames[0]);  // one scale and one place for all
  for (int k = 0; k < n; ++k) {
    const auto i = static_cast<std::size_t>(k);
    View own = view_of(frames[i]);
    own.size = view.size;
    paste(sheet, caption(names[i], 22), k * tile_width, 0);
    paste(sheet, tile(frames[i], own, true), k * tile_width, caption_height);
    paste(sheet, tile(frames[i], own, false), k * tile_width, caption_height + tile_height);
    paste(sheet, caption(notes[i], 15), k * tile_width, caption_height + 2 * tile_height);
  }
  write_text_atomically(file, encode_png(sheet));
}

}  // namespace

std::string compare_results(const CompareOptions& options) {
  if (options.results.empty()) throw UsageError("compare needs at least one results directory");
  if (!options.names.empty() && options.names.size() != options.results.size())
    throw UsageError(fmt::format("--names gives {} labels for {} results", options.names.size(), options.results.size()));
  std::vector<ResultsData> data;
  std::vector<std::string> names = options.names;
  for (const auto& r : options.results) {
    data.push_back(read_results(r));
    if (options.names.empty()) names.push_back((r.filename().empty() ? r.parent_path() : r).filename().string());
  }
  const auto& quantities = options.quantities.empty() ? default_quantities : options.quantities;
  std::string csv = "quantity", table = "| quantity |", rule = "|---|";
  for (const std::string& name : names) {
    csv += "," + name;
    table += " " + name + " |";
    rule += "---|";
  }
  csv += "\n";
  table += "\n" + rule + "\n";
  for (const std::string& quantity : quantities) {
    bool is_known = false;
    std::string row_csv = quantity, row = "| " + quantity + " |";
    for (const ResultsData& d : data) {
      const std::string value = text_of(json_at(d.summary, quantity));
      is_known |= !value.empty();
      row_csv += "," + value;
      row += " " + value + " |";
    }
    if (!is_known && !options.quantities.empty()) throw UsageError("no result has the quantity '" + quantity + "'; see summary.json for their names");
    csv += row_csv + "\n";
    table += row + "\n";
  }
  std::error_code failure;
  std::filesystem::create_directories(options.output, failure);
  if (failure) throw IoError(options.output.string() + ": cannot be made: " + failure.message());
  write_text_atomically(options.output / "compare.csv", csv);
  write_text_atomically(options.output / "compare.md", table);
  std::vector<LeafletsFrame> frames;
  std::vector<std::string> shown, notes;
  for (std::size_t k = 0; k < data.size(); ++k)
    if (data[k].frames.closed) {
      frames.push_back(*data[k].frames.closed);
      shown.push_back(names[k]);
      notes.push_back(fmt::format("above the plane {} ml, ratio {}", text_of(json_at(data[k].summary, "bulging.volume_ml")), text_of(json_at(data[k].summary, "bulging.area_ratio"))));
    }
  if (!frames.empty()) write_picture(options.output / "compare.png", frames, shown, notes);
  return table;
}

}  // namespace mv
