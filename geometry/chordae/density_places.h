// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Random but reproducible places for leaflet ends. Internal to mv_chordae_geometry.

#include <random>
#include <vector>

#include "geometry/chordae/coapted_shape.h"
#include "geometry/chordae/density_chordae.h"
#include "geometry/chordae/leaflet_chart.h"

namespace mv {

/// The same numbers on every platform: std distributions are not specified bit by bit.
class Dice {
 public:
  explicit Dice(unsigned seed) : engine_(seed) {}
  double unit() { return static_cast<double>(engine_() >> 8) * 0x1p-24; }  // [0, 1)

 private:
  std::mt19937 engine_;
};

struct BorderSite {
  double arc = 0;  // mm along the border
  bool is_junction = false;
};

/// One site a junction, the others by density. Fewer where min_distance leaves no room (noted).
std::vector<BorderSite> border_sites(const LeafletChart& chart, const DensityOptions& options, Dice& dice, DensityReport& report);

/// The triangles of the atrial face whose middle lies between area_from and area_to of the local height, with their areas on the
/// mid-surface.
class InnerArea {
 public:
  InnerArea(const LeafletMesh& mesh, const LeafletChart& chart, double from, double to);
  double area() const { return cumulative_.empty() ? 0.0 : cumulative_.back(); }  // mm2
  Vec2 random_uv(Dice& dice) const;

 private:
  std::vector<std::array<Vec2, 3>> triangles_;
  std::vector<double> cumulative_;
};

/// The candidate farthest from everything in `taken`, or nothing when all are nearer than `distance`.
std::optional<Vec2> spread_place(const InnerArea& area, const LeafletChart& chart, const std::vector<Vec3>& taken, double distance, Dice& dice);

}  // namespace mv
