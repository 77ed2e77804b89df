// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// How alike the geometries of two cases are: mid-surfaces, annulus planes, areas.

#include <filesystem>
#include <string>
#include <vector>

#include "geometry/loft/surface_distance.h"

namespace mv {

/// What a case is measured by.
struct CaseGeometry {
  std::string name;
  double area = 0, area_anterior = 0, area_posterior = 0;  // mm2, mid-surface
  double perimeter = 0;                                    // mm, of the annulus
  Vec3 annulus_normal = Vec3::Zero(), annulus_center = Vec3::Zero();
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;
};

/// Reads mid_surface.vtp and annulus.vtp. Throws IoError when the case lacks them (naming the command), InputError when damaged.
CaseGeometry read_case_geometry(const std::filesystem::path& case_directory);

struct CaseComparison {
  std::string a, b;
  SurfaceDistance distance;        // mm, mid-surfaces, both directions
  double normal_angle = 0;         // degrees between the annulus normals
  double center_distance = 0;      // mm between the annulus centres
  double area_difference = 0, area_difference_anterior = 0, area_difference_posterior = 0;  // 100 (b - a) / a, per cent
  double perimeter_difference = 0;                                                          // per cent
};
CaseComparison compare_geometry(const CaseGeometry& a, const CaseGeometry& b);

/// One line a pair, with a header; lengths mm, angles degrees, differences per cent of the first of the pair.
std::string comparison_csv(const std::vector<CaseComparison>& comparisons);

/// `mvprep compare CASE CASE...`: every pair, as a table on stdout and, when named, as CSV. Throws UsageError for fewer than two cases.
void compare_command(const std::vector<std::filesystem::path>& cases, const std::filesystem::path& csv);

}  // namespace mv
