// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What a reader needs to find his way on the unfolded valve: outline, outline of the belt, names of scallops and commissures, and
// the map's values on a regular grid.

#include <optional>
#include <string>
#include <vector>

#include "solver/output/contact_map.h"
#include "solver/output/frame_reader.h"

namespace mv {

struct MapLabel {
  std::string name;     // "A2", "P1", "anterolateral commissure"
  double u = 0, v = 0;  // mm, middle of the part; v = 0 for a commissure
  bool is_commissure = false;
};

/// (u, v) polyline; closed ones repeat their first point.
using MapLine = std::vector<Vec2>;

/// Values on cells of size `step`, row by row in v, NaN outside the leaflets.
struct MapGrid {
  double u0 = 0, v0 = 0, step = 0;  // middle of the first cell, mm
  int columns = 0, rows = 0;
  std::vector<double> pressure;  // kPa
  std::vector<double> gap;       // mm
  std::vector<int> region;       // 0 outside
};

struct MapView {
  Vec2 lower = Vec2::Zero(), upper = Vec2::Zero();
  std::vector<MapLine> outline;      // boundary of the map
  std::vector<MapLine> belt;         // around in_belt, or around pressure > 0 when the map does not carry the belt
  std::vector<MapLine> commissures;  // lines between the leaflets
  std::vector<MapLabel> labels;
};

/// `open` and `chordae` (at rest) tell the anterolateral end: the commissure nearer to muscle 0. Without them parts are numbered
/// along u and commissures stay unnamed.
MapView make_map_view(const ContactMap& map, const std::optional<LeafletsFrame>& open,
                      const std::optional<ChordaeFrame>& chordae);

MapGrid sample_map(const ContactMap& map, double step);

/// Smallest number of the row 1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8 times a power of ten that is not below x; 1 for x <= 0.
double round_up_nicely(double x);

}  // namespace mv
