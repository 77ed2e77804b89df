// SPDX-License-Identifier: BSD-3-Clause
#include "solver/time/boundary_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "geometry/core/errors.h"

namespace mv {
namespace {
constexpr double metres_per_mm = 1e-3;
}

BoundaryMotion::BoundaryMotion(const Config& config, const Chordae& chordae, const Tube& tube, std::vector<Vec3> rest_tips)
    : rest_tips_(std::move(rest_tips)),
      start_(config.number("papillary.move_start")),
      duration_(config.number("papillary.move_time")),
      cut_time_(config.number("chordae.cut_time")) {
  axes_ = tube.axes;
  if (!config.text("papillary.motion").empty()) {
    const auto file = config.path("papillary.motion");
    table_ = MotionTable::read(file);
    if (table_->points() != static_cast<int>(rest_tips_.size()))
      throw InputError(fmt::format("{}: holds {} points, the case has {} papillary tips", file.string(), table_->points(), rest_tips_.size()));
  }
  shift_ = tube.axes * Vec3::Map(config.numbers("papillary.displacement").data());
  for (double segment : config.numbers("chordae.cut")) {
    cut_.push_back(static_cast<int>(segment));
    if (cut_.back() >= static_cast<int>(chordae.segments.size()))
      throw ConfigError(fmt::format("chordae.cut: there is no segment {}; the case has {}, counted from 0", cut_.back(), chordae.segments.size()));
  }
}

double BoundaryMotion::progress(double time) const {
  if (time <= start_) return 0;
  if (time >= start_ + duration_) return 1;
  return 0.5 * (1 - std::cos(M_PI * (time - start_) / duration_));
}

bool BoundaryMotion::changes(double t0, double t1) const {
  return is_cut(t0) != is_cut(t1) || (shift_.squaredNorm() > 0 && progress(t0) != progress(t1)) || (table_ && table_->changes(t0, t1));
}

void BoundaryMotion::apply(double time, ChordaeTension& chordae, std::span<Vec3> tips) const {
  const double share = progress(time);
  for (std::size_t t = 0; t < tips.size(); ++t) {
    tips[t] = rest_tips_[t] + share * shift_;
    if (table_) tips[t] += metres_per_mm * (axes_ * table_->displacement(static_cast<int>(t), time));
  }
  if (!cut_.empty()) chordae.set_cut(cut_, is_cut(time));
}

AnnulusMotion::AnnulusMotion(MotionTable table, const LeafletMesh& mesh, const Tube& tube, double reach, const std::string& file)
    : table_(std::move(table)), axes_(tube.axes) {
  const std::vector<Vec3>& curve = table_.rest();
  const int n = table_.points();
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    if (!mesh.on_annulus[i]) continue;
    Place best{0, 0, 0};
    double nearest = 1e300;
    for (int a = 0; a < n; ++a) {
      const int b = (a + 1) % n;
      const Vec3 along = curve[static_cast<std::size_t>(b)] - curve[static_cast<std::size_t>(a)], to = mesh.points[i] - curve[static_cast<std::size_t>(a)];
      const double length2 = along.squaredNorm();
      const double share = length2 > 0 ? std::clamp(to.dot(along) / length2, 0.0, 1.0) : 0.0;
      const double distance = (to - share * along).norm();
      if (distance < nearest) nearest = distance, best = {a, b, share};
    }
    if (!(nearest <= reach))
      throw InputError(fmt::format("{}: annulus node {} at ({:.2f}, {:.2f}, {:.2f}) mm lies {:.2f} mm from the curve through the file's points, at most {:.2f} mm is expected; is the "
                                   "file of this valve, in mm and in the same frame, with its points in order round the annulus?",
                                   file, i, mesh.points[i].x(), mesh.points[i].y(), mesh.points[i].z(), nearest, reach));
    nodes_.push_back(static_cast<int>(i));
    places_.push_back(best);
  }
}

Vec3 AnnulusMotion::displacement(std::size_t i, double time) const {
  const Place& p = places_[i];
  const Vec3 u = (1 - p.share) * table_.displacement(p.a, time) + (p.share > 0 ? p.share : 0.0) * table_.displacement(p.b, time);
  return metres_per_mm * (axes_ * u);
}

}  // namespace mv
