// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Annulus plane by principal component analysis, its metrics, and the papillary tips that belong to it (mm, RAS).

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "geometry/annulus/closed_curve.h"
#include "geometry/core/case.h"

namespace mv {

/// Points from a CSV file with the header x_mm,y_mm,z_mm (other columns are ignored, the three may stand in any order).
/// Throws IoError when unreadable, InputError naming file, line and column otherwise.
std::vector<Vec3> read_points_csv(const std::filesystem::path& file);

/// What decides the sign of the normal, tried in this order.
struct NormalHints {
  std::optional<Vec3> ventricle_direction;  // any vector with a positive component from atrium to ventricle
  std::vector<Vec3> papillary_points;       // lie on the ventricular side
};

/// Plane fit of a closed ordered curve. Points are weighted by the arc length they stand for, so uneven sampling does not tilt
/// the plane. Covariance C = sum w (x-m)(x-m)^T / sum w; normal = eigenvector of the smallest eigenvalue, axis_major of the
/// largest. residual_rms: plain root mean square over the points. Sign of the normal (atrium to ventricle): the hint, else
/// towards the mean of the papillary points, else -z; `sign_rule` says which: "given direction", "papillary points", "assumed -z
/// (superior is atrial)". `points` is the curve as given. Throws InputError for fewer than 8 points, a degenerate (straight)
/// curve, or hints that lie in the plane.
Annulus fit_annulus(const std::vector<Vec3>& closed_curve, const NormalHints& hints);
/// The plane alone: the sign of the normal means nothing, sign_rule is empty.
Annulus fit_annulus_plane(const std::vector<Vec3>& closed_curve);

/// Two papillary tips. More than two points are split into two groups (2-means started from the two farthest points), each tip
/// being its group's mean. Names: seen from the atrium with the anterior leaflet up, the anterolateral tip is on the left: side =
/// anterior x normal. Order: anterolateral, posteromedial. Throws InputError for fewer than two distinct points.
Papillary group_papillary_points(const std::vector<Vec3>& points, const Annulus& annulus, const Vec3& anterior_direction);

/// Unit vector in the annulus plane towards the middle of the anterior leaflet, with the rule that chose it.
struct AnteriorDirection {
  Vec3 direction = Vec3::UnitY();
  std::string rule;       // "given" | "papillary tips lie posterior" | "anterior horn is higher" (when the tips do not tell)
  double confidence = 0;  // mm: by how far the deciding quantity lies from a tie
};
/// Perpendicular to the papillary line in the plane; the papillary tips lie posterior of the centre. Throws InputError when the
/// tips coincide.
AnteriorDirection find_anterior_direction(const Annulus& annulus, const std::vector<Vec3>& papillary_points,
                                          const std::optional<Vec3>& given = std::nullopt);

/// Named as SlicerHeart's annulus quantification names them.
struct AnnulusMetrics {
  double perimeter = 0;       // mm, along the space curve ("annulus circumference")
  double perimeter_2d = 0;    // mm, of the projection on the plane
  double ap_diameter = 0;     // mm, in-plane extent along the anterior direction through the centre
  double al_pm_diameter = 0;  // mm, in-plane extent perpendicular to it through the centre
  double sphericity = 0;      // ap_diameter / al_pm_diameter
  double height = 0;          // mm, extent along the normal
  double height_above = 0;    // mm, highest point over the plane, towards the atrium
  double height_below = 0;    // mm, lowest point under it
  double area_2d = 0;         // mm2, of the projection
  double area_3d =
      0;  // mm2, of the soap-film-like surface spanned by the curve (harmonic height; slightly above the minimal area)
  double height_to_al_pm = 0;  // annulus height / commissural width
};
AnnulusMetrics measure_annulus(const Annulus& annulus, const Vec3& anterior_direction);

}  // namespace mv
