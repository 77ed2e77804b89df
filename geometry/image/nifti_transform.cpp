// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>

#include "geometry/core/errors.h"
#include "geometry/image/nifti.h"

namespace mv {
namespace {

constexpr double skewed = 1e-3;  // of the volume: axes some 2.5 degrees off

using Transform = Eigen::Matrix<double, 3, 4>;

[[noreturn]] void fail(const std::string& name, const std::string& what) { throw InputError(name + ": " + what); }

std::string text_of(const Transform& t) {
  std::string text;
  for (int r = 0; r < 3; ++r) text += fmt::format("\n    [{:10.5g} {:10.5g} {:10.5g} {:10.5g}]", t(r, 0), t(r, 1), t(r, 2), t(r, 3));
  return text;
}

Vec3 voxel_sizes(const NiftiHeader& h, const std::string& name) {
  const Vec3 sizes(h.pixdim[1], h.pixdim[2], h.pixdim[3]);
  for (int a = 0; a < 3; ++a)
    if (!std::isfinite(sizes[a]) || sizes[a] <= 0)
      fail(name, fmt::format("voxel size pixdim[{}] = {}: expected a positive length; correct the header", a + 1, sizes[a]));
  return sizes;
}

/// Quaternion (a, b, c, d) with a = sqrt(1 - b2 - c2 - d2); the third axis is turned round when qfac = pixdim[0] is negative.
Transform qform_of(const NiftiHeader& h, const std::string& name) {
  if (!h.quaternion.allFinite() || !h.q_offset.allFinite()) fail(name, "the qform is not finite: its quaternion or offset holds NaN or infinity");
  const double square = h.quaternion.squaredNorm();
  if (square > 1 + 1e-4) fail(name, fmt::format("the qform's quaternion is longer than 1 (b, c, d = {}, {}, {})", h.quaternion[0], h.quaternion[1], h.quaternion[2]));
  Vec3 v = h.quaternion;
  double a = 0;
  if (square < 1) a = std::sqrt(1 - square);
  else v /= std::sqrt(square);
  const double b = v[0], c = v[1], d = v[2];
  Mat3 turn;
  turn << a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c),  //
      2 * (b * c + a * d), a * a + c * c - b * b - d * d, 2 * (c * d - a * b),      //
      2 * (b * d - a * c), 2 * (c * d + a * b), a * a + d * d - b * b - c * c;
  Vec3 sizes = voxel_sizes(h, name);
  if (h.pixdim[0] < 0) sizes[2] = -sizes[2];
  Transform t;
  t << turn * sizes.asDiagonal(), h.q_offset;
  return t;
}

Transform sform_of(const NiftiHeader& h, const std::string& name) {
  if (!h.srow.allFinite()) fail(name, "the sform is not finite:" + text_of(h.srow));
  return h.srow;
}

Transform spacing_only(const NiftiHeader& h, const std::string& name) {
  Transform t;
  t << Mat3(voxel_sizes(h, name).asDiagonal()), Vec3::Zero();
  return t;
}

/// Largest distance between the places that two transforms give a corner of the image, over the smallest voxel size.
double corner_distance(const Transform& a, const Transform& b, const NiftiHeader& h) {
  double largest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector4d x(0, 0, 0, 1);
    for (int i = 0; i < 3; ++i)
      if (corner >> i & 1) x[i] = static_cast<double>(h.dim[static_cast<std::size_t>(i) + 1] - 1);
    largest = std::max(largest, ((a - b) * x).norm());
  }
  return largest / std::min(a.leftCols<3>().colwise().norm().minCoeff(), b.leftCols<3>().colwise().norm().minCoeff());
}

/// Degrees, of the rotation from the axes of one to those of the other.
double angle_between(const Transform& a, const Transform& b) {
  double largest = 0;
  for (int c = 0; c < 3; ++c) {
    const Vec3 u = a.col(c).normalized(), v = b.col(c).normalized();
    largest = std::max(largest, std::acos(std::clamp(u.dot(v), -1.0, 1.0)));
  }
  return largest * 180 / M_PI;
}

Transform agreed(const NiftiHeader& h, const NiftiOptions& options, const std::string& name, std::vector<std::string>& notes) {
  if (h.sform_code <= 0 && h.qform_code <= 0)
    fail(name, "has neither an sform nor a qform: left and right are unknown; write the orientation into the file, or set labels.transform = "
               "\"spacing\" if the voxel axes are known to point right, anterior and superior");
  if (h.sform_code <= 0) {
    notes.push_back("orientation from the qform; there is no sform");
    return qform_of(h, name);
  }
  const Transform s = sform_of(h, name);
  if (h.qform_code > 0) {
    const Transform q = qform_of(h, name);
    const double distance = corner_distance(s, q, h);
    if (!(distance <= options.agreement))
      fail(name, fmt::format("sform and qform disagree: corners of the image differ by {:.3g} voxels (limit {}), axes by {:.3g} degrees\n  sform:{}\n  qform:{}\n"
                             "  Find out which is right and set labels.transform = \"sform\" or \"qform\"",
                             distance, options.agreement, angle_between(s, q), text_of(s), text_of(q)));
    return s;
  }
  const Vec3 sizes(h.pixdim[1], h.pixdim[2], h.pixdim[3]);
  const Vec3 from_s = s.leftCols<3>().colwise().norm();
  if (!((sizes.array().abs() - from_s.array()).abs() <= 0.01 * from_s.array()).all())
    fail(name, fmt::format("voxel sizes disagree: {:.4g} x {:.4g} x {:.4g} by pixdim, {:.4g} x {:.4g} x {:.4g} by the sform:{}\n"
                           "  Find out which is right and set labels.transform = \"sform\" or \"spacing\"",
                           sizes[0], sizes[1], sizes[2], from_s[0], from_s[1], from_s[2], text_of(s)));
  notes.push_back("orientation from the sform; there is no qform");
  return s;
}

double unit_in_mm(const NiftiHeader& h, const NiftiOptions& options, const std::string& name, std::vector<std::string>& notes) {
  if (options.unit == "mm") return 1;
  if (options.unit == "m") return 1000;
  if (options.unit == "um") return 1e-3;
  switch (h.units & 7) {
    case 1: return 1000;
    case 2: return 1;
    case 3: return 1e-3;
    case 0: notes.push_back("the file names no unit of length: mm assumed (labels.unit chooses another)"); return 1;
    default: fail(name, fmt::format("unknown unit of length (xyzt_units = {}): NIfTI knows 1 = m, 2 = mm, 3 = um; set labels.unit", h.units));
  }
}

}  // namespace

Transform nifti_transform(const NiftiHeader& h, const NiftiOptions& options, const std::string& name, std::vector<std::string>& notes) {
  if (options.transform == "sform" && h.sform_code <= 0) fail(name, "labels.transform = \"sform\", but the file has no sform (code 0)");
  if (options.transform == "qform" && h.qform_code <= 0) fail(name, "labels.transform = \"qform\", but the file has no qform (code 0)");
  Transform t = options.transform == "sform"     ? sform_of(h, name)
                : options.transform == "qform"   ? qform_of(h, name)
                : options.transform == "spacing" ? spacing_only(h, name)
                                                 : agreed(h, options, name, notes);
  t *= unit_in_mm(h, options, name, notes);
  const Vec3 sizes = t.leftCols<3>().colwise().norm();
  const double product = sizes.prod(), determinant = t.leftCols<3>().determinant();
  if (!(std::abs(determinant) > 1e-3 * product))
    fail(name, "the voxel axes are singular (two coincide, or one has no length), so the image has no volume:" + text_of(t));
  if (std::abs(determinant) < (1 - skewed) * product)
    notes.push_back(fmt::format("the voxel axes are not at right angles (volume of a voxel {:.1f} % below that of its edges): the valve is deformed if that is not meant", 100 * (1 - std::abs(determinant) / product)));
  if (determinant < 0) notes.push_back("left-handed voxel axes (negative determinant), as in radiological order");
  return t;
}

}  // namespace mv
