// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What is done to the valve from outside during a run: papillary tips move, chordae are cut. A function of time alone, so that rollback
// and resume need no state of it.

#include <span>
#include <vector>

#include "geometry/core/case.h"
#include "geometry/core/config.h"
#include "solver/chordae/chordae_tension.h"

namespace mv {

class BoundaryMotion {
 public:
  /// From papillary.* and chordae.cut; `rest_tips` in m, tube frame. Throws ConfigError when a cut names no segment.
  BoundaryMotion(const Config& config, const Chordae& chordae, const Tube& tube, std::vector<Vec3> rest_tips);

  bool is_active() const { return shift_.squaredNorm() > 0 || !cut_.empty(); }

  /// Whether anything differs between two instants.
  bool changes(double t0, double t1) const;

  /// Sets the chordae and the tips (m) to what they are at `time` (s).
  void apply(double time, ChordaeTension& chordae, std::span<Vec3> tips) const;

 private:
  double progress(double time) const;  // 0 before the movement, 1 after it
  bool is_cut(double time) const { return !cut_.empty() && time > cut_time_; }

  std::vector<Vec3> rest_tips_;
  Vec3 shift_ = Vec3::Zero();       // m, tube frame
  double start_ = 0, duration_ = 0; // s
  std::vector<int> cut_;
  double cut_time_ = 0;             // s
};

}  // namespace mv
