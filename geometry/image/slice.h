// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Segmented slices in space, from an image stack or from a folder of PNG files.

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

/// What a pixel shows. `leaflet`: one of the leaflets, not known which (binary masks).
enum class SlicePart : std::uint8_t { none, posterior, anterior, leaflet, papillary_anterolateral, papillary_posteromedial, papillary, atrium, ventricle };

/// One slice; pixel (column i, row j) has its centre at origin + i * step_x + j * step_y (mm, RAS).
struct Slice {
  std::string name;  // for messages
  int width = 0, height = 0;
  std::vector<std::uint8_t> parts;  // SlicePart, row by row
  Vec3 origin = Vec3::Zero(), step_x = Vec3::UnitX(), step_y = Vec3::UnitY();

  SlicePart at(int i, int j) const { return static_cast<SlicePart>(parts[static_cast<std::size_t>(j) * static_cast<std::size_t>(width) + static_cast<std::size_t>(i)]); }
  Vec3 world(double i, double j) const { return origin + i * step_x + j * step_y; }
  Vec3 normal() const { return step_x.cross(step_y).normalized(); }
};

/// Grey values with their place, before anyone knows what they mean.
struct GreySlice {
  Slice place;  // without parts
  std::vector<std::int32_t> values;
};

/// Where PNG slices lie, when slices.csv does not say.
struct PngPlacement {
  std::optional<std::array<double, 2>> pixel_spacing;  // mm, along a row and down a column
  std::optional<double> slice_spacing;                 // mm
  Vec3 position = Vec3::Zero();                        // centre of the first slice's top left pixel
  Vec3 row = Vec3::UnitX(), column = Vec3::UnitY();    // directions along a row and down a column
  bool is_lps = false;                                 // of position and directions, also those of slices.csv
};

/// Every .png of the folder, in natural order of their names (2 before 10), or in that of slices.csv: columns file, x_mm, y_mm, z_mm (centre of the top left pixel),
/// optionally row_x, row_y, row_z, column_x, column_y, column_z, spacing_x_mm, spacing_y_mm. Without slices.csv the slices are stacked along row x column.
/// Greyscale of 8 or 16 bits, or colour with equal channels. Throws ConfigError for a missing spacing (naming the key), InputError for an unreadable or coloured
/// picture, pictures of different sizes, a file named twice or missing, directions that are not perpendicular; IoError when the folder holds no PNG.
std::vector<GreySlice> read_png_slices(const std::filesystem::path& folder, const PngPlacement& placement);

}  // namespace mv
