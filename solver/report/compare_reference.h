// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A closed valve beside another program's answer for it (`mvsolve compare-reference`). Lengths mm.
//
//   distance   of each node of the computed mid-surface from the reference surface (closest point of its triangles)
//   node       of the same node in both answers, when the reference has the same nodes in the same order; that it has is checked by its displacements
//   Dice       2 |A and B| / (|A| + |B|) of the sets of nodes in contact

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "geometry/core/case.h"
#include "solver/output/frame_reader.h"
#include "solver/report/raster.h"
#include "solver/report/reference_surface.h"

namespace mv {

/// The leaflets' mid-surface: half way between the faces, column by column, in the order of the mesh.
struct MidNodes {
  std::vector<Vec3> rest, current;
  std::vector<std::array<int, 3>> triangles;  // seen from the atrium counter-clockwise
  std::vector<int> region;                    // per triangle
  std::vector<char> in_contact;               // a face of the column carries contact pressure
  std::vector<double> contact_pressure;       // kPa, the larger of the two faces
};
/// Throws InputError when a point of one face has no partner on the other.
MidNodes mid_nodes(const LeafletsFrame& frame);

struct ReferenceComparison {
  std::vector<double> distance;         // per mid node, to the reference surface
  std::vector<double> node_distance;    // per mid node, to the reference's node; empty without correspondence
  std::vector<char> reference_contact;  // per mid node; empty when not known
  double distance_median = 0, distance_p90 = 0, distance_max = 0, distance_mean = 0;
  double node_median = 0, node_p90 = 0, node_max = 0;
  double displacement_max = 0, displacement_mean = 0;                  // computed
  double reference_displacement_max = 0, reference_displacement_mean = 0;
  long contact_nodes = 0, reference_contact_nodes = 0;
  std::optional<double> dice;
  std::string correspondence;           // how nodes were matched, or why not
};

struct ReferenceOptions {
  std::string contact_array;       // point array, above zero in contact; empty: the first whose name holds "contact"
  std::filesystem::path rest;      // the reference at rest, when it carries no displacements
};

/// Throws InputError for an array that is not there.
ReferenceComparison compare_with_reference(const MidNodes& nodes, const ReferenceSurface& reference, const std::string& contact_array,
                                           const ReferenceSurface* reference_rest = nullptr);

/// Distance of each point from a triangulated surface, and the triangle.
std::vector<double> distances_to_surface(const std::vector<Vec3>& points, const std::vector<Vec3>& surface_points, const std::vector<std::array<int, 3>>& triangles);

/// Value below which a share of the values lies (nearest rank); 0 for none.
double percentile(std::vector<double> values, double share);

/// Computed valve, reference and distances, from the atrium and from the ventricle, with contact drawn.
Image draw_comparison(const MidNodes& nodes, const ReferenceSurface& reference, const ReferenceComparison& comparison, const Vec3& annulus_normal);

/// Reads RESULTS (last frame), writes comparison.json, comparison.csv and comparison.png into `output` and returns the comparison. Throws IoError, InputError.
ReferenceComparison compare_results_with_reference(const std::filesystem::path& results, const std::filesystem::path& reference, const std::filesystem::path& output,
                                                   const ReferenceOptions& options = {});

}  // namespace mv
