// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/source_stage.h"

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "geometry/core/log.h"
#include "pipeline/case_directory.h"
#include "pipeline/curves_source.h"
#include "pipeline/deck_source.h"
#include "pipeline/generic_source.h"
#include "pipeline/labels_source.h"
#include "pipeline/surface_source.h"

namespace mv {
namespace {

/// The file that a source is mainly made from, as configured; empty for a valve without any.
std::string main_file(const Config& config, const std::string& kind) {
  const std::string key = kind == "generic" ? "generic.annulus" : kind == "labels" ? "labels.file" : kind == "surface" ? "surface.file" : kind == "deck" ? "deck.file" : "curves.slices";
  if (!config.text(key).empty()) return config.path(key).string();
  if (kind == "curves" && !config.texts("curves.files").empty()) return config.paths("curves.files").front().string();
  return "";
}

}  // namespace

const std::vector<SourceKind>& source_kinds() {
  static const std::vector<SourceKind> kinds = {
      {"generic", "four-semicircle valve on an elliptic or a measured annulus", make_generic_source},
      {"labels", "leaflets, annulus and papillary tips from a NIfTI label map", make_labels_source},
      {"curves", "segmented slices (NIfTI, PNG) or drawn curves (CSV, VTP, Slicer markups)", make_curves_source},
      {"surface", "surface of thick leaflets or their mid-surface (STL, OBJ, PLY, VTP, VTK)", make_surface_source},
      {"deck", "leaflets, chordae, motion, laws and pressure of an Abaqus deck", make_deck_source},
  };
  return kinds;
}

SourceGeometry make_source(const Config& config) {
  const std::string& wanted = config.text("source.kind");
  for (const SourceKind& kind : source_kinds()) {
    if (kind.name != wanted) continue;
    try {
      return kind.make(config);
    } catch (const InputError& e) {
      // What is found in the shape of the whole does not know its file.
      const std::string file = main_file(config, wanted);
      throw InputError(file.empty() || std::string(e.what()).find("inputs/") != std::string::npos || std::string(e.what()).find(file) != std::string::npos ? e.what() : file + ": " + e.what());
    }
  }
  throw ConfigError("key 'source.kind' = \"" + wanted + "\": this build does not hold that source");
}

std::string run_source_stage(const StageContext& context) {
  const SourceGeometry source = make_source(context.config);
  for (const std::string& note : source.notes) spdlog::warn("source: {}", with_sources(note, context.case_directory));
  write_source(context.out("mid_surface.vtp"), source);
  write_papillary(context.out("papillary.vtp"), source.papillary);
  nlohmann::ordered_json json;
  json["kind"] = context.config.text("source.kind");
  json["summary"] = source.summary;
  json["notes"] = source.notes;
  json["measures"] = source.measures;
  write_text_atomically(context.out("source.json"), json.dump(2) + "\n");
  return source.summary;
}

}  // namespace mv
