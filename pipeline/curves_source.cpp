// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/curves_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "geometry/core/errors.h"
#include "geometry/core/log.h"
#include "geometry/image/label_map.h"
#include "geometry/image/nifti.h"
#include "geometry/image/slice_curves.h"
#include "geometry/loft/curve_files.h"
#include "geometry/loft/curve_surface.h"
#include "pipeline/patient_source.h"

namespace mv {
namespace {

constexpr double distinct_spacing = 1.3;  // ratio from which the longest voxel side is the distance of slices
constexpr std::size_t odd_copies = 4;     // equal slices in a row; label maps that were resampled along the stack have them
constexpr double most_copies = 0.5;       // of the slices that hold leaflet
constexpr double noise_in_pixels = 0.5;   // of a curve point, for the discrepancy principle

Vec3 vector_of(const Config& config, const char* key, double unit) {
  const auto& values = config.numbers(key);
  return Vec3(values[0], values[1], values[2]) / unit;
}

LabelTable table_of(const Config& config) {
  LabelTable own;
  for (const auto& row : LabelTable::rows())
    for (const double value : config.numbers(std::string("labels.") + row.name)) (own.*row.values).push_back(std::lround(value));
  return merged_table(config.text("labels.preset"), own);
}

/// Pixel value -> part.
std::map<long, SlicePart> parts_of(const LabelTable& table) {
  std::map<long, SlicePart> parts;
  for (const auto& [values, part] : {std::pair(&table.posterior, SlicePart::posterior), std::pair(&table.anterior, SlicePart::anterior),
                                     std::pair(&table.papillary_anterolateral, SlicePart::papillary_anterolateral),
                                     std::pair(&table.papillary_posteromedial, SlicePart::papillary_posteromedial), std::pair(&table.papillary, SlicePart::papillary),
                                     std::pair(&table.atrium, SlicePart::atrium), std::pair(&table.ventricle, SlicePart::ventricle)})
    for (const long value : *values) parts[value] = part;
  return parts;
}

/// Axis along which the image is a stack: its longest voxel side when that stands out, else k.
int stack_axis(const Config& config, const LabelImage& image) {
  const std::string& wanted = config.text("curves.slice_axis");
  if (wanted != "auto") return wanted == "i" ? 0 : wanted == "j" ? 1 : 2;
  const Vec3 s = image.spacing();
  int longest = 0;
  s.maxCoeff(&longest);
  const double other = std::max(s[(longest + 1) % 3], s[(longest + 2) % 3]);
  return s[longest] > distinct_spacing * other ? longest : 2;
}

std::vector<GreySlice> slices_of(const LabelImage& image, int axis, const std::string& name) {
  const int a = (axis + 1) % 3, b = (axis + 2) % 3;
  std::vector<GreySlice> slices;
  for (int k = 0; k < image.size[static_cast<std::size_t>(axis)]; ++k) {
    GreySlice slice;
    slice.place.name = fmt::format("{}: slice {}", name, k + 1);
    slice.place.width = image.size[static_cast<std::size_t>(a)];
    slice.place.height = image.size[static_cast<std::size_t>(b)];
    slice.place.step_x = image.axes.col(a);
    slice.place.step_y = image.axes.col(b);
    slice.place.origin = image.origin + k * image.axes.col(axis);
    std::array<int, 3> voxel{};
    voxel[static_cast<std::size_t>(axis)] = k;
    for (int j = 0; j < slice.place.height; ++j)
      for (int i = 0; i < slice.place.width; ++i) {
        voxel[static_cast<std::size_t>(a)] = i;
        voxel[static_cast<std::size_t>(b)] = j;
        slice.values.push_back(image.at(voxel[0], voxel[1], voxel[2]));
      }
    slices.push_back(std::move(slice));
  }
  return slices;
}

PngPlacement placement_of(const Config& config) {
  PngPlacement placement;
  if (!config.is_auto("curves.pixel_spacing")) {
    const auto& s = config.numbers("curves.pixel_spacing");
    placement.pixel_spacing = {s[0] / unit_factor("mm"), s[1] / unit_factor("mm")};
  }
  if (!config.is_auto("curves.slice_spacing")) placement.slice_spacing = config.number_in("curves.slice_spacing", "mm");
  placement.position = vector_of(config, "curves.position", unit_factor("mm"));
  placement.row = vector_of(config, "curves.row_direction", 1);
  placement.column = vector_of(config, "curves.column_direction", 1);
  placement.is_lps = config.text("curves.space") == "LPS";
  return placement;
}

std::vector<GreySlice> read_grey_slices(const Config& config, std::vector<std::string>& notes) {
  const auto path = config.path("curves.slices");
  if (std::filesystem::is_directory(path)) return read_png_slices(path, placement_of(config));
  if (path.extension() == ".png" || path.extension() == ".PNG")
    throw ConfigError(fmt::format("key 'curves.slices' = \"{}\" is one picture: a valve needs several slices; expected a folder of PNG files or a NIfTI stack", path.string()));
  NiftiOptions options;
  options.transform = config.text("labels.transform");
  options.unit = config.text("labels.unit");
  NiftiLabels labels = read_nifti_labels(path, options);
  notes.insert(notes.end(), labels.notes.begin(), labels.notes.end());
  return slices_of(labels.image, stack_axis(config, labels.image), path.filename().string());
}

/// A slice that was copied over most of the stack is no valve.
void check_copies(const std::vector<Slice>& slices, const std::string& name) {
  const auto is_leaflet = [](std::uint8_t p) { return p == static_cast<std::uint8_t>(SlicePart::leaflet) || p == static_cast<std::uint8_t>(SlicePart::anterior) || p == static_cast<std::uint8_t>(SlicePart::posterior); };
  std::size_t with_leaflet = 0, run = 0, longest = 0, last = 0;
  for (std::size_t k = 0; k < slices.size(); ++k) {
    const auto& parts = slices[k].parts;
    const bool has_leaflet = std::any_of(parts.begin(), parts.end(), is_leaflet);
    with_leaflet += has_leaflet;
    run = !has_leaflet ? 0 : run > 0 && parts == slices[k - 1].parts ? run + 1 : 1;
    if (run > longest) longest = run, last = k;
  }
  if (longest < odd_copies) return;
  const std::string text = fmt::format("{}: slices {} to {} hold the same leaflets to the last pixel", name, last + 2 - longest, last + 1);
  if (static_cast<double>(longest) > most_copies * static_cast<double>(with_leaflet)) throw InputError(text + "; expected a valve that changes from slice to slice");
  spdlog::warn("{}: was the stack resampled?", text);
}

/// Grey values to parts; says what values there are when no leaflet is among them.
std::vector<Slice> labelled(const Config& config, const std::vector<GreySlice>& grey) {
  const bool is_binary = config.text("curves.mask") == "binary";
  const std::map<long, SlicePart> parts = is_binary ? std::map<long, SlicePart>{} : parts_of(table_of(config));
  std::map<long, long> counts;
  std::map<SlicePart, long> found;
  std::vector<Slice> slices;
  for (const GreySlice& g : grey) {
    slices.push_back(g.place);
    for (const long value : g.values) {
      ++counts[value];
      const auto named = parts.find(value);
      const SlicePart part = is_binary ? (value != 0 ? SlicePart::leaflet : SlicePart::none) : named == parts.end() ? SlicePart::none : named->second;
      ++found[part];
      slices.back().parts.push_back(static_cast<std::uint8_t>(part));
    }
  }
  check_copies(slices, config.path("curves.slices").string());
  std::string list;
  for (const auto& [value, count] : counts)
    if (list.size() < 200) list += fmt::format("{}{} ({} pixels)", list.empty() ? "" : ", ", value, count);
  spdlog::info("slices: {} of {} x {} pixels; values {}", grey.size(), grey.front().place.width, grey.front().place.height, list);
  const bool has_leaflet = found[SlicePart::leaflet] > 0 || (found[SlicePart::posterior] > 0 && found[SlicePart::anterior] > 0);
  if (!has_leaflet)
    throw InputError(fmt::format("{}: {}; the pixels are {}. {}", config.path("curves.slices").string(),
                                 is_binary                            ? "no pixel differs from 0: an empty stack"
                                 : found[SlicePart::posterior] > 0    ? "there is no pixel of the anterior leaflet"
                                 : found[SlicePart::anterior] > 0     ? "there is no pixel of the posterior leaflet"
                                                                      : "there is no pixel of a leaflet",
                                 list, is_binary ? "Expected a mask" : "Choose labels.preset or the keys labels.posterior and labels.anterior; for a mask without labels set curves.mask = \"binary\""));
  return slices;
}

void append(CurveSet& set, const CurveSet& more) {
  const bool was_empty = set.curves.empty();
  set.curves.insert(set.curves.end(), more.curves.begin(), more.curves.end());
  set.annulus_points.insert(set.annulus_points.end(), more.annulus_points.begin(), more.annulus_points.end());
  set.papillary_clouds.insert(set.papillary_clouds.end(), more.papillary_clouds.begin(), more.papillary_clouds.end());
  set.papillary_cloud_names.insert(set.papillary_cloud_names.end(), more.papillary_cloud_names.begin(), more.papillary_cloud_names.end());
  set.notes.insert(set.notes.end(), more.notes.begin(), more.notes.end());
  set.resolution = more.resolution;
  set.empty_slices = more.empty_slices;
  if (was_empty) set.stack_normal = more.stack_normal;
}

CurveSurfaceOptions options_of(const Config& config, const CurveSet& set) {
  CurveSurfaceOptions options;
  options.knot_spacing = config.number_in("curves.knot_spacing", "mm");
  options.with_thickness = config.text("curves.thickness") == "measured";
  options.is_order_meant = config.text("curves.slices").empty();
  options.point_spacing = std::max(options.point_spacing, set.resolution);
  if (config.text("curves.smoothing") == "discrepancy") {
    options.smoothing.rule = SmoothingRule::discrepancy;
    if (!config.is_auto("curves.noise")) options.smoothing.noise = config.number_in("curves.noise", "mm");
    else if (set.resolution > 0) options.smoothing.noise = noise_in_pixels * set.resolution;
    else throw ConfigError("key 'curves.noise' is \"auto\": curves from files have no pixel size; expected the accuracy of their points, e.g. \"0.4 mm\", or curves.smoothing = \"gcv\"");
  }
  return options;
}

void add_measures(const CurveSurfaceReport& r, const std::string& rule, nlohmann::ordered_json& measures) {
  measures["curves.anterior"] = r.curves_anterior;
  measures["curves.posterior"] = r.curves_posterior;
  measures["curves.arches"] = r.arches;
  measures["annulus.hinge_distance_mean_mm"] = r.annulus.residual_mean;
  measures["annulus.hinge_distance_max_mm"] = r.annulus.residual_max;
  measures["annulus.largest_gap_mm"] = r.annulus.largest_gap_mm;
  measures["annulus.largest_gap_deg"] = r.annulus.largest_gap_degrees;
  measures["surface.smoothing_rule"] = rule;
  measures["surface.smoothing_lambda"] = r.fit.lambda;
  measures["surface.degrees_of_freedom"] = r.fit.degrees_of_freedom;
  measures["surface.deviation_mean_mm"] = r.deviation_mean;
  measures["surface.deviation_p95_mm"] = r.deviation_95;
  measures["surface.deviation_max_mm"] = r.deviation_max;
  measures["surface.deviation_max_at"] = r.deviation_max_at;
  measures["surface.area_mm2"] = r.area;
  measures["surface.commissure_height_1_mm"] = r.commissure_height[0];
  measures["surface.commissure_height_2_mm"] = r.commissure_height[1];
  measures["curves.thickness_mean_mm"] = r.thickness_mean;
}

}  // namespace

CurveSet read_curve_set(const Config& config) {
  const bool has_slices = !config.text("curves.slices").empty();
  const auto& files = config.texts("curves.files");
  if (!has_slices && files.empty())
    throw ConfigError("keys 'curves.slices' and 'curves.files' are empty: source.kind = \"curves\" needs segmented slices, e.g. curves.slices = \"stack.nii.gz\", or curves, e.g. "
                      "curves.files = [\"leaflets.csv\"]");
  CurveSet set;
  for (const std::string& file : files) read_curves(config.base_directory() / file, config.text("curves.space") == "LPS", set);
  if (has_slices) {
    std::vector<std::string> notes;
    const std::vector<Slice> slices = labelled(config, read_grey_slices(config, notes));
    SliceCurveOptions options;
    options.bridge_gap = config.number_in("curves.bridge_gap", "mm");
    options.island_area = config.number_in("curves.island_area", "mm2");
    append(set, curves_of_slices(slices, options));
    set.notes.insert(set.notes.begin(), notes.begin(), notes.end());
  }
  if (set.curves.empty())
    throw InputError(fmt::format("no leaflet curve in {}; expected curves from annulus to free edge of both leaflets", has_slices ? config.path("curves.slices").string() : config.paths("curves.files").front().string()));
  return set;
}

RawLeaflets read_curve_leaflets(const Config& config, nlohmann::ordered_json& measures) {
  const CurveSet set = read_curve_set(config);
  CurveSurfaceReport report;
  RawLeaflets raw = surface_from_curves(set, options_of(config, set), &report);
  spdlog::info("curves: {} anterior, {} posterior, {} arches under a commissure", report.curves_anterior, report.curves_posterior, report.arches);
  spdlog::info("annulus: hinge points {:.2f} mm from it on average, {:.2f} mm at most; largest gap between them {:.0f} mm ({:.0f} degrees)", report.annulus.residual_mean,
               report.annulus.residual_max, report.annulus.largest_gap_mm, report.annulus.largest_gap_degrees);
  spdlog::info("surface: curve points {:.2f} mm from it on average, 95 % within {:.2f} mm, {:.2f} mm at most ({}); {:.0f} degrees of freedom by {}", report.deviation_mean,
               report.deviation_95, report.deviation_max, report.deviation_max_at, report.fit.degrees_of_freedom, config.text("curves.smoothing"));
  if (report.fit.is_at_limit) raw.notes.push_back("the smoothing of the leaflets ended at the limit of its range; look at the surface, or set curves.smoothing");
  add_measures(report, config.text("curves.smoothing"), measures);
  return raw;
}

SourceGeometry make_curves_source(const Config& config) {
  nlohmann::ordered_json measures = nlohmann::ordered_json::object();
  RawLeaflets raw = read_curve_leaflets(config, measures);
  const std::vector<std::string> notes = raw.notes;
  SourceGeometry source = make_patient_source(config, std::move(raw));
  for (const std::string& note : notes)
    if (std::find(source.notes.begin(), source.notes.end(), note) == source.notes.end()) source.notes.push_back(note);
  for (const auto& [name, value] : source.measures.items()) measures[name] = value;
  source.measures = measures;
  return source;
}

}  // namespace mv
