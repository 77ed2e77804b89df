// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What a user asks of an instant: contact traction, chordae forces, net leak. SI.

#include "solver/output/series.h"
#include "solver/time/simulation.h"

namespace mv {

/// Contact on the atrial faces, one entry per leaflet point. What crosses the belt above the atrium's pressure is
///   traction = max(penalty, p(mid) - q(mid)) ,
/// p the blood's pressure halfway to the facing leaflet and q the pressure that the spread contact forces alone cause there. For flat sheets p - q is
/// the applied pressure whatever share the penalty carries: without contact forces p is the film's pressure; forces that push the faces apart lower
/// p(mid) by the part -q(mid) of themselves that the kernel resolves. Where sheets are curved or end within a kernel's width p - q falls short, but a film
/// cannot be below the atrium's pressure: the penalty is the lower bound, and the film is what the traction has above it (DESIGN, section 5).
struct ContactMeasure {
  std::vector<double> gap;              // m to the facing leaflet, NaN where nothing faces the point within the search distance, and at the hinge, whose fold is no coaptation
  std::vector<double> penalty;          // Pa
  std::vector<double> film;             // Pa, traction less penalty; with blood and in contact only
  std::vector<double> traction;         // Pa; without blood the penalty
  std::vector<Vec3> force;              // N, traction times current area, along the normal the point is pushed
  std::vector<char> in_contact;         // gap below the threshold
  double threshold = 0;                 // m
  double force_total = 0, penalty_total = 0, film_total = 0;  // N, across the interface, counted once
  double area = 0;                      // m2, counted once
};

/// Needs forces evaluated at the state (Simulation::refresh or the end of a step is near enough for the series). `is_quick` takes the gaps of
/// the last film search, at most some twenty steps old, where there are any: a new search costs as much as several steps.
ContactMeasure measure_contact(Simulation& simulation, const State& state, bool is_quick = false);

/// Row of series.csv except for limiter and net leak.
SeriesRow measure_series(Simulation& simulation, const State& state, const ContactMeasure& contact);

/// Leaflet points in the world frame, mm.
std::vector<Vec3> world_points(const Simulation& simulation, const State& state);

}  // namespace mv
