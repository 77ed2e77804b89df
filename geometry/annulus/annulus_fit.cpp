// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/annulus/annulus_fit.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/core/errors.h"

namespace mv {
namespace {

/// A curve flatter than this share of its length in the second direction has no plane.
constexpr double degenerate_ratio = 1e-6;
/// |cos| of the angle between hint and normal below which the hint does not decide.
constexpr double in_plane_cosine = 0.05;

Vec3 mean(const std::vector<Vec3>& points) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

/// Half of the two neighbouring chords.
std::vector<double> arc_weights(const std::vector<Vec3>& points) {
  const std::size_t n = points.size();
  std::vector<double> weights(n);
  double total = 0;
  for (std::size_t i = 0; i < n; ++i) {
    weights[i] = 0.5 * ((points[i] - points[(i + n - 1) % n]).norm() + (points[(i + 1) % n] - points[i]).norm());
    total += weights[i];
  }
  for (double& w : weights) w /= total;
  return weights;
}

Vec3 in_plane(const Vec3& v, const Vec3& normal) { return v - v.dot(normal) * normal; }

}  // namespace

Annulus fit_annulus_plane(const std::vector<Vec3>& closed_curve) {
  if (closed_curve.size() < 8) throw InputError("annulus: at least 8 points are needed for a plane");
  for (const Vec3& p : closed_curve)
    if (!p.allFinite()) throw InputError("annulus: a point is not finite");
  Annulus annulus;
  annulus.points = closed_curve;
  const std::vector<double> weights = arc_weights(closed_curve);
  annulus.origin.setZero();
  for (std::size_t i = 0; i < closed_curve.size(); ++i) annulus.origin += weights[i] * closed_curve[i];
  Mat3 covariance = Mat3::Zero();
  for (std::size_t i = 0; i < closed_curve.size(); ++i) {
    const Vec3 d = closed_curve[i] - annulus.origin;
    covariance += weights[i] * d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(covariance);
  annulus.eigenvalues = solver.eigenvalues().reverse();
  if (!(annulus.eigenvalues[0] > 0) || annulus.eigenvalues[1] < degenerate_ratio * annulus.eigenvalues[0])
    throw InputError("annulus: the points lie on a line, no plane can be fitted");
  annulus.normal = solver.eigenvectors().col(0).normalized();
  annulus.axis_major = solver.eigenvectors().col(2).normalized();
  double squares = 0;
  for (const Vec3& p : closed_curve) squares += std::pow((p - annulus.origin).dot(annulus.normal), 2);
  annulus.residual_rms = std::sqrt(squares / static_cast<double>(closed_curve.size()));
  // The largest component of the major axis is positive, so that the frame does not depend on the eigensolver.
  Eigen::Index largest = 0;
  annulus.axis_major.cwiseAbs().maxCoeff(&largest);
  if (annulus.axis_major[largest] < 0) annulus.axis_major = -annulus.axis_major;
  return annulus;
}

Annulus fit_annulus(const std::vector<Vec3>& closed_curve, const NormalHints& hints) {
  Annulus annulus = fit_annulus_plane(closed_curve);
  Vec3 towards = -Vec3::UnitZ();
  annulus.sign_rule = "assumed -z (superior is atrial)";
  if (hints.ventricle_direction) {
    towards = *hints.ventricle_direction;
    annulus.sign_rule = "given direction";
  } else if (!hints.papillary_points.empty()) {
    towards = mean(hints.papillary_points) - annulus.origin;
    annulus.sign_rule = "papillary points";
  }
  const double cosine = towards.norm() > 0 ? annulus.normal.dot(towards) / towards.norm() : 0;
  if (std::abs(cosine) < in_plane_cosine)
    throw InputError(
        "annulus: the rule '" + annulus.sign_rule +
        "' does not tell the ventricular side, the direction lies in the annulus plane; give papillary points or a direction");
  if (cosine < 0) annulus.normal = -annulus.normal;
  return annulus;
}

AnteriorDirection find_anterior_direction(const Annulus& annulus, const std::vector<Vec3>& papillary_points,
                                          const std::optional<Vec3>& given) {
  AnteriorDirection result;
  if (given) {
    const Vec3 flat = in_plane(*given, annulus.normal);
    if (flat.norm() < 0.1 * given->norm() || !(given->norm() > 0))
      throw InputError("anterior direction: the given vector is (nearly) perpendicular to the annulus plane");
    result.direction = flat.normalized();
    result.rule = "given";
    result.confidence = flat.norm();
    return result;
  }
  const Papillary tips = group_papillary_points(papillary_points, annulus, annulus.axis_major);
  const Vec3 line = in_plane(tips.tips[1] - tips.tips[0], annulus.normal);
  if (line.norm() < 1e-3) throw InputError("anterior direction: the papillary tips lie above each other; give the direction");
  Vec3 candidate = annulus.normal.cross(line).normalized();
  const double offset = (0.5 * (tips.tips[0] + tips.tips[1]) - annulus.origin).dot(candidate);
  // Papillary tips stand posterior of the centre by several mm; less than this tells nothing.
  constexpr double tie = 0.5;
  if (std::abs(offset) >= tie) {
    result.direction = offset > 0 ? Vec3(-candidate) : candidate;
    result.rule = "papillary tips lie posterior";
    result.confidence = std::abs(offset);
    return result;
  }
  double height_ahead = 0, height_behind = 0;  // towards the atrium
  double best_ahead = -1e300, best_behind = -1e300;
  for (const Vec3& p : annulus.points) {
    const Vec3 d = p - annulus.origin;
    if (d.dot(candidate) > best_ahead) {
      best_ahead = d.dot(candidate);
      height_ahead = -d.dot(annulus.normal);
    }
    if (-d.dot(candidate) > best_behind) {
      best_behind = -d.dot(candidate);
      height_behind = -d.dot(annulus.normal);
    }
  }
  result.direction = height_ahead >= height_behind ? candidate : Vec3(-candidate);
  result.rule = "anterior horn is higher";
  result.confidence = std::abs(height_ahead - height_behind);
  return result;
}

Papillary group_papillary_points(const std::vector<Vec3>& points, const Annulus& annulus, const Vec3& anterior_direction) {
  if (points.size() < 2)
    throw InputError("papillary points: at least two are needed, " + std::to_string(points.size()) + " given");
  std::size_t a = 0, b = 0;
  double farthest = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = i + 1; j < points.size(); ++j)
      if ((points[i] - points[j]).norm() > farthest) {
        farthest = (points[i] - points[j]).norm();
        a = i;
        b = j;
      }
  if (!(farthest > 1e-3)) throw InputError("papillary points: all points coincide, two tips are needed");
  std::array<Vec3, 2> centre{points[a], points[b]};
  for (int iteration = 0; iteration < 100; ++iteration) {
    std::array<Vec3, 2> sum{Vec3::Zero(), Vec3::Zero()};
    std::array<int, 2> count{0, 0};
    for (const Vec3& p : points) {
      const std::size_t k = (p - centre[0]).squaredNorm() <= (p - centre[1]).squaredNorm() ? 0 : 1;
      sum[k] += p;
      ++count[k];
    }
    const std::array<Vec3, 2> next{sum[0] / count[0], sum[1] / count[1]};
    const bool settled = next[0] == centre[0] && next[1] == centre[1];
    centre = next;
    if (settled) break;
  }
  const Vec3 anterolateral_side = anterior_direction.cross(annulus.normal);
  if ((centre[0] - centre[1]).dot(anterolateral_side) < 0) std::swap(centre[0], centre[1]);
  return Papillary{{centre[0], centre[1]}, {"anterolateral", "posteromedial"}};
}

}  // namespace mv
