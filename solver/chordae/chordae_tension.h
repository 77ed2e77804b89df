// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Chordae as tension-only springs (papers/s0: articulated so that they bear no compression), linear or by a law (chorda_law.h):
//   T = E A / L0 * max(L - L0, 0),      T = A P(L / L0) for L > L0.
// A leaflet end is a point at sum_i w_i x_i of leaflet nodes and hands its force back with the same weights, so that force and
// moment about the end are preserved; a root rides on its papillary tip at a fixed offset (roots spread over the muscle); every other point
// of the tree is a node of its own.

#include <Eigen/Core>
#include <array>
#include <functional>
#include <span>
#include <vector>

#include "geometry/core/case.h"
#include "solver/chordae/chorda_law.h"

namespace mv {

class ChordaeTension {
 public:
  /// `chordae` in mm; `first_free_node` is the index of the node that stands for the first branch point; stiffness in Pa.
  ChordaeTension(const Chordae& chordae, int first_free_node, double youngs_modulus);
  /// The law of each segment, by ChordaSegment::leaflet.
  ChordaeTension(const Chordae& chordae, int first_free_node, const std::function<ChordaLaw(int leaflet)>& law_of);

  /// Offset (m, solver's frame) of every root from its papillary tip; entries of other points are not used. Without a call: zero.
  void set_root_offsets(std::vector<Eigen::Vector3d> offsets) { offsets_ = std::move(offsets); }

  /// Points of the tree that move on their own (neither root nor leaflet end), in the order of their nodes.
  const std::vector<int>& free_points() const { return free_points_; }

  /// Adds the tensions to `forces` (N) at the node positions x (m) and tip positions (m); returns the elastic energy (J). No allocation.
  double forces(std::span<const double> x, std::span<const Eigen::Vector3d> tips, std::span<double> forces);

  /// Elastic energy (J) at these positions, without touching anything.
  double energy(std::span<const double> x, std::span<const Eigen::Vector3d> tips);

  /// Cuts segments, or makes them whole again. A cut segment carries nothing.
  void set_cut(std::span<const int> segments, bool is_cut);

  /// Adds K v of the taut segments, K = -dF/dx at x with tips held.
  void stiffness_times(std::span<const double> x, std::span<const Eigen::Vector3d> tips, std::span<const double> v, std::span<double> out);

  /// Of the last forces() call: tension (N) per segment and pull (N) on each papillary tip (towards the leaflets).
  const std::vector<double>& tensions() const { return tensions_; }
  const std::vector<Eigen::Vector3d>& papillary_forces() const { return papillary_forces_; }

  /// Adds to each node the stiffness (N/m) at rest of the segments it holds, at leaflet ends in the shares of the insertion.
  void add_rest_stiffness(std::span<double> node_stiffness) const;

  /// Positions (m) of all points of the tree.
  void point_positions(std::span<const double> x, std::span<const Eigen::Vector3d> tips, std::vector<Eigen::Vector3d>& out) const;

 private:
  void gather(std::span<const double> x, std::span<const Eigen::Vector3d> tips, std::vector<Eigen::Vector3d>& out) const;
  void scatter(const std::vector<Eigen::Vector3d>& point_forces, std::span<double> out) const;

  struct Segment {
    int a, b;
    double rest_length;  // m
    double area;         // m2, 0 when cut
    double whole_area;   // m2, its area when not cut
    int law;             // index into laws_
  };
  std::vector<Segment> segments_;
  std::vector<ChordaLaw> laws_;
  std::vector<int> muscle_;            // per point, -1 when not a root
  std::vector<Eigen::Vector3d> offsets_;  // per point, of roots from their tips; empty: none
  std::vector<int> node_;              // per point: own node or -1
  std::vector<int> free_points_;
  std::vector<Insertion> insertions_;
  std::vector<double> tensions_;
  std::vector<Eigen::Vector3d> papillary_forces_;
  std::vector<Eigen::Vector3d> positions_, moved_, point_forces_;
};

}  // namespace mv
