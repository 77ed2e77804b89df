// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Voxels over the part of the tube that holds the leaflets, their clearance, and exact values inside single voxels.
// All points in the tube frame, mm. Internal to solver/seal.

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "solver/seal/seal.h"
#include "solver/seal/triangle_set.h"

namespace mv::seal {

using Voxel = std::int32_t;

struct VoxelGrid {
  Vec3 lower = Vec3::Zero();
  double h = 0;
  std::array<int, 3> n{0, 0, 0};

  Voxel size() const { return n[0] * n[1] * n[2]; }
  Voxel at(int i, int j, int k) const { return (k * n[1] + j) * n[0] + i; }
  std::array<int, 3> indices(Voxel v) const { return {v % n[0], (v / n[0]) % n[1], v / (n[0] * n[1])}; }
  Vec3 centre(int i, int j, int k) const { return lower + h * Vec3(i + 0.5, j + 0.5, k + 0.5); }
  Vec3 centre(Voxel v) const {
    const auto c = indices(v);
    return centre(c[0], c[1], c[2]);
  }
  /// Calls visit(neighbour, direction 0-5) for the up to six face neighbours.
  template <class Visit>
  void neighbours(Voxel v, Visit&& visit) const {
    const auto c = indices(v);
    if (c[0] > 0) visit(v - 1, 0);
    if (c[0] + 1 < n[0]) visit(v + 1, 1);
    if (c[1] > 0) visit(v - n[0], 2);
    if (c[1] + 1 < n[1]) visit(v + n[0], 3);
    if (c[2] > 0) visit(v - n[0] * n[1], 4);
    if (c[2] + 1 < n[2]) visit(v + n[0] * n[1], 5);
  }
  Voxel step_back(Voxel v, int direction) const {
    const std::array<Voxel, 6> step{1, -1, n[0], -n[0], n[0] * n[1], -n[0] * n[1]};
    return v + step[static_cast<std::size_t>(direction)];
  }
};

/// Largest distance from a voxel's centre to its corners, in voxels.
inline constexpr double half_diagonal = 0.8660254037844387;
/// Largest distance from a point of a voxel to the nearest of its 27 samples, in voxels.
inline constexpr double sample_reach = half_diagonal / 3;

class VoxelField {
 public:
  /// Exact distances up to `exact_mm` from the leaflets, beyond that the distance to a nearby triangle (never too small).
  VoxelField(const SealInput& input, const SealOptions& options, double exact_mm);

  const VoxelGrid& grid() const { return grid_; }
  const TriangleSet& leaflets() const { return leaflets_; }
  Vec3 to_world(const Vec3& p) const { return origin_ + axes_.transpose() * p; }
  Vec3 direction_to_tube(const Vec3& d) const { return axes_ * d; }

  /// Signed distance from the voxel's centre to the leaflets' surface, positive outside the solid.
  float distance(Voxel v) const { return distance_[static_cast<std::size_t>(v)]; }
  /// Wall or outside the grid at a point.
  bool is_wall_at(const Vec3& p) const;
  bool is_wall(Voxel v) const { return wall_[static_cast<std::size_t>(v)] != 0; }
  /// Largest clearance over 27 samples in the voxel, at most `sample_reach` voxels below the peak; worked out once and kept.
  float sampled(Voxel v) const;
  bool is_known_peak(Voxel v) const { return peak_[static_cast<std::size_t>(v)] > -1e30f; }

  /// Largest clearance inside the voxel (0 when it lies wholly in the solid); worked out once and kept.
  float peak(Voxel v) const;
  /// Best value known without work: the peak when known, else the clearance at the centre.
  float cheap_peak(Voxel v) const;
  /// Upper bound of the peak without work.
  float peak_bound(Voxel v) const;
  /// peak(v) >= level, with an early way out.
  bool peak_reaches(Voxel v, double level) const;
  /// Where the peak is taken; the centre where it was not worked out.
  Vec3 peak_place(Voxel v) const;

  /// Share of the voxel outside the solid.
  double open_fraction(Voxel v) const;
  /// Share of the face towards the next voxel along `axis` that lies outside the solid.
  double open_face(Voxel v, int axis) const;

  /// Signed clearance at any point, exact up to `cap`.
  double clearance(const Vec3& p, double cap) const;
  /// Climbs from p to larger clearance inside a cube of half-width `reach` around `centre`.
  Vec3 climb(const Vec3& p, const Vec3& centre, double reach, double cap) const;

 private:
  struct Best {
    double value = 0;
    Vec3 place = Vec3::Zero();
  };
  void climb(const NearTriangles& near, const Vec3& centre, double reach, double cap, bool by_wall, Best& best) const;
  template <class Visit>
  void samples(Voxel v, NearTriangles& near, Visit&& visit, const double* best = nullptr) const;

  bool is_by_wall(Voxel v) const { return by_wall_[static_cast<std::size_t>(v % (grid_.n[0] * grid_.n[1]))] != 0; }
  bool is_in_section(const Vec3& p) const;
  void lay_grid(const SealInput& input, const SealOptions& options);
  void mark_wall(const SealInput& input, const SealOptions& options);
  void measure_near(double exact_mm, std::vector<int>& nearest);
  void measure_far(std::vector<int>& nearest);
  void find_inside();

  Vec3 origin_;
  Mat3 axes_;
  TriangleSet leaflets_;
  VoxelGrid grid_;
  std::vector<float> distance_;
  std::vector<std::uint8_t> wall_;
  std::vector<Vec2> section_;
  std::vector<std::uint8_t> by_wall_;  // per column: the wall passes through or near it
  mutable std::vector<float> peak_, sampled_;
  mutable std::unordered_map<Voxel, Vec3> peak_places_;
  mutable NearTriangles scratch_;
};

}  // namespace mv::seal
