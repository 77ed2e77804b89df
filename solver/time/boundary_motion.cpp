// SPDX-License-Identifier: BSD-3-Clause
#include "solver/time/boundary_motion.h"

#include <fmt/format.h>

#include <cmath>

#include "geometry/core/errors.h"

namespace mv {

BoundaryMotion::BoundaryMotion(const Config& config, const Chordae& chordae, const Tube& tube, std::vector<Vec3> rest_tips)
    : rest_tips_(std::move(rest_tips)),
      start_(config.number("papillary.move_start")),
      duration_(config.number("papillary.move_time")),
      cut_time_(config.number("chordae.cut_time")) {
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
  return is_cut(t0) != is_cut(t1) || (shift_.squaredNorm() > 0 && progress(t0) != progress(t1));
}

void BoundaryMotion::apply(double time, ChordaeTension& chordae, std::span<Vec3> tips) const {
  const double share = progress(time);
  for (std::size_t t = 0; t < tips.size(); ++t) tips[t] = rest_tips_[t] + share * shift_;
  if (!cut_.empty()) chordae.set_cut(cut_, is_cut(time));
}

}  // namespace mv
