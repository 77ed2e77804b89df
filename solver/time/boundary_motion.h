// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What is done to the valve from outside during a run: annulus and papillary tips move, chordae are cut. A function of time alone, so that rollback
// and resume need no state of it.

#include <optional>
#include <span>
#include <vector>

#include "geometry/core/case.h"
#include "geometry/core/config.h"
#include "geometry/core/motion_table.h"
#include "solver/chordae/chordae_tension.h"

namespace mv {

class BoundaryMotion {
 public:
  /// From papillary.* and chordae.cut; `rest_tips` in m, tube frame. Throws ConfigError when a cut names no segment, InputError for a motion file that does
  /// not fit.
  BoundaryMotion(const Config& config, const Chordae& chordae, const Tube& tube, std::vector<Vec3> rest_tips);

  bool is_active() const { return shift_.squaredNorm() > 0 || table_ || !cut_.empty(); }

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
  std::optional<MotionTable> table_;  // of the tips, besides the shift
  Mat3 axes_ = Mat3::Identity();      // world to tube frame
  std::vector<int> cut_;
  double cut_time_ = 0;             // s
};

/// The annulus carried by a file (annulus.motion): every held node moves as the nearest place of the closed curve through the file's points does, linear
/// between two of them.
class AnnulusMotion {
 public:
  /// Throws InputError when a held node of the mesh does not lie on the curve (places_of_annulus).
  AnnulusMotion(MotionTable table, const LeafletMesh& mesh, const Tube& tube, const std::string& file);

  const std::vector<int>& nodes() const { return nodes_; }
  const MotionTable& table() const { return table_; }
  bool changes(double t0, double t1) const { return table_.changes(t0, t1); }
  /// Displacement (m, tube frame) of the i-th of nodes(), and of any place of the file's curve.
  Vec3 displacement(std::size_t i, double time) const { return displacement(places_[i], time); }
  Vec3 displacement(const MotionTable::Place& place, double time) const;

 private:
  MotionTable table_;
  Mat3 axes_;
  std::vector<int> nodes_;
  std::vector<MotionTable::Place> places_;
};

}  // namespace mv
