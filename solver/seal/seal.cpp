// SPDX-License-Identifier: BSD-3-Clause
#include "solver/seal/seal.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

#include "geometry/core/errors.h"
#include "solver/seal/holes.h"
#include "solver/seal/place_names.h"
#include "solver/seal/polygon.h"
#include "solver/seal/voxel_field.h"
#include "solver/seal/widest_path.h"

namespace mv {

namespace {

void check_surface(const SealInput& input) {
  const int n = static_cast<int>(input.points.size());
  std::map<std::pair<int, int>, int> balance;
  for (const auto& t : input.triangles)
    for (std::size_t e = 0; e < 3; ++e) {
      const int a = t[e], b = t[(e + 1) % 3];
      if (a < 0 || a >= n) throw InputError("seal: triangle names point " + std::to_string(a) + " of " + std::to_string(n));
      if (!input.points[static_cast<std::size_t>(a)].allFinite())
        throw InputError("seal: leaflet point " + std::to_string(a) + " is not finite");
      balance[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  for (const auto& [edge, count] : balance)
    if (count != 0)
      throw InputError("seal: the leaflet surface is not closed and consistently oriented at edge " + std::to_string(edge.first) +
                       "-" + std::to_string(edge.second) + "; give the whole boundary of the solid");
}

void check(const SealInput& input, const SealOptions& options) {
  check_surface(input);
  if (!input.region.empty() && input.region.size() != input.points.size())
    throw InputError("seal: region needs one entry per point");
  if (!input.unfolded.empty() && input.unfolded.size() != input.points.size())
    throw InputError("seal: unfolded needs one entry per point");
  if (input.tube.cross_section.size() < 3 || !(std::abs(seal::signed_area(input.tube.cross_section)) > 0))
    throw InputError("seal: the tube's cross-section encloses no area");
  if (!(input.tube.z_atrium > input.tube.z_ventricle))
    throw InputError("seal: the tube's atrial end must lie above its ventricular end");
  if (input.annulus.size() < 3) throw InputError("seal: the annulus needs at least three points");
  for (const Vec3& p : input.annulus)
    if (!p.allFinite()) throw InputError("seal: an annulus point is not finite");
  if (!(options.spacing_mm > 0)) throw InputError("seal: the voxel spacing must be positive");
}

SealingThreshold threshold_of(const seal::Passage& passage, const seal::VoxelField& field, const seal::PlaceNames& names) {
  SealingThreshold out;
  out.value_mm = 2 * passage.upper;
  out.lower_mm = 2 * passage.lower;
  if (passage.upper > 0 && std::isfinite(passage.upper)) {
    out.place = field.to_world(passage.place);
    out.location = names.at(out.place).location;
  }
  return out;
}

/// Distances are exact in a band that covers the threshold and a few voxels around it.
double exact_band(double threshold, const SealOptions& options) {
  return std::max(0.5 * threshold, 0.5) + 2 * options.spacing_mm;
}

}  // namespace

SealResult find_seal(const SealInput& input, double threshold_mm, const SealOptions& given) {
  const auto start = std::chrono::steady_clock::now();
  if (!(threshold_mm > 0) || !std::isfinite(threshold_mm)) throw InputError("seal: the contact threshold must be positive");
  SealOptions options = given;
  options.margin_mm = std::max(given.margin_mm, 0.5 * threshold_mm + 4 * given.spacing_mm);
  check(input, options);
  const seal::VoxelField field(input, options, exact_band(threshold_mm, options));
  const seal::PlaceNames names(input);

  SealResult result;
  result.threshold_mm = threshold_mm;
  result.spacing_mm = options.spacing_mm;
  result.voxels = field.grid().size();
  result.smallest = threshold_of(seal::find_widest_passage(field), field, names);
  result.sealed = result.smallest.value_mm < threshold_mm;
  result.certain = result.sealed || result.smallest.lower_mm >= threshold_mm;
  if (!result.certain)
    result.warnings.push_back(
        "the threshold lies within the resolution of the smallest sealing threshold; a finer seal spacing decides");
  if (!result.sealed) {
    for (const seal::Opening& opening : seal::find_openings(field, threshold_mm, options)) {
      Hole hole;
      hole.place = field.to_world(opening.place);
      hole.area_mm2 = opening.area;
      hole.area_error_mm2 = opening.area_error;
      hole.width_mm = opening.width;
      const seal::PlaceName name = names.at(hole.place);
      hole.location = name.location;
      hole.region = name.region;
      hole.u_mm = name.u;
      if (opening.area_error > 2 * options.cut_gap * opening.area + 1e-9)
        result.warnings.push_back("the area of hole " + std::to_string(result.holes.size()) + " did not converge: between " +
                                  std::to_string(opening.area - opening.area_error) + " and " + std::to_string(opening.area) +
                                  " mm2");
      result.hole_area_mm2 += hole.area_mm2;
      result.holes.push_back(std::move(hole));
    }
    if (result.holes.empty())
      result.warnings.push_back("not sealed, but no hole is as wide as a voxel; a finer seal spacing shows it");
  }
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

SealingThreshold smallest_sealing_threshold(const SealInput& input, const SealOptions& options) {
  check(input, options);
  const seal::VoxelField field(input, options, exact_band(0, options));
  return threshold_of(seal::find_widest_passage(field), field, seal::PlaceNames(input));
}

}  // namespace mv
