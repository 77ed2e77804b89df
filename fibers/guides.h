// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Where the models give a fibre direction, before diffusion fills in the rest, and how well a field keeps to it.

#include <string>
#include <vector>

#include "fibers/fiber_field.h"
#include "fibers/nematic.h"

namespace mv {

struct GuidePoint {
  GivenDirection given;
  const char* rule = "";  // "annulus" | "guide" | "border middle" | "commissure" | "outline" | "chordae"
  int region = 0;         // Region
};

/// Given directions of the models arc, outline and chordae on one leaflet; empty when the mesh has no such leaflet. Throws
/// InputError (arrays, an outline away from the leaflets).
std::vector<GuidePoint> guide_points(const LeafletMesh& mesh, int region, const FiberOptions& options);

/// The same for every leaflet; for the model parallel, annulus x sheet normal at every node.
std::vector<GuidePoint> all_guide_points(const LeafletMesh& mesh, const Annulus& annulus, const FiberOptions& options);

struct RuleDeviation {
  std::string rule;
  int region = 0;
  int points = 0;
  double mean_deg = 0, max_deg = 0;  // angle between the rule and the field at its nodes
};

/// Field at a node: volume-weighted mean without sign of mesh.fibre in the elements around it (of the guide's region), in the tangent plane.
/// One row a rule and leaflet, in order of appearance.
std::vector<RuleDeviation> deviation_from_rules(const LeafletMesh& mesh, const std::vector<GuidePoint>& guides);

/// Mean angle (degrees, 0 to 90) of the fibres of one leaflet to the annulus plane.
double mean_angle_to_annulus(const LeafletMesh& mesh, const Annulus& annulus, int region);

}  // namespace mv
