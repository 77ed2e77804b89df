// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/image/label_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <unordered_map>

#include "geometry/core/errors.h"

namespace mv {
namespace {

constexpr double smallest_valve = 10, largest_valve = 150;  // mm, largest extent of the leaflets: a newborn's 15, a dilated adult's 70
constexpr long fewest_voxels = 60;                           // of one leaflet
constexpr long fewest_layers = 2;                            // of the leaflets along each axis of the image

bool is_leaflet(std::int32_t part) {
  return part == static_cast<std::int32_t>(Part::posterior) || part == static_cast<std::int32_t>(Part::anterior);
}

struct Box {
  std::array<int, 3> low{1 << 30, 1 << 30, 1 << 30}, high{-1, -1, -1};
  void add(int i, int j, int k) {
    const std::array<int, 3> x{i, j, k};
    for (std::size_t a = 0; a < 3; ++a) low[a] = std::min(low[a], x[a]), high[a] = std::max(high[a], x[a]);
  }
  bool is_empty() const { return high[0] < 0; }
};

template <class Take>
Box box_where(const LabelImage& image, Take&& take) {
  Box box;
  std::size_t v = 0;
  for (int k = 0; k < image.size[2]; ++k)
    for (int j = 0; j < image.size[1]; ++j)
      for (int i = 0; i < image.size[0]; ++i, ++v)
        if (take(image.values[v])) box.add(i, j, k);
  return box;
}

std::unordered_map<std::int32_t, Part> part_of_label(const LabelTable& table) {
  std::unordered_map<std::int32_t, Part> part;
  int p = 1;
  for (const auto& row : LabelTable::rows()) {
    for (const long value : table.*row.values) part[static_cast<std::int32_t>(value)] = static_cast<Part>(p);
    ++p;
  }
  return part;
}

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const auto& line : lines) text += "\n    " + line;
  return text;
}

void check_leaflets_exist(const LabelImage& image, const LabelTable& table, const std::string& name) {
  const auto counts = label_counts(image);
  if (counts.size() == 1)
    throw InputError(fmt::format("{}: every voxel has the value {}; a label map needs a background of 0 and the leaflets' labels", name, counts.begin()->first));
  for (const auto& [part, values] : {std::pair{"posterior", table.posterior}, std::pair{"anterior", table.anterior}}) {
    long voxels = 0;
    std::string wanted;
    for (const long value : values) {
      if (counts.contains(value)) voxels += counts.at(value);
      wanted += (wanted.empty() ? "" : ", ") + std::to_string(value);
    }
    if (voxels >= fewest_voxels) continue;
    const std::string what = voxels == 0 ? "no voxel has" : fmt::format("only {} voxels (at least {} needed) have", voxels, fewest_voxels);
    throw InputError(fmt::format("{}: {} the {} leaflet's label ({}). The map holds:{}\n  Check labels.preset, or set labels.{} to the right label", name, what,
                                 part, wanted, joined(describe_labels(image, table)), part));
  }
  if (!counts.contains(0))
    throw InputError(name + ": no voxel is background (0); the labels fill the whole image:" + joined(describe_labels(image, table)));
}

/// Numbers the connected groups of voxels that `inside` takes; 0 elsewhere. Returns their sizes, groups counted from 1.
template <class Inside>
std::vector<long> group(const LabelImage& image, Inside&& inside, bool with_corners, std::vector<std::int32_t>& number) {
  number.assign(image.values.size(), 0);
  std::vector<long> sizes(1, 0);
  std::vector<std::array<int, 3>> open;
  for (int k = 0; k < image.size[2]; ++k)
    for (int j = 0; j < image.size[1]; ++j)
      for (int i = 0; i < image.size[0]; ++i) {
        if (number[image.index(i, j, k)] != 0 || !inside(image.at(i, j, k))) continue;
        const auto id = static_cast<std::int32_t>(sizes.size());
        sizes.push_back(0);
        open.assign(1, {i, j, k});
        number[image.index(i, j, k)] = id;
        while (!open.empty()) {
          const auto at = open.back();
          open.pop_back();
          ++sizes.back();
          for (int n = 0; n < 27; ++n) {
            const std::array<int, 3> d{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
            if (!with_corners && std::abs(d[0]) + std::abs(d[1]) + std::abs(d[2]) != 1) continue;
            const std::array<int, 3> x{at[0] + d[0], at[1] + d[1], at[2] + d[2]};
            if (x[0] < 0 || x[1] < 0 || x[2] < 0 || x[0] >= image.size[0] || x[1] >= image.size[1] || x[2] >= image.size[2]) continue;
            const std::size_t v = image.index(x[0], x[1], x[2]);
            if (number[v] != 0 || !inside(image.values[v])) continue;
            number[v] = id;
            open.push_back(x);
          }
        }
      }
  return sizes;
}

/// Two large groups that both hold a good share of both leaflets are two valves.
void refuse_two_valves(const LabelImage& image, const std::vector<std::int32_t>& number, const std::vector<bool>& is_kept, const std::string& name) {
  std::vector<std::array<long, 2>> counts(is_kept.size(), {0, 0});
  for (std::size_t v = 0; v < number.size(); ++v)
    if (number[v] != 0) ++counts[static_cast<std::size_t>(number[v])][image.values[v] == static_cast<std::int32_t>(Part::anterior)];
  std::string found;
  int complete = 0;
  for (std::size_t g = 1; g < counts.size(); ++g) {
    if (!is_kept[g] || std::min(counts[g][0], counts[g][1]) < (counts[g][0] + counts[g][1]) / 5) continue;
    ++complete;
    found += fmt::format("\n    {} posterior and {} anterior voxels", counts[g][0], counts[g][1]);
  }
  if (complete > 1) throw InputError(name + ": two separate valves, each with both leaflets, so two annuli:" + found + "\n  Remove one of them from the map");
}

void remove_islands(LabelledParts& parts, const PartOptions& options, const std::string& name) {
  std::vector<std::int32_t> number;
  const auto sizes = group(parts.image, is_leaflet, true, number);
  const long largest = *std::max_element(sizes.begin(), sizes.end());
  std::vector<bool> is_kept(sizes.size(), false);
  std::string kept_sizes;
  long kept = 0, removed = 0, voxels = 0;
  for (std::size_t g = 1; g < sizes.size(); ++g) {
    is_kept[g] = static_cast<double>(sizes[g]) >= options.island_share * static_cast<double>(largest);
    if (is_kept[g]) ++kept, kept_sizes += (kept_sizes.empty() ? "" : ", ") + std::to_string(sizes[g]);
    else ++removed, voxels += sizes[g];
  }
  for (std::size_t v = 0; v < number.size(); ++v)
    if (number[v] != 0 && !is_kept[static_cast<std::size_t>(number[v])]) parts.image.values[v] = 0;
  if (removed > 0) parts.notes.push_back(fmt::format("{} islands of {} leaflet voxels in all removed", removed, voxels));
  if (kept > 2)
    throw InputError(fmt::format("{}: the leaflets fall into {} large separate groups ({} voxels): at most two, one a leaflet, can be. A second valve under the "
                                 "same labels, or a torn segmentation: remove or join the parts, or raise labels.island_share", name, kept, kept_sizes));
  refuse_two_valves(parts.image, number, is_kept, name);
  if (kept == 2) parts.notes.push_back("the two leaflets do not touch");
}

/// Background enclosed by leaflet voxels (6 neighbours) becomes leaflet, by the label of a neighbour.
void fill_bubbles(LabelledParts& parts) {
  LabelImage& image = parts.image;
  std::vector<std::int32_t> number;
  const auto sizes = group(image, [](std::int32_t v) { return !is_leaflet(v); }, false, number);
  if (sizes.size() <= 2) return;
  std::vector<bool> is_open(sizes.size(), false);
  std::vector<std::int32_t> wall(sizes.size(), 0);
  for (int k = 0; k < image.size[2]; ++k)
    for (int j = 0; j < image.size[1]; ++j)
      for (int i = 0; i < image.size[0]; ++i) {
        const std::size_t v = image.index(i, j, k);
        const auto g = static_cast<std::size_t>(number[v]);
        if (g == 0) continue;
        if (i == 0 || j == 0 || k == 0 || i + 1 == image.size[0] || j + 1 == image.size[1] || k + 1 == image.size[2] || image.values[v] != 0) is_open[g] = true;
        if (i > 0 && is_leaflet(image.values[v - 1])) wall[g] = image.values[v - 1];
      }
  long bubbles = 0, voxels = 0;
  for (std::size_t g = 1; g < sizes.size(); ++g)
    if (!is_open[g]) ++bubbles, voxels += sizes[g];
  for (std::size_t v = 0; v < number.size(); ++v)
    if (number[v] != 0 && !is_open[static_cast<std::size_t>(number[v])]) image.values[v] = wall[static_cast<std::size_t>(number[v])];
  if (bubbles > 0) parts.notes.push_back(fmt::format("{} bubbles of {} voxels in all inside the leaflets filled", bubbles, voxels));
}

void check_extent(const LabelledParts& parts, const std::string& name) {
  Vec3 low = Vec3::Constant(1e300), high = -low;
  for (int corner = 0; corner < 8; ++corner) {
    const auto at = [&](std::size_t a) { return corner >> a & 1 ? parts.high[a] : parts.low[a]; };
    const Vec3 x = parts.image.axes * Vec3(at(0), at(1), at(2));
    low = low.cwiseMin(x), high = high.cwiseMax(x);
  }
  const double extent = (high - low).maxCoeff();
  if (extent < smallest_valve || extent > largest_valve)
    throw InputError(fmt::format("{}: the leaflets are {:.3g} mm wide, a mitral valve has {} to {} mm; voxels are {:.4g} x {:.4g} x {:.4g} mm. Check the affine and the "
                                 "unit of length in the header (labels.unit, labels.transform)", name, extent, smallest_valve, largest_valve,
                                 parts.image.spacing()[0], parts.image.spacing()[1], parts.image.spacing()[2]));
  for (std::size_t a = 0; a < 3; ++a)
    if (parts.high[a] - parts.low[a] + 1 < fewest_layers)
      throw InputError(name + ": the leaflets lie in a single slice; a label map needs a volume (slices: source.kind = \"curves\")");
}

void note_cut_leaflets(LabelledParts& parts, const LabelImage& original, const std::array<int, 3>& offset) {
  long cut = 0;
  for (int k = 0; k < parts.image.size[2]; ++k)
    for (int j = 0; j < parts.image.size[1]; ++j)
      for (int i = 0; i < parts.image.size[0]; ++i) {
        if (!is_leaflet(parts.image.at(i, j, k))) continue;
        const std::array<int, 3> x{i + offset[0], j + offset[1], k + offset[2]};
        for (std::size_t a = 0; a < 3; ++a)
          if (x[a] == 0 || x[a] + 1 == original.size[a]) {
            ++cut;
            break;
          }
      }
  if (cut > 0) parts.notes.push_back(fmt::format("{} leaflet voxels touch the border of the image: the valve may be cut off there", cut));
}

}  // namespace

LabelledParts label_parts(const LabelImage& image, const LabelTable& table, const PartOptions& options, const std::string& name) {
  check_leaflets_exist(image, table, name);
  const auto part = part_of_label(table);
  const Box named = box_where(image, [&](std::int32_t v) { return v != 0 && part.contains(v); });
  LabelledParts parts;
  parts.image = cropped(image, named.low, named.high);
  for (std::int32_t& value : parts.image.values) {
    const auto at = value == 0 ? part.end() : part.find(value);
    value = at == part.end() ? 0 : static_cast<std::int32_t>(at->second);
  }
  remove_islands(parts, options, name);
  fill_bubbles(parts);
  for (const auto& row : {std::pair{"posterior", Part::posterior}, std::pair{"anterior", Part::anterior}})
    if (std::count(parts.image.values.begin(), parts.image.values.end(), static_cast<std::int32_t>(row.second)) < fewest_voxels)
      throw InputError(fmt::format("{}: after removing islands hardly anything of the {} leaflet is left; the label is scattered. Check the segmentation, or lower "
                                   "labels.island_share", name, row.first));
  const Box leaflets = box_where(parts.image, is_leaflet);
  parts.low = leaflets.low;
  parts.high = leaflets.high;
  check_extent(parts, name);
  note_cut_leaflets(parts, image, named.low);
  return parts;
}

}  // namespace mv
