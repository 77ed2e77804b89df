// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/chordae/chordae_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/chordae/network_builder.h"
#include "geometry/core/config.h"
#include "geometry/core/errors.h"

namespace mv {
namespace {

constexpr double thinnest = 1e-3, thickest = 100;  // mm2, as of chordae.area_*

constexpr std::array<const char*, 5> kind_names{"primary", "secondary", "strut", "basal", "marginal"};

double mm_per(const std::string& unit) {
  const auto lengths = units_of(Dimension::length);
  if (std::find(lengths.begin(), lengths.end(), unit) == lengths.end()) {
    std::string known;
    for (const auto& u : lengths) known += (known.empty() ? "" : ", ") + u;
    throw ConfigError("chordae.file_unit = \"" + unit + "\": not a unit of length; expected one of " + known);
  }
  return unit_factor(unit) / unit_factor("mm");
}

}  // namespace

double area_of_radius(double radius) { return std::numbers::pi * radius * std::abs(radius); }

NetworkBuilder::NetworkBuilder(std::filesystem::path file, const ChordaeFileOptions& options)
    : file_(std::move(file)), scale_(mm_per(options.unit)), weld_(options.weld), flip_(options.space == ChordaeSpace::lps ? -1 : 1) {
  if (!(weld_ > 0)) throw ConfigError("chordae: the weld distance must be positive, got " + std::to_string(weld_));
}

int NetworkBuilder::point(const Vec3& x, const std::string& where) {
  if (!x.allFinite()) throw InputError(file_.string() + ": " + where + " is not finite; expected three numbers");
  const Vec3 p = scale_ * Vec3(flip_ * x.x(), flip_ * x.y(), x.z());
  if (p.cwiseAbs().maxCoeff() > 1e6)
    throw InputError(file_.string() + ": " + where + " lies " + std::to_string(p.norm()) + " mm from the origin; check chordae.file_unit");
  const auto cell = [&](double c) { return static_cast<long>(std::floor(c / weld_)); };
  const long i = cell(p.x()), j = cell(p.y()), k = cell(p.z());
  for (long a = i - 1; a <= i + 1; ++a)
    for (long b = j - 1; b <= j + 1; ++b)
      for (long c = k - 1; c <= k + 1; ++c)
        if (const auto it = cells_.find({a, b, c}); it != cells_.end())
          for (int candidate : it->second)
            if ((raw_.points[static_cast<std::size_t>(candidate)] - p).norm() < weld_) return candidate;
  const int index = static_cast<int>(raw_.points.size());
  raw_.points.push_back(p);
  raw_.is_root.push_back(0);
  raw_.is_leaflet_end.push_back(0);
  cells_[{i, j, k}].push_back(index);
  return index;
}

void NetworkBuilder::segment(int a, int b, const Segment& values, const std::string& where, double area_scale, double length_scale) {
  const auto check = [&](double value, const char* what) {
    if (!std::isnan(value) && !(std::isfinite(value) && value > 0))
      throw InputError(file_.string() + ": " + where + ": " + what + " is " + std::to_string(value) + ", expected a positive number");
  };
  check(values.area, "cross-section");
  check(values.rest_length, "rest_length");
  if (a == b) {
    ++without_length_;
    return;
  }
  if (!seen_.emplace(std::minmax(a, b), static_cast<int>(raw_.segments.size())).second) {
    ++repeated_;
    return;
  }
  const double area = values.area * (area_scale > 0 ? area_scale : scale_ * scale_);
  if (area < thinnest || area > thickest)
    throw InputError(fmt::format("{}: {}: a cross-section of {:.3g} mm2, expected {} to {} mm2: another unit, or a radius for a diameter?", file_.string(), where, area, thinnest, thickest));
  raw_.segments.push_back({a, b});
  raw_.area.push_back(area);
  raw_.rest_length.push_back(values.rest_length * (length_scale > 0 ? length_scale : scale_));
  raw_.kind.push_back(values.kind);
}

RawChordae NetworkBuilder::take() {
  if (raw_.segments.empty()) throw InputError(file_.string() + ": holds no chordae segment; expected lines between two different points");
  if (without_length_ > 0) note(std::to_string(without_length_) + " segments without length left out");
  if (repeated_ > 0) note(std::to_string(repeated_) + " repeated segments left out");
  return std::move(raw_);
}

RawChordae read_chordae_file(const std::filesystem::path& file, const ChordaeFileOptions& options) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (!std::filesystem::is_regular_file(file)) throw IoError("cannot read " + file.string() + ": no such file");
  if (ending == ".vtp" || ending == ".vtk") return read_chordae_vtk(file, options);
  if (ending == ".swc") return read_chordae_swc(file, options);
  if (ending == ".csv") return read_chordae_csv(file, options);
  throw InputError(file.string() + ": unknown kind of chordae file '" + ending + "'; expected .vtp, .vtk, .swc or .csv");
}

ChordaKind chorda_kind_from_name(const std::string& name, const std::string& where) {
  for (std::size_t k = 0; k < kind_names.size(); ++k)
    if (name == kind_names[k]) return static_cast<ChordaKind>(k);
  throw InputError(where + ": kind '" + name + "' is unknown; expected primary, secondary, strut, basal or marginal");
}

const char* chorda_kind_name(ChordaKind kind) { return kind_names[static_cast<std::size_t>(kind)]; }

}  // namespace mv
