// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Scalars of a closed or open valve: bulging, orifice, coaptation, swept volume. Lengths in mm; "up" is the unit vector from
// ventricle to atrium (= -annulus normal); `origin` is a point of the annulus plane. Height h(x) = up . (x - origin).

#include <array>
#include <span>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

struct AnnulusPlane {
  Vec3 origin = Vec3::Zero();
  Vec3 up = Vec3::UnitZ();
};

using Triangles = std::vector<std::array<int, 3>>;

struct Bulging {
  double area_mm2 = 0;    // part of the surface above the plane (triangles are cut exactly)
  double area_ratio = 0;  // over the whole area of the surface
  double volume_ml = 0;   // between that part and the plane
  double height_mm = 0;   // highest point above the plane, 0 when all lies below
};

/// Bulging of an oriented surface (the atrial faces, normals towards the atrium; papers/s2, figure 3). The volume is the integral
/// of h (n . up) over the part above the plane: folds cancel as they should. The annulus of a saddle-shaped valve lies partly
/// above its own plane; what this contributes is in the result.
Bulging measure_bulging(std::span<const Vec3> points, const Triangles& triangles, const AnnulusPlane& plane);

/// Volume (mm3) between an oriented surface and the annulus plane: integral of h (n . up). Negative below the plane.
double volume_under_surface(std::span<const Vec3> points, const Triangles& triangles, const AnnulusPlane& plane);

/// Volume (mm3) that an oriented surface sweeps while its points move on straight lines from x0 to x1; positive along its
/// normals:
///     sum over triangles of integral_0^1 a(t) . (d0 + d1 + d2) / 3 dt,   a(t) = area vector, a quadratic in t (Simpson is
///     exact).
/// For a closed surface this is the change of the enclosed volume; an open one may end anywhere.
double swept_volume(std::span<const Vec3> x0, std::span<const Vec3> x1, const Triangles& triangles);

/// Enclosed volume (mm3) of a closed, outward oriented surface.
double enclosed_volume(std::span<const Vec3> points, const Triangles& triangles);

/// The closed loops of boundary edges of a surface whose ends both carry the flag, as point indices in the order of the
/// triangles' orientation, longest first. Open chains are closed by the straight line between their ends.
std::vector<std::vector<int>> flagged_boundary_loops(const Triangles& triangles, std::span<const char> flagged);

/// Orifice area (cm2): the free edge projected on the annulus plane, counting the part around which it winds in the same sense as
/// `reference_loop` (the same points in the open state). Where the leaflets overlap the loop winds backwards or not at all and
/// counts as closed. Exact for polygons, self-crossing ones included.
double orifice_area_cm2(std::span<const Vec3> loop, std::span<const Vec3> reference_loop, const AnnulusPlane& plane);

/// Area of the points around which a closed polygon winds at least once in the counter-clockwise sense.
double positively_wound_area(std::span<const Vec2> polygon);

struct Coaptation {
  bool present = false;
  double depth_mm = 0;   // from the plane down to the uppermost contact (negative: above the plane)
  double height_mm = 0;  // from the uppermost to the lowest contact, along `up`
};

/// Coaptation over the points in contact whose u lies in [u_from, u_to] (for example the middle third of the anterior leaflet).
Coaptation measure_coaptation(std::span<const Vec3> points, std::span<const Vec2> unfolded, std::span<const char> in_contact,
                              double u_from, double u_to, const AnnulusPlane& plane);

}  // namespace mv
