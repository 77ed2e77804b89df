// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Collagen directions of the leaflets (papers/s2, section 3): one family, parallel to the annulus, following arcs of a fixed shape or
// drawn by hand, or continuing the chordae into the leaflet (which s2 leaves as future work).
// A fibre has no sign: +f and -f are the same. Directions are therefore diffused as z = exp(2 i phi), phi the angle in the
// tangent plane (fibers/nematic.h), and everything here gives the same result when an input is negated.

#include <string>
#include <string_view>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

enum class FiberModel { none, parallel, arc, outline, chordae };

/// |sin| of the angle between sheet normal and annulus normal below which "parallel to the annulus" has no direction.
inline constexpr double flat_sine = 0.1;

/// By its name; throws ConfigError otherwise.
FiberModel fiber_model_from_name(std::string_view name);

/// Arcs of one leaflet on the flat pattern. With t in [-1, 1] across the leaflet (u), H its largest height and h(t) the height of
/// its border, the guide runs from the border at t = -end through (0, apex H) to the border at t = +end:
///   v(t) = v_a + (h(end) - v_a) |t/end|^power,    v_a = min(apex H, 0.8 lowest h between the ends)
/// convex towards the annulus, so that it joins the two groups of chordae ends left and right.
struct ArcShape {
  double end = 0.7;    // where the guide meets the border, share of the half width; 0 < end < 1
  double apex = 0.45;  // distance of its middle from the annulus, share of the leaflet's height; 0 < apex < 1
  double power = 2.0;  // 2 parabola; larger: flatter middle and steeper ends; at least 1
};

struct FiberOptions {
  FiberModel model = FiberModel::arc;
  ArcShape anterior{};
  ArcShape posterior{0.85, 0.3, 4.0};
  double border_middle = 0.25;  // share of the half width where fibres at the border are parallel to the annulus; 0: leave free
  bool guide_from_chordae = false;  // arc: the guide's ends are the mean places of the chordae ends left and right of the middle
  const Chordae* chordae = nullptr;             // for guide_from_chordae and FiberModel::chordae
  std::vector<std::vector<Vec3>> outlines;      // mm, FiberModel::outline: curves drawn on the leaflets
  double outline_reach = 3.0;                   // mm, largest distance of a drawn curve from the leaflets
};

/// Parallel to the annulus plane: f = normal x sheet_normal. Where the leaflet itself is parallel to that plane (|sin| < 0.1) the
/// direction is undefined and is filled in by diffusion from the rest of the leaflet. `normal`: unit normal of the annulus plane,
/// either sign. One unit vector per element. Throws InputError (missing sheet normals, or no element with a direction).
std::vector<Vec3> parallel_fibers(const LeafletMesh& mesh, const Vec3& normal);

/// Arcs: each leaflet by itself. Given: along the annulus on the annulus row, along the guide arc, in the middle of the border
/// along u, and where the guide meets the border beyond its ends, perpendicular to the border (commissure rule); the rest by
/// diffusion. Outline: along the drawn curves instead of the guide; a leaflet without a drawn curve takes its arc. Chordae: where a
/// chorda holds the leaflet along its last segment, along the annulus on the annulus row and in the unheld middle of the border. Needs
/// `unfolded`, `on_annulus`, `on_free_edge`. One unit vector per element.
std::vector<Vec3> arc_fibers(const LeafletMesh& mesh, const FiberOptions& options);

/// Fills mesh.fibre (zero vectors for FiberModel::none).
void assign_fibers(LeafletMesh& mesh, const Annulus& annulus, const FiberOptions& options);

struct FiberReport {
  int elements = 0;
  int non_finite = 0;
  double unit_error_max = 0;     // | |f| - 1 |
  double tangent_error_max = 0;  // |f . sheet_normal|
  int first_bad_element = -1;
  bool passed = false;
  std::string message;  // empty when passed, otherwise element and reason
};

/// Unit, finite, tangent to the mid-surface within `tolerance`. With FiberModel::none, passes when every entry is zero.
FiberReport check_fibers(const LeafletMesh& mesh, FiberModel model, double tolerance = 1e-6);

}  // namespace mv
