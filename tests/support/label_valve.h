// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// A valve of known shape as a label map: cone frustum on an ellipse, walls of atrium and ventricle that meet at its annulus, two papillary
// muscles, in any pose and on any voxels. Labels as in the preset visible_human.

#include "support/nifti_bytes.h"

namespace mv::test {

struct LabelValve {
  double a = 18, b = 14;       // mm, half axes of the annulus (x along the commissures, y anterior)
  double slope = 0.35;         // inward run over drop
  double anterior_height = 16, posterior_height = 10, commissure_height = 6;
  double thickness = 1.6;
  Mat3 turn = Mat3::Identity();  // of the valve into the world
  Vec3 centre = Vec3::Zero();    // of the annulus in the world
  bool has_walls = true, has_muscles = true;
  int posterior = 1, anterior = 2;

  Vec3 world(const Vec3& local) const { return turn * local + centre; }
  Vec3 annulus_at(double angle) const { return world(Vec3(a * std::cos(angle), b * std::sin(angle), 0)); }
  Vec3 tip(double side) const { return world(Vec3(side * 9, -2, -24)); }
  double height_at(double angle) const {
    const double s = std::sin(angle), far = s > 0 ? anterior_height : posterior_height;
    return commissure_height + (far - commissure_height) * s * s;
  }

  /// Label at a place of the world. The valve hangs towards -z of its own frame; the leaflets' mid-surface begins at the annulus.
  double label_at(const Vec3& x) const {
    const Vec3 p = turn.transpose() * (x - centre);
    const double angle = std::atan2(p.y() / b, p.x() / a);
    const double drop = -p.z();
    // distance from the ellipse of this height, to first order; it vanishes on the axis too
    const double shrink = slope * std::max(drop, 0.0);
    const double ax = a - shrink, by = b - shrink;
    const double f = std::hypot(p.x() / ax, p.y() / by), g = std::hypot(p.x() / (ax * ax), p.y() / (by * by));
    const double outward = (f - 1) * f / std::max(g, 1e-9) / std::sqrt(1 + (drop > 0 ? slope * slope : 0));
    if (f > 0.1 && drop >= 0 && drop <= height_at(angle) && std::abs(outward) <= thickness / 2) return p.y() > 0 ? anterior : posterior;
    if (has_walls) {
      const double from_annulus = (std::hypot(p.x() / a, p.y() / b) - 1) * std::min(a, b);
      if (from_annulus > 0.3 && from_annulus < 5 && drop >= 0.6 && drop < 20) return 6;
      if (from_annulus > -1 && from_annulus < 4 && drop < 0 && drop > -8) return 5;
    }
    if (has_muscles)
      for (const double side : {-1.0, 1.0}) {
        const Vec3 d = p - Vec3(side * 9, -2, -24);
        if (d.z() <= 0 && d.z() > -12 && std::hypot(d.x(), d.y()) <= 2.5) return side < 0 ? 3 : 4;
      }
    return 0;
  }

  /// Voxels of these sizes (mm) around the whole, axes turned by `voxel_turn`.
  NiftiFile voxels(const Vec3& size, const Mat3& voxel_turn = Mat3::Identity(), double half_width = 27, double up = 6, double down = 30) const {
    NiftiFile f;
    const Mat3 axes = voxel_turn * size.asDiagonal();
    // box that holds the turned valve
    Vec3 low = Vec3::Constant(1e300), high = -low;
    const Mat3 inverse = axes.inverse();
    for (int c = 0; c < 8; ++c) {
      const Vec3 corner(c & 1 ? half_width : -half_width, c & 2 ? half_width : -half_width, c & 4 ? up : -down);
      const Vec3 v = inverse * world(corner);
      low = low.cwiseMin(v), high = high.cwiseMax(v);
    }
    const Vec3 first = low.array().floor();
    f.set_size(static_cast<int>(high.x() - first.x()) + 2, static_cast<int>(high.y() - first.y()) + 2, static_cast<int>(high.z() - first.z()) + 2);
    f.place(axes, axes * first);
    voxelise(f, [&](const Vec3& x) { return label_at(x); });
    return f;
  }
};

}  // namespace mv::test
