// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <unordered_map>

#include "geometry/core/errors.h"
#include "geometry/image/label_map.h"

namespace mv {

const std::vector<LabelTable::Row>& LabelTable::rows() {
  static const std::vector<Row> rows = {{"posterior", &LabelTable::posterior},
                                        {"anterior", &LabelTable::anterior},
                                        {"papillary_anterolateral", &LabelTable::papillary_anterolateral},
                                        {"papillary_posteromedial", &LabelTable::papillary_posteromedial},
                                        {"papillary", &LabelTable::papillary},
                                        {"atrium", &LabelTable::atrium},
                                        {"ventricle", &LabelTable::ventricle},
                                        {"aorta", &LabelTable::aorta}};
  return rows;
}

LabelTable label_preset(const std::string& name) {
  LabelTable table;
  if (name == "own") return table;
  if (name == "mvseg2023" || name == "visible_human") {
    table.posterior = {1};
    table.anterior = {2};
  } else if (name == "slicerheart") {
    table.anterior = {1};
    table.posterior = {2};
  } else {
    throw ConfigError("labels.preset = \"" + name + "\": expected mvseg2023, slicerheart, visible_human or own");
  }
  if (name == "visible_human") {
    table.papillary_anterolateral = {3};
    table.papillary_posteromedial = {4};
    table.atrium = {5};
    table.ventricle = {6};
  }
  return table;
}

LabelTable merged_table(const std::string& preset, const LabelTable& own) {
  LabelTable table = label_preset(preset);
  for (const auto& row : LabelTable::rows())
    if (!(own.*row.values).empty()) table.*row.values = own.*row.values;
  for (const auto& values : {&LabelTable::posterior, &LabelTable::anterior})
    if ((table.*values).empty()) {
      const std::string key = values == &LabelTable::posterior ? "labels.posterior" : "labels.anterior";
      throw ConfigError("labels.preset = \"" + preset + "\" names no label for a leaflet: set " + key + ", e.g. " + key + " = [1]");
    }
  std::map<long, std::string> owner;
  for (const auto& row : LabelTable::rows())
    for (const long value : table.*row.values) {
      if (value == 0) throw ConfigError(fmt::format("labels.{} holds 0, which is the background", row.name));
      if (const auto [at, is_new] = owner.try_emplace(value, row.name); !is_new)
        throw ConfigError(fmt::format("label {} is both labels.{} and labels.{} (labels.preset = \"{}\"): each label belongs to one part", value, at->second, row.name, preset));
    }
  return table;
}

std::map<long, long> label_counts(const LabelImage& image) {
  std::unordered_map<std::int32_t, long> counts;
  for (std::size_t v = 0; v < image.values.size();) {  // runs of equal values
    std::size_t end = v + 1;
    while (end < image.values.size() && image.values[end] == image.values[v]) ++end;
    counts[image.values[v]] += static_cast<long>(end - v);
    v = end;
  }
  return {counts.begin(), counts.end()};
}

std::vector<std::string> describe_labels(const LabelImage& image, const LabelTable& table) {
  const auto counts = label_counts(image);
  std::vector<std::string> lines;
  std::map<long, bool> is_named;
  const auto line = [&](long value, const std::string& part, long voxels) {
    lines.push_back(fmt::format("label {} {}: {} voxels, {:.0f} mm3", value, part, voxels, static_cast<double>(voxels) * image.voxel_volume()));
  };
  for (const auto& row : LabelTable::rows())
    for (const long value : table.*row.values) {
      is_named[value] = true;
      line(value, row.name, counts.contains(value) ? counts.at(value) : 0);
    }
  std::size_t others = 0;
  for (const auto& [value, voxels] : counts) {
    if (value == 0 || is_named.contains(value)) continue;
    if (++others <= 20) line(value, "(not used)", voxels);
  }
  if (others > 20) lines.push_back(fmt::format("and {} more labels that are not used", others - 20));
  return lines;
}

}  // namespace mv
