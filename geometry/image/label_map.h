// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Which label of a map is what: presets, tables of one's own, counts, and the clean union of the two leaflets.

#include <map>
#include <string>
#include <vector>

#include "geometry/image/label_image.h"

namespace mv {

/// Label values per part; a part may have several values, or none.
struct LabelTable {
  std::vector<long> posterior, anterior;
  std::vector<long> papillary_anterolateral, papillary_posteromedial;
  std::vector<long> papillary;  // both muscles, or not known which
  std::vector<long> atrium, ventricle, aorta;

  struct Row {
    const char* name;
    std::vector<long> LabelTable::*values;
  };
  static const std::vector<Row>& rows();
};

/// mvseg2023: 1 posterior, 2 anterior. slicerheart: 1 anterior, 2 posterior. visible_human: 1 posterior, 2 anterior, 3 anterolateral and 4
/// posteromedial papillary muscle, 5 left atrium, 6 left ventricle. own: nothing. Throws ConfigError for another name.
LabelTable label_preset(const std::string& name);

/// The preset with every non-empty part of `own` in place of its own. Throws ConfigError when a leaflet has no label, a label is 0 (the
/// background) or belongs to two parts.
LabelTable merged_table(const std::string& preset, const LabelTable& own);

/// Voxels per label value, background included.
std::map<long, long> label_counts(const LabelImage& image);

/// "1 posterior: 13866 voxels, 1733 mm3" and so on, one line a label, labels without a part included.
std::vector<std::string> describe_labels(const LabelImage& image, const LabelTable& table);

/// Parts as small numbers, so that nobody has to look up tables again.
enum class Part : std::uint8_t { none, posterior, anterior, papillary_anterolateral, papillary_posteromedial, papillary, atrium, ventricle, aorta };

struct LabelledParts {
  LabelImage image;                // values are Part; cropped to all named parts
  std::array<int, 3> low{}, high{};  // box of the leaflets in `image`
  std::vector<std::string> notes;
};

struct PartOptions {
  double island_share = 0.05;  // groups of leaflet voxels (26 neighbours) below this share of the largest are removed
};

/// Applies the table, removes small islands of the leaflets (counted in the notes), fills bubbles inside them, and checks that both leaflets
/// are there. Throws InputError with the counts of what is there for an absent or empty leaflet, a map of one label only, leaflets of a few
/// voxels, an implausible size of the valve (units), or more than two large groups.
LabelledParts label_parts(const LabelImage& image, const LabelTable& table, const PartOptions& options, const std::string& name);

}  // namespace mv
