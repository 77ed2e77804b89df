// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/labels_source.h"

#include "geometry/core/errors.h"
#include "geometry/core/log.h"
#include "geometry/image/label_landmarks.h"
#include "geometry/image/label_surface.h"
#include "geometry/image/nifti.h"
#include "geometry/surface/mid_surface_of_solid.h"
#include "pipeline/patient_source.h"

namespace mv {
namespace {

LabelTable table_of(const Config& config) {
  LabelTable own;
  for (const auto& row : LabelTable::rows())
    for (const double value : config.numbers(std::string("labels.") + row.name)) (own.*row.values).push_back(std::lround(value));
  return merged_table(config.text("labels.preset"), own);
}

LabelImage read_image(const Config& config, std::vector<std::string>& notes) {
  if (config.text("labels.file").empty())
    throw ConfigError("key 'labels.file' is empty: source.kind = \"labels\" needs a label map, e.g. labels.file = \"valve.nii.gz\"");
  NiftiOptions options;
  options.transform = config.text("labels.transform");
  options.unit = config.text("labels.unit");
  NiftiLabels labels = read_nifti_labels(config.path("labels.file"), options);
  notes = labels.notes;
  return std::move(labels.image);
}

void add_notes(RawLeaflets& raw, const std::vector<std::string>& notes) { raw.notes.insert(raw.notes.end(), notes.begin(), notes.end()); }

void take_landmarks(const LabelLandmarks& marks, RawLeaflets& raw) {
  raw.annulus_curve = marks.annulus_curve;
  raw.commissures = marks.commissures;
  raw.papillary_points = marks.papillary_points;
  raw.papillary_names = marks.papillary_names;
  raw.anterior_hint = marks.anterior_hint;
  raw.ventricle_direction = marks.ventricle_direction;
}

void add_measures(const LabelSurface& surface, const SolidMidSurface& mid, const LabelLandmarks& marks, nlohmann::ordered_json& measures) {
  measures["labels.voxel_volume_mm3"] = surface.voxel_volume;
  measures["labels.surface_volume_mm3"] = surface.volume;
  measures["labels.surface_area_mm2"] = surface.area;
  measures["labels.surface_offset_mm"] = surface.offset;
  measures["labels.joined_voxels"] = surface.joined;
  measures["labels.surface_parts"] = surface.parts;
  measures["labels.surface_handles"] = surface.handles;
  measures["labels.thickness_median_mm"] = mid.thickness_median;
  measures["labels.hinge_share"] = marks.hinge_share;
  measures["labels.papillary_heads"] = marks.papillary_points.size();
  measures["rule.ventricle_direction"] = marks.direction_rule;
}

LabelSurface surface_of(const Config& config, const LabelledParts& parts, const std::string& name) {
  LabelSurfaceOptions options;
  options.smoothing = config.number("labels.smoothing");
  options.hole_radius = config.number("labels.hole_radius");
  return label_surface(parts, options, name);
}

}  // namespace

SolidSurface read_label_surface(const Config& config) {
  const std::string name = config.path("labels.file").string();
  std::vector<std::string> notes;  // the source stage has told them
  const LabelledParts parts = label_parts(read_image(config, notes), table_of(config), {config.number("labels.island_share")}, name);
  LabelSurface surface = surface_of(config, parts, name);
  return {std::move(surface.points), std::move(surface.triangles), std::move(surface.region)};
}

RawLeaflets read_label_leaflets(const Config& config, nlohmann::ordered_json& measures) {
  const LabelTable table = table_of(config);
  const std::string name = config.path("labels.file").string();
  std::vector<std::string> image_notes;
  const LabelImage image = read_image(config, image_notes);
  for (const std::string& line : describe_labels(image, table)) spdlog::info("{}", line);

  const LabelledParts parts = label_parts(image, table, {config.number("labels.island_share")}, name);
  const LabelSurface surface = surface_of(config, parts, name);
  spdlog::info("label surface: {:.0f} mm3 (voxels {:.0f} mm3), {:.0f} mm2, {} parts, {} handles, {} iterations", surface.volume, surface.voxel_volume,
               surface.area, surface.parts, surface.handles, surface.iterations);
  const SolidMidSurface mid = mid_surface_of_solid({surface.points, surface.triangles, surface.region});
  const LabelLandmarks marks = find_landmarks(parts, {}, name);

  RawLeaflets raw;
  raw.points = mid.points;
  raw.triangles = mid.triangles;
  raw.region = mid.label;
  raw.thickness = mid.thickness;
  take_landmarks(marks, raw);
  for (const std::vector<std::string>* notes : std::initializer_list<const std::vector<std::string>*>{&image_notes, &parts.notes, &surface.notes, &mid.notes, &marks.notes}) add_notes(raw, *notes);
  add_measures(surface, mid, marks, measures);
  return raw;
}

SourceGeometry make_labels_source(const Config& config) {
  nlohmann::ordered_json measures = nlohmann::ordered_json::object();
  SourceGeometry source = make_patient_source(config, read_label_leaflets(config, measures));
  source.measures.update(measures);
  return source;
}

}  // namespace mv
