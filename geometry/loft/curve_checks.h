// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// What is wrong with curves, before anything is fitted to them.

#include "geometry/loft/leaflet_curve.h"

namespace mv {

/// Removes repeated points and repeated curves (noted). Throws InputError naming curve and point for a coordinate that is not finite, fewer
/// than 3 distinct points, a length below 1 mm or above 150 mm (wrong unit), a step longer than half of the curve, or a curve that crosses itself.
void clean_curves(CurveSet& set);

/// Turns each curve so that it starts at the annulus; arches are left alone. Curves of which the source knows (is_hinge_first) stay. The others follow, in this order,
/// - the annulus, if it was drawn: the end closer to it is the hinge;
/// - their neighbours: a curve against the majority of the nearest ones is turned (noted);
/// - all together, if no curve is known: the papillary points lie beyond the free edge; without them the order of the file, or for curves
///   from images the wider of the two rings of ends, is the annulus.
/// Throws InputError when the evidence contradicts itself.
void orient_curves(CurveSet& set, bool is_order_meant);

/// Gives region-less curves their leaflet: curves of parallel slices fall on two sides of the annulus; the side with the longer
/// curves is the anterior leaflet (noted). Throws InputError when some curves have a region and others not, or sides cannot be told.
void assign_regions(CurveSet& set);

/// Two halves of an arch (CurveEnd::joined, same slice, ends nearest to each other) become one; what finds no partner stays joined.
/// The regions of the points of all curves, arches with two.
std::vector<std::vector<int>> join_arches(CurveSet& set);

}  // namespace mv
