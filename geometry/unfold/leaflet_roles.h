// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Commissures, and which leaflet is the anterior one. Internal to mv_unfold.

#include <optional>
#include <string>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

/// The ring seen along its annulus. u in [0, period), counter-clockwise seen from the atrium.
struct Outline {
  double period = 0;
  std::vector<double> height;       // mm, at equal steps of u: length of the leaflet below the annulus there
  std::vector<Vec2> direction;      // at the same u: unit, in the annulus plane, from its centre to the annulus
  // Area of the triangles labelled anterior minus those labelled posterior, mm2, in the same bins; near the annulus, near the free edge, all.
  std::vector<double> label_annulus, label_free_edge, label_all;
  double labelled_area = 0;         // mm2
};

/// What speaks for one side or the other. Directions in the coordinates of Outline::direction.
struct AnteriorEvidence {
  std::optional<Vec2> hint;       // towards the given anterior point
  std::optional<Vec2> papillary;  // by the papillary line rule
  std::string papillary_rule;
};

struct Commissures {
  double annulus_begin = 0, annulus_end = 0;      // u; the anterior leaflet is [begin, end) counter-clockwise
  double free_edge_begin = 0, free_edge_end = 0;  // natural u of the free edge's points that belong to them
  std::string rule;
};

/// `given`: u of two commissures, or empty. has_regions: labels tell two leaflets apart; has_names: and say which is anterior. Shape rules: the anterior
/// leaflet is longer radially and on less of the annulus. Names that the evidence contradicts are swapped with a note, or an InputError when the evidence
/// is itself at odds. Throws InputError when nothing tells the leaflets apart.
Commissures find_commissures(const Outline& outline, const std::vector<double>& given, bool has_regions, bool has_names,
                             const AnteriorEvidence& evidence, std::vector<std::string>& notes);

/// Local minima of a periodic function by at least `prominence` (absolute), indices in order.
std::vector<int> periodic_minima(const std::vector<double>& values, double prominence);

}  // namespace mv
