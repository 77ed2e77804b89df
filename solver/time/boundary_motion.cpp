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
    std::vector<Vec3> tips;
    for (const Vec3& tip : rest_tips_) tips.push_back(tube.origin + tube.axes.transpose() * (tip / metres_per_mm));
    table_->check_tips(tips, file.string());
    table_->check_course(file.string());
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

AnnulusMotion::AnnulusMotion(MotionTable table, const LeafletMesh& mesh, const Tube& tube, const std::string& file)
    : table_(std::move(table)), axes_(tube.axes), places_(table_.places_of_annulus(mesh, file)) {
  table_.check_course(file);
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    if (mesh.on_annulus[i]) nodes_.push_back(static_cast<int>(i));
}

Vec3 AnnulusMotion::displacement(const MotionTable::Place& place, double time) const { return metres_per_mm * (axes_ * table_.displacement(place, time)); }

}  // namespace mv
